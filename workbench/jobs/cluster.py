"""Cluster: the jobs of a study on a dask.distributed cluster (extra `cluster`).

Each run is still in a killable process of its own, on the machine of the dask worker that takes it; a worker holds as
many runs at once as it has threads. Results come back to this process, the only one that writes the store. A worker
that dies takes its runs with it (they are killed with their parent) and the scheduler gives them to another.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from queue import SimpleQueue
from typing import Any

import distributed

from instances.errors import InputError
from reports.record import Run
from workbench.jobs.backlog import Backlog, Progress
from workbench.jobs.job import Job
from workbench.jobs.machine import environment, usable_memory
from workbench.jobs.problem import Problem
from workbench.jobs.runner import run

dask: Any = distributed  # it has no type stubs
CONNECT = 10
"""Seconds to wait for the scheduler."""
AHEAD = 2
"""Jobs handed over per thread of the cluster: enough to keep it busy, few enough not to hold every item."""


def run_on_cluster(
    backlog: Backlog, problem: Problem[Any], address: str, progress: Progress, memory_limit: int | None = None
) -> list[str]:
    """Run the jobs of `backlog` on the cluster at `address`, storing each as it ends.

    memory_limit [bytes]: of each run, by default its share of what its machine can spare. Return what could not be
    run or stored, a sentence each: jobs whose workers died one after the other among them. InputError where the
    scheduler cannot be reached, has no workers, or the store cannot be written to.
    """
    store, given_up = backlog.store, []
    ended: SimpleQueue[tuple[Job, Any]] = SimpleQueue()
    with connected(address) as client:
        given: dict[str, Any] = {}

        def begin(job: Job) -> None:
            try:
                item = store.item(job.folder)
            except InputError as error:
                ended.put((job, error))
                return
            # pure=False: asked for once, and never taken from another study's results.
            given[job.path] = client.submit(run_there, problem, job, item, memory_limit, pure=False)
            given[job.path].add_done_callback(lambda future: ended.put((job, future)))

        def take(job: Job, how: Any) -> None:
            given.pop(job.path, None)
            try:
                if isinstance(how, InputError):
                    raise how
                if how.status != "finished":
                    given_up.append(f"{job.path}: given up by the cluster ({how.exception()})")
                    return
                result, machine = how.result()
                store.put_environment(result.environment, machine)
                store.put(job.path, result)
            except InputError as error:
                if not store.usable():
                    raise
                given_up.append(str(error))
            else:
                progress.finished(job, result)

        backlog.work_off(AHEAD * threads_of(client, address), begin, ended, take, progress)
    store.restore()
    return given_up


def threads_of(client: Any, address: str) -> int:
    """Return how many runs the cluster takes at once; InputError where it has no workers."""
    threads = sum(worker["nthreads"] for worker in client.scheduler_info(n_workers=-1)["workers"].values())
    if not threads:
        raise InputError(f"--scheduler: {address} has no workers")
    return int(threads)


def run_there(problem: Problem[Any], job: Job, item: Any, memory_limit: int | None) -> tuple[Run, dict[str, Any]]:
    """Run `job` in a process of its own on this worker's machine; return the run and this machine's description."""
    limit = memory_limit or usable_memory() // dask.get_worker().state.nthreads
    return run(problem, job, item, memory_limit=limit), environment()


@contextlib.contextmanager
def connected(address: str) -> Iterator[Any]:
    """Give a client of the scheduler at `address`; InputError where it cannot be reached."""
    try:
        client = dask.Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"--scheduler: {address} cannot be reached ({error})") from None
    try:
        yield client
    finally:
        client.close()
