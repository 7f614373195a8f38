"""The exact methods on small instances: agreement with brute force, and time to proof.

    python tests/benchmarks/main_job.py [--quick] [--part agree|milp|circuit] [--threads 2]

1. `milp`, `circuit` (both forms) and brute force on 200 random instances, n ≤ 7, m ≤ 3, with wind (asymmetric) and
   without; the same optimum within each solver's tolerance, and no bound, streamed or final, above the optimum.
2. `milp` proves n = 10, m = 2 and 3 within 10 s, and n = 12, m = 2 within 60 s, on 2 cores.
3. `circuit` proves n = 15, m = 2, 3 and 4 within 10 s, on 2 cores.

Printed: the measured figure beside its bar; wall and process CPU seconds. Exit code 1 where a bar is missed.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from pathlib import Path

import numpy as np

from formulations.limits import Limits
from formulations.routing.registry import make_solver
from formulations.routing.solver import Event, Solver, Status
from instances import Instance, check_routes, makespan

ORACLES = Path(__file__).parents[1] / "formulations" / "routing" / "conftest.py"


def oracles() -> object:
    """Return the module of the tests' oracles."""
    spec = importlib.util.spec_from_file_location("oracles", ORACLES)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def windy(n: int, m: int, seed: int, wind: bool = True) -> Instance:
    """Return tasks and depots uniform in a 20 km square, 20 m/s, uniform wind (4, −2) m/s and a rigid rotation."""
    points = np.random.default_rng(1000 * n + 100 * m + seed).uniform(0, 20000, (n + m, 2)) - 10000
    d = points[None] - points[:, None]
    cost = np.hypot(d[..., 0], d[..., 1]) / 20
    if wind:
        x, y = points.T
        cost -= (4 * d[..., 0] - 2 * d[..., 1] + 5e-4 * (np.outer(x, y) - np.outer(y, x))) / 400
    np.fill_diagonal(cost, 0.0)
    return Instance(f"windy-{n}-{m}-{seed}", cost, n, m)


def agreement(count: int, threads: int) -> bool:
    """Compare with brute force on `count` instances."""
    brute = oracles()
    solvers: dict[str, Solver] = {
        "milp": make_solver("milp"),
        "circuit": make_solver("circuit"),
        "circuit per_uav": make_solver("circuit", {"per_uav": True}),
    }
    wrong = dict.fromkeys(solvers, 0)
    above = dict.fromkeys(solvers, 0)
    slowest = dict.fromkeys(solvers, 0.0)
    for index in range(count):
        rng = np.random.default_rng(index)
        n, m = int(rng.integers(1, 8)), int(rng.integers(1, 4))
        instance = windy(n, m, index, wind=index % 2 == 0)
        tours = [brute.enumerated_tours(instance, k) for k in instance.depots]  # type: ignore[attr-defined]
        optimum, _ = brute.best_partition(instance, tours)  # type: ignore[attr-defined]
        for name, solver in solvers.items():
            events: list[Event] = []
            result = solver.solve(instance, limits=Limits(time=60, threads=threads), observe=events.append)
            right = (
                result.status is Status.OPTIMAL
                and result.routes is not None
                and check_routes(instance, result.routes) == []
                and abs(makespan(instance, result.routes) - optimum) <= result.tolerance
            )
            wrong[name] += not right
            bounds = [event.bound for event in events if event.bound is not None] + [result.bound or 0.0]
            above[name] += max(bounds) > optimum * (1 + 1e-14)
            slowest[name] = max(slowest[name], result.elapsed)
    for name in solvers:
        print(
            f"{name:16s} {count - wrong[name]}/{count} agree with brute force (bar: all), "
            f"{above[name]} with a bound above the optimum (bar: 0), slowest {slowest[name]:.2f} s"
        )
    return not any(wrong.values()) and not any(above.values())


def proofs(name: str, cells: list[tuple[int, int, float]], seeds: int, threads: int) -> bool:
    """Measure the time to proof of each (n, m, bar [s])."""
    kept = True
    for n, m, bar in cells:
        for seed in range(seeds):
            solver, instance = make_solver(name), windy(n, m, seed)
            solver.prepare(instance)
            cpu = time.process_time()
            result = solver.solve(instance, limits=Limits(time=2 * bar, threads=threads))
            cpu = time.process_time() - cpu
            proved = result.status is Status.OPTIMAL and result.elapsed <= bar
            kept &= proved
            print(
                f"{name:8s} n={n} m={m} seed={seed} {result.status}, gap {result.gap or 0:.2%}",
                f"wall {result.elapsed:6.2f} s, CPU {cpu:6.2f} s (bar: proved in {bar:g} s)",
                "ok" if proved else "MISSED",
                flush=True,
            )
    return kept


def main() -> None:
    """Run the parts asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="20 instances, one seed")
    parser.add_argument("--part", choices=["agree", "milp", "circuit"])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args()
    seeds = 1 if given.quick else given.seeds
    kept = True
    if given.part in (None, "agree"):
        kept &= agreement(20 if given.quick else 200, given.threads)
    if given.part in (None, "milp"):
        kept &= proofs("milp", [(10, 2, 10.0), (10, 3, 10.0), (12, 2, 60.0)], seeds, given.threads)
    if given.part in (None, "circuit"):
        kept &= proofs("circuit", [(15, 2, 10.0), (15, 3, 10.0), (15, 4, 10.0)], seeds, given.threads)
    sys.exit(0 if kept else 1)


if __name__ == "__main__":
    main()
