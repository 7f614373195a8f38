"""Execute: the jobs of a study that are still to do, each in a process of its own, several at once on this machine."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from functools import lru_cache

from formulations.routing.solver import Status
from instances import InputError, Instance
from workbench.job import Job, folder_of
from workbench.machine import environment, environment_digest, usable_memory
from workbench.run import Run
from workbench.runner import run
from workbench.store import Store
from workbench.study import Study

Finished = Callable[[Job, Run], None]


@dataclass(frozen=True)
class Plan:
    """A study's jobs in order: all of them, those still to do, and what is wrong with damaged files in their place."""

    jobs: tuple[Job, ...]
    todo: tuple[Job, ...]
    damaged: tuple[str, ...]

    def shard(self, number: int, count: int) -> Plan:
        """Return part `number` (from 1) of `count`, the same at every call: every count-th job."""
        mine = self.jobs[number - 1 :: count]
        chosen = {job.path for job in mine}
        return Plan(mine, tuple(job for job in self.todo if job.path in chosen), self.damaged)


def jobs_of(study: Study, keep: Callable[[Instance], object] = lambda instance: None) -> tuple[Job, ...]:
    """Return every job of `study`, instance by instance; `keep` is given each instance as it is made."""
    if not study.sources:
        raise InputError(f"study {study.name}: names no instances; give files, folders or [[families]]")
    jobs: dict[str, Job] = {}
    for source in study.sources:
        instance = source.load()
        keep(instance)
        for entry in study.entries:
            for job in entry.jobs(folder_of(instance), int(instance.n_tasks)):
                jobs.setdefault(job.path, job)
    return tuple(jobs.values())


def plan(jobs: Iterable[Job], store: Store, retry: Collection[Status] = ()) -> Plan:
    """Return what is still to do: what has no file, and what ended with a status in `retry`."""
    jobs, todo, damaged = tuple(jobs), [], []
    for job in jobs:
        if not store.has(job):
            todo.append(job)
            continue
        try:
            if store.get(job.path).status in retry:
                todo.append(job)
        except InputError as error:
            damaged.append(str(error))
    return Plan(jobs, tuple(todo), tuple(damaged))


def run_locally(jobs: Iterable[Job], store: Store, parallel: int, finished: Finished) -> None:
    """Run `jobs`, `parallel` at once, storing each as it ends; on Ctrl-C or the like kill what runs."""
    stop = threading.Event()
    memory_limit = usable_memory() // parallel
    read = lru_cache(maxsize=4)(store.instance)
    store.put_environment(environment_digest(environment()), environment())

    def one(job: Job) -> Run:
        result = run(job, read(job.folder), memory_limit=memory_limit, stop=stop.is_set)
        store.put(job.path, result)
        return result

    with ThreadPoolExecutor(parallel) as pool:
        pending = {pool.submit(one, job): job for job in jobs}
        try:
            for future in as_completed(pending):
                finished(pending[future], future.result())
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
