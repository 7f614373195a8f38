"""Cluster: the jobs of a study on a dask.distributed cluster (extra `cluster`).

Each run is still in a killable process of its own, on the machine of the dask worker that takes it; a worker holds as
many runs at once as it has threads. Results come back to this process, the only one that writes the store. A worker
that dies takes its runs with it (they are killed with their parent) and the scheduler gives them to another.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any

import distributed

from instances.errors import InputError
from reports.record import Run
from workbench.jobs.execute import Finished
from workbench.jobs.job import Job
from workbench.jobs.machine import environment, usable_memory
from workbench.jobs.problem import Problem
from workbench.jobs.runner import run
from workbench.jobs.store import Store

dask: Any = distributed  # it has no type stubs
CONNECT = 10
"""Seconds to wait for the scheduler."""
AHEAD = 2
"""Jobs handed over per thread of the cluster: enough to keep it busy, few enough not to hold every item."""


def run_on_cluster(
    problem: Problem[Any], jobs: Iterable[Job], store: Store, address: str, finished: Finished
) -> list[str]:
    """Run `jobs` on the cluster at `address`, storing each as it ends.

    Return what the scheduler gave up, a sentence each: jobs whose workers died one after the other. Raises
    InputError where the scheduler cannot be reached or has no workers.
    """
    given_up = []
    with _connected(address) as client:
        workers = client.scheduler_info(n_workers=-1)["workers"].values()
        threads = sum(worker["nthreads"] for worker in workers)
        if not threads:
            raise InputError(f"--scheduler: {address} has no workers")
        waiting = iter(jobs)
        given: dict[str, Job] = {}

        def hand_over(count: int) -> list[Any]:
            futures = []
            for job in islice(waiting, count):
                # Keyed by its path and pure=False: asked for once, and never taken from another study's results.
                future = client.submit(run_there, problem, job, problem.read(store.root / job.folder), pure=False)
                given[future.key] = job
                futures.append(future)
            return futures

        ending = dask.as_completed(hand_over(AHEAD * threads), loop=client.loop)
        for future in ending:
            job = given.pop(future.key)
            if future.status != "finished":
                given_up.append(f"{job.path}: given up by the cluster ({future.exception()})")
            else:
                result, machine = future.result()
                store.put_environment(result.environment, machine)
                store.put(job.path, result)
                finished(job, result)
            future.release()
            for more in hand_over(1):
                ending.add(more)
    return given_up


def run_there(problem: Problem[Any], job: Job, item: Any) -> tuple[Run, dict[str, Any]]:
    """Run `job` in a process of its own on this worker's machine; return the run and this machine's description."""
    memory_limit = usable_memory() // dask.get_worker().state.nthreads
    return run(problem, job, item, memory_limit=memory_limit), environment()


@contextlib.contextmanager
def _connected(address: str) -> Iterator[Any]:
    try:
        client = dask.Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"--scheduler: {address} cannot be reached ({error})") from None
    try:
        yield client
    finally:
        client.close()
