"""What a first use costs: processor time and wall clock of preparing each method, cold and warm, also of two checkouts.

    python tests/benchmarks/cold_start.py [NAMES...] [--old CHECKOUT]

NAMES are solvers, `moving-cost:METHOD` for the moving-cost methods, and `select:METHOD`. Each is prepared in a process
of its own, first with an empty folder for machine code, then again with what the first has left there. Imports are not
counted. With --old the two checkouts take turns, so that what else the machine does falls on both.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

NAMES = (
    "greedy", "ruin-recreate", "memetic", "ga", "subset-dp", "branch-and-cut", "branch-and-price", "exact",
    "moving-cost:refined", "moving-cost:fmt-star", "select:exact",
)  # fmt: skip
CHILD = """
import sys, time
from instances.families import make_scenario
from formulations.moving_cost.families import generate
kind, _, name = sys.argv[1].rpartition(":")
if kind == "moving-cost":
    from formulations.moving_cost.costing import query_of
    from formulations.moving_cost.registry import make_method
    query = query_of(make_scenario("wind-vortices", 1, 1, 0))
    prepare = lambda: make_method(name).solve(query)
elif kind == "select":
    import numpy
    from formulations.selection.registry import make_method
    from formulations.selection.selection import SelectionProblem
    from formulations.selection.worth import Worth
    problem = SelectionProblem(generate("mixed-fleet", 20, 2, 0, endurance=0.5), Worth.of_prizes(numpy.ones(20)))
    prepare = lambda: make_method(name).prepare(problem)
else:
    from formulations.routing.registry import make_solver
    instance, solver = generate("square-wind", 20, 2, 0), make_solver(name)
    prepare = lambda: solver.prepare(instance)
cpu, wall = time.process_time(), time.perf_counter()
prepare()
print(time.process_time() - cpu, time.perf_counter() - wall)
"""


def prepared(name: str, checkout: Path, machine_code: Path) -> tuple[float, float]:
    """Return processor time and wall clock [s] of preparing in a fresh process."""
    env = {**os.environ, "PYTHONPATH": str(checkout.resolve()), "NUMBA_CACHE_DIR": str(machine_code)}
    done = subprocess.run(
        [sys.executable, "-P", "-c", CHILD, name], env=env, capture_output=True, text=True, check=False
    )
    if done.returncode:
        sys.exit(f"{name} in {checkout}: {done.stderr[-2000:]}")
    cpu, wall = done.stdout.split()[-2:]
    return float(cpu), float(wall)


def main() -> None:
    """Measure and print, a line for each method and checkout."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", default=NAMES)
    parser.add_argument("--old", type=Path)
    chosen = parser.parse_args()
    checkouts = {"new": Path(__file__).parents[2], **({"old": chosen.old} if chosen.old else {})}
    print(f"{'method':<24}{'':6}{'cold: CPU [s]':>14}{'wall [s]':>10}{'warm: CPU [s]':>15}{'wall [s]':>10}")
    for name in chosen.names:
        for label, checkout in checkouts.items():
            with tempfile.TemporaryDirectory() as empty:
                cold, warm = (prepared(name, checkout, Path(empty)) for _ in range(2))
            print(f"{name:<24}{label:<6}{cold[0]:>14.1f}{cold[1]:>10.1f}{warm[0]:>15.2f}{warm[1]:>10.2f}", flush=True)


if __name__ == "__main__":
    main()
