"""Execute: the jobs of a study that are still to do, each in a process of its own, several at once on this machine."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from queue import SimpleQueue
from typing import Any

from instances.code import revision
from instances.errors import InputError, suggestion
from reports.numbers import counted
from reports.record import Run
from workbench.jobs.backlog import Backlog, Progress
from workbench.jobs.job import Job, folder_of
from workbench.jobs.machine import environment, environment_digest, usable_memory
from workbench.jobs.problem import Problem, Source
from workbench.jobs.process.orphans import adopt
from workbench.jobs.runner import run
from workbench.jobs.store import Store, Version
from workbench.jobs.study import Study

STALE = "STALE"
"""What `plan` is asked to run again where other code than today's made the stored run."""
DAMAGED = "DAMAGED"
"""What `plan` is asked to run again where what is stored cannot be read as the run it should be."""
SWIFT = 1.0
"""Seconds an interrupted study waits for what it runs to be killed; what is left then dies with this process."""


@dataclass(frozen=True)
class Plan:
    """A study's jobs in order: all of them, those still to do, what is wrong with damaged files left in their place.

    stale : how many stored runs other code than today's made. seen : which file lay in the place of each job that is
    run again.
    """

    jobs: tuple[Job, ...]
    todo: tuple[Job, ...]
    damaged: tuple[str, ...]
    stale: int
    seen: Mapping[str, Version | None] = field(default_factory=dict)

    def shard(self, number: int, count: int) -> Plan:
        """Return part `number` (from 1) of `count`, the same at every call: every count-th job."""
        mine = self.jobs[number - 1 :: count]
        chosen = {job.path for job in mine}
        return replace(self, jobs=mine, todo=tuple(job for job in self.todo if job.path in chosen))


def statuses_to_retry(problem: Problem[Any], named: Collection[str]) -> list[str]:
    """Return what `plan` runs again, for the statuses a user named; InputError for one that no run ends with."""
    endings = ("error", "killed", "no_solution", *problem.statuses, STALE, DAMAGED)
    known = {name.lower(): name.upper() for name in endings}
    for name in named:
        if name.lower() not in known:
            raise InputError(f"--retry: '{name}' is no status{suggestion(name.lower(), known)}")
    return [known[name.lower()] for name in named]


def jobs_of(study: Study, keep: Callable[[str, Source[Any]], object] = lambda folder, source: None) -> tuple[Job, ...]:
    """Return every job of `study`, item by item; `keep` is given the folder and the source of each item."""
    if not study.sources:
        raise InputError(f"study {study.name}: names no {study.problem.item}s; give files, folders or [[families]]")
    jobs: dict[str, Job] = {}
    for source in study.sources:
        item = source.load()
        folder = folder_of(item)
        keep(folder, source)
        for entry in study.entries:
            for job in entry.jobs(folder, study.problem.size(item)):
                jobs.setdefault(job.path, job)
    return tuple(jobs.values())


def plan(jobs: Iterable[Job], store: Store, retry: Collection[str] = ()) -> Plan:
    """Return what is still to do: what has no file, and what ended with a status in `retry`, or is STALE or DAMAGED."""
    jobs, todo, damaged, stale, seen = tuple(jobs), [], [], 0, {}
    for job in jobs:
        version = store.version(job.path)
        if version is None:
            todo.append(job)
            continue
        try:
            stored = store.get(job.path)
        except InputError as error:
            again = DAMAGED in retry
            if not again:
                damaged.append(str(error))
        else:
            old = stored.stale
            stale += old
            again = stored.status.upper() in retry or (old and STALE in retry)
        if again:
            todo.append(job)
            seen[job.path] = version
    return Plan(jobs, tuple(todo), tuple(damaged), stale, seen)


def shortfall(jobs: Iterable[Job], store: Store) -> list[str]:
    """Return what a finished study falls short of, a sentence each: runs that ended in ERROR, runs not stored."""
    failed = missing = 0
    for job in jobs:
        with contextlib.suppress(InputError):
            missing += not store.has(job)
            failed += store.has(job) and store.get(job.path).status == "ERROR"
    found = [f"{counted(failed, 'run')} ended in ERROR"] if failed else []
    return found + ([f"{counted(missing, 'run')} missing: the same command runs what is missing"] if missing else [])


def run_locally(
    backlog: Backlog, problem: Problem[Any], parallel: int, progress: Progress, memory_limit: int | None = None
) -> list[str]:
    """Run the jobs of `backlog`, `parallel` at once, storing each as it ends; on Ctrl-C or the like kill what runs.

    memory_limit [bytes]: of each run, by default its share of what the machine can spare. Return what could not be
    run or stored while the store as such could be written to, a sentence each. InputError where it cannot.
    """
    store, stop = backlog.store, threading.Event()
    limit = memory_limit or usable_memory() // parallel
    read = lru_cache(maxsize=4)(store.item)
    ended: SimpleQueue[tuple[Job, Run | BaseException]] = SimpleQueue()
    given_up: list[str] = []
    store.put_environment(environment_digest(environment()), environment())
    revision()  # asks git, once: from now on our only children are runs
    adopt()

    def one(job: Job) -> None:
        try:
            result = run(problem, job, read(job.folder), memory_limit=limit, stop=stop.is_set)
            store.put(job.path, result)
            ended.put((job, result))
        except BaseException as error:  # told to the thread that waits
            ended.put((job, error))

    def begin(job: Job) -> None:
        # A daemon: a thread that cannot be stopped must not keep an interrupted study from ending.
        thread = threading.Thread(target=one, args=(job,), daemon=True)
        running.append(thread)
        thread.start()

    def take(job: Job, how: Run | BaseException) -> None:
        running[:] = [thread for thread in running if thread.is_alive()]
        if isinstance(how, Run):
            progress.finished(job, how)
        elif isinstance(how, InputError) and store.usable():
            given_up.append(str(how))
        else:
            raise how

    running: list[threading.Thread] = []
    try:
        backlog.work_off(parallel, begin, ended, take, progress)
    except BaseException:
        stop.set()
        until = time.monotonic() + SWIFT
        for thread in running:
            thread.join(max(0.0, until - time.monotonic()))
        raise
    store.restore()
    return given_up
