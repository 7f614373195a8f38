"""A store of 10,000 runs: `workbench status` within 2 s, `workbench report` within 30 s and 1 GB.

    python tests/benchmarks/store_size.py [--quick] [--runs 10000]

The store is made here from synthetic runs (250 instances of 40 tasks, 8 solvers, 5 seeds, traces of 40 points), then
each command is run once in a process of its own. Printed: wall clock, CPU and peak memory beside the bar. Exit code 1
where a bar is missed.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from formulations.moving_cost.families import generate
from formulations.routing.solver import Status
from instances import Instance, as_routes, tour_costs
from reports.record import Run
from workbench.jobs.job import Job
from workbench.jobs.store import Store
from workbench.problems.routing import ROUTING

SOLVERS = ("milp", "circuit", "ga", "memetic", "greedy", "routing-library", "exact", "subset-dp")
SEEDS = 5


def synthetic_run(job: Job, instance: Instance, rng: np.random.Generator) -> Run:
    """Return a run with random feasible routes and a trace of 40 improvements."""
    order = rng.permutation(instance.n_tasks)
    routes = as_routes(np.array_split(order, instance.n_depots))
    costs = tour_costs(instance, routes)
    value = float(costs.max())
    times = np.sort(rng.uniform(0, 10, 40))
    return Run(
        problem="routing",
        instance=ROUTING.describe(instance),
        solver=job.method,
        options={},
        label=job.label,
        seed=job.seed,
        time_limit=job.time_limit,
        threads=1,
        iterations=None,
        proves=False,
        status=Status.FEASIBLE,
        objective=value,
        bound=0.5 * value,
        elapsed=10.0,
        stopped_by="time",
        message="",
        tolerance=0.0,
        claimed_objective=value,
        prepare_elapsed=1.0,
        wall_elapsed=11.5,
        cpu_seconds=9.9,
        peak_memory=200_000_000,
        environment="0" * 12,
        code="",
        revision="",
        created="2026-01-01T00:00:00+00:00",
        trace=[(float(t), value * (2 - k / 39), 0.5 * value) for k, t in enumerate(times)],
        statistics={"generations": 1234, "cuts": 99},
        log="nothing to say\n" * 20,
        own={"routes": [list(route) for route in routes], "tour_costs": costs.tolist()},
    )


def make_store(folder: Path, runs: int) -> None:
    """Fill `folder` with `runs` synthetic runs."""
    store, paths = Store(folder), []
    rng = np.random.default_rng(0)
    store.create()
    for number in range(-(-runs // (len(SOLVERS) * SEEDS))):
        instance = generate("uniform", 40, 4, number)
        name = store.put_item(ROUTING, instance)
        for solver in SOLVERS:
            for seed in range(SEEDS):
                job = Job(name, solver, seed=seed)
                # not through the store, which waits for the disk at each run
                (folder / job.path).write_text(synthetic_run(job, instance, rng).to_json())
                paths.append(job.path)
    store.put_study({}, paths)


def timed(*args: str) -> tuple[float, float, float]:
    """Run the command line and return wall clock [s], CPU [s] and peak memory [MB]."""
    began = time.perf_counter()
    code = "from workbench.cli import main; main()"
    process = subprocess.Popen([sys.executable, "-c", code, *args], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"workbench {' '.join(args)} ended with exit code {process.returncode}")
    return time.perf_counter() - began, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main() -> None:
    """Make the store, run both commands, print, judge."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--quick", action="store_true", help="a tenth of the runs")
    given = parser.parse_args()
    runs = given.runs // 10 if given.quick else given.runs
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "runs"
        make_store(folder, runs)
        report = ["report", str(folder), "--out", f"{scratch}/report.html", "--csv", f"{scratch}/results.csv"]
        missed = False
        for args, seconds, megabytes in ((["status", str(folder)], 2, 1000), (report, 30, 1000)):
            wall, cpu, memory = timed(*args)
            missed |= wall > seconds or memory > megabytes
            print(
                f"{args[0]:8} {runs} runs: {wall:.2f} s wall (bar {seconds} s), {cpu:.2f} s CPU, "
                f"{memory:.0f} MB (bar {megabytes} MB)"
            )
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
