"""Execute: the jobs of a study that are still to do, each in a process of its own, several at once on this machine."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from instances.code import code_digest
from instances.errors import InputError, suggestion
from reports.record import Run
from workbench.jobs.job import Job, folder_of
from workbench.jobs.machine import environment, environment_digest, usable_memory
from workbench.jobs.problem import Problem
from workbench.jobs.runner import run
from workbench.jobs.store import Store
from workbench.jobs.study import Study

Finished = Callable[[Job, Run], None]


STALE = "STALE"
"""What `plan` is asked to run again where other code than today's made the stored run."""


@dataclass(frozen=True)
class Plan:
    """A study's jobs in order: all of them, those still to do, what is wrong with damaged files in their place.

    stale : how many stored runs other code than today's made.
    """

    jobs: tuple[Job, ...]
    todo: tuple[Job, ...]
    damaged: tuple[str, ...]
    stale: int

    def shard(self, number: int, count: int) -> Plan:
        """Return part `number` (from 1) of `count`, the same at every call: every count-th job."""
        mine = self.jobs[number - 1 :: count]
        chosen = {job.path for job in mine}
        return replace(self, jobs=mine, todo=tuple(job for job in self.todo if job.path in chosen))


def statuses_to_retry(problem: Problem[Any], named: Collection[str]) -> list[str]:
    """Return what `plan` runs again, for the statuses a user named; InputError for one that no run ends with."""
    known = {name.lower(): name.upper() for name in ("error", "killed", "no_solution", *problem.statuses, STALE)}
    for name in named:
        if name.lower() not in known:
            raise InputError(f"--retry: '{name}' is no status{suggestion(name.lower(), known)}")
    return [known[name.lower()] for name in named]


def jobs_of(study: Study, keep: Callable[[Any], object] = lambda item: None) -> tuple[Job, ...]:
    """Return every job of `study`, item by item; `keep` is given each item as it is made."""
    if not study.sources:
        raise InputError(f"study {study.name}: names no {study.problem.item}s; give files, folders or [[families]]")
    jobs: dict[str, Job] = {}
    for source in study.sources:
        item = source.load()
        keep(item)
        for entry in study.entries:
            for job in entry.jobs(folder_of(item), study.problem.size(item)):
                jobs.setdefault(job.path, job)
    return tuple(jobs.values())


def plan(jobs: Iterable[Job], store: Store, retry: Collection[str] = ()) -> Plan:
    """Return what is still to do: what has no file, and what ended with a status in `retry`, or is STALE."""
    jobs, todo, damaged, stale = tuple(jobs), [], [], 0
    for job in jobs:
        if not store.has(job):
            todo.append(job)
            continue
        try:
            stored = store.get(job.path)
        except InputError as error:
            damaged.append(str(error))
            continue
        old = stored.code != code_digest()
        stale += old
        if stored.status.upper() in retry or (old and STALE in retry):
            todo.append(job)
    return Plan(jobs, tuple(todo), tuple(damaged), stale)


def run_locally(problem: Problem[Any], jobs: Iterable[Job], store: Store, parallel: int, finished: Finished) -> None:
    """Run `jobs`, `parallel` at once, storing each as it ends; on Ctrl-C or the like kill what runs."""
    stop = threading.Event()
    memory_limit = usable_memory() // parallel
    read = lru_cache(maxsize=4)(lambda folder: problem.read(store.root / folder))
    store.put_environment(environment_digest(environment()), environment())

    def one(job: Job) -> Run:
        result = run(problem, job, read(job.folder), memory_limit=memory_limit, stop=stop.is_set)
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
