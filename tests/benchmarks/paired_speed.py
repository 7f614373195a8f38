"""Speed of two checkouts side by side: new over old, processor time of the same deterministic runs, in pairs.

    python tests/benchmarks/paired_speed.py OLD_CHECKOUT [--new CHECKOUT] [--pairs 20] [--only TEXT]

Two warm processes take turns, so that what else the machine does falls on both. Each case is ended by an iteration
limit or a proof. Prints the median ratio with a 95 % interval (bootstrap over pairs); the results must be the same.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

CASES = {
    "memetic 100/3": ("memetic", ("wind", 100, 3), 150_000),
    "memetic 200/5": ("memetic", ("wind", 200, 5), 150_000),
    "memetic 100/5, one starting place": ("memetic", ("shared", 100, 5), 150_000),
    "branch-and-price 30/3": ("branch-and-price", ("square-wind", 30, 3), None),
    "branch-and-price 40/4": ("branch-and-price", ("square-wind", 40, 4), None),
}
"""Label → solver, what it solves, iterations."""

CHILD = """
import sys, time
try:
    from formulations.routing.registry import make_solver
    from formulations.routing.solver import Limits
except ImportError:
    from formulations.registry import make_solver
    from formulations.solver import Limits
try:
    from formulations.moving_cost.families import generate
except ImportError:
    from instances.families import generate
solvers, instances = {}, {}
for line in sys.stdin:
    solver, kind, n, m, iterations, seed = line.split()
    given = {"square-wind": ("square-wind", {}), "wind": ("uniform", {"wind": "shear"}),
             "shared": ("uniform", {"depots": "shared"})}[kind]
    key = (kind, n, m)
    if key not in instances:
        instances[key] = generate(given[0], int(n), int(m), 1, **given[1])
    if (solver, key) not in solvers:
        solvers[solver, key] = make_solver(solver)
        solvers[solver, key].prepare(instances[key])
    limit = Limits(time=3600.0, iterations=None if iterations == "None" else int(iterations))
    began = time.process_time()
    found = solvers[solver, key].solve(instances[key], limits=limit, seed=int(seed))
    print(time.process_time() - began, repr(found.objective), flush=True)
"""


def started(checkout: Path) -> subprocess.Popen[str]:
    """Return a process that solves what it is told, with the code of `checkout`."""
    env = {**os.environ, "PYTHONPATH": str(checkout.resolve()), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.Popen(
        [sys.executable, "-P", "-c", CHILD], env=env, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )


def timed(process: subprocess.Popen[str], words: str) -> tuple[float, str]:
    """Return processor time [s] and objective of one run."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(words + "\n")
    process.stdin.flush()
    seconds, objective = process.stdout.readline().split()
    return float(seconds), objective


def main() -> None:
    """Measure every case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("--new", type=Path, default=Path(__file__).parents[2])
    parser.add_argument("--pairs", type=int, default=20)
    parser.add_argument("--only", default="")
    args = parser.parse_args()
    processes = started(args.old), started(args.new)
    print(f"{'case':<36}{'pairs':>6}{'new/old':>9}   95 % interval   [s]")
    for label, (solver, (kind, n, m), iterations) in CASES.items():
        if args.only not in label:
            continue
        ratios, seconds = [], []
        for pair in range(-1, args.pairs):  # the first is not counted
            words = f"{solver} {kind} {n} {m} {iterations} {max(pair, 0) % 5}"
            order = (0, 1) if pair % 2 else (1, 0)
            found = {side: timed(processes[side], words) for side in order}
            if found[0][1] != found[1][1]:
                sys.exit(f"{label}: {found[0][1]} before, {found[1][1]} now")
            if pair >= 0:
                ratios.append(found[1][0] / found[0][0])
                seconds.append(found[1][0])
        drawn = np.random.default_rng(0).choice(ratios, (2000, len(ratios)))
        low, high = np.quantile(np.median(drawn, axis=1), [0.025, 0.975])
        middle = np.median(ratios)
        print(
            f"{label:<36}{args.pairs:>6}{middle:>9.3f}   {low:.3f} … {high:.3f}   {np.median(seconds):.2f}", flush=True
        )


if __name__ == "__main__":
    main()
