"""What the machinery costs: studies of trivial runs with two checkouts side by side, new over old, in pairs.

    python tests/benchmarks/study_overhead.py OLD_CHECKOUT [--new CHECKOUT] [--runs 100] [--pairs 10] [--jobs 1]

Each side of a pair is one `workbench compare` of so many runs of `greedy` on five tasks, without a report, into a new
store; the sides take turns at being first, so that what else the machine does falls on both. 10 pairs of 100 runs are
a study of 1,000 runs a side: about half an hour on two idle cores. Prints the median ratio of wall clock and of
processor time (all processes), each with a 95 % interval (bootstrap over pairs).
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

STUDY = """
seeds = {runs}
time_limit = 1
[[families]]
family = "uniform"
tasks = 5
depots = 2
[[solvers]]
name = "greedy"
"""
PROGRAM = "from workbench.cli import main; main()"


def timed(checkout: Path, runs: int, jobs: int) -> tuple[float, float]:
    """Return wall clock and processor time [s] of a study with the code of `checkout`."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "study.toml").write_text(STUDY.format(runs=runs))
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        args = ["compare", "study.toml", "--out", "runs", "--no-report", "--jobs", str(jobs)]
        env = {**os.environ, "PYTHONPATH": str(checkout.resolve())}
        done = subprocess.run(
            [sys.executable, "-P", "-c", PROGRAM, *args], cwd=folder, env=env, stderr=subprocess.PIPE, text=True
        )
        wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
        stored = len(list(Path(folder).glob("runs/*/greedy*.json")))
    if done.returncode or stored != runs:
        sys.exit(f"{checkout}: exit code {done.returncode}, {stored} of {runs} runs stored\n{done.stderr[-2000:]}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("--new", type=Path, default=Path(__file__).parents[2])
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--pairs", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=1)
    args = parser.parse_args()
    sides = args.old, args.new
    for checkout in sides:
        timed(checkout, 2, args.jobs)  # compile
    found = np.empty((args.pairs, 2, 2))  # pair, side, wall and processor time
    for pair in range(args.pairs):
        for side in (0, 1) if pair % 2 else (1, 0):
            found[pair, side] = timed(sides[side], args.runs, args.jobs)
        print(f"pair {pair + 1}: [s] old {found[pair, 0].round(2)}, new {found[pair, 1].round(2)}", file=sys.stderr)
    drawn = np.random.default_rng(0).integers(args.pairs, size=(2000, args.pairs))
    print(f"{'':<18}{'new/old':>8}   95 % interval   [ms a run, new]")
    for which, name in enumerate(("wall clock", "processor time")):
        ratios = found[:, 1, which] / found[:, 0, which]
        low, high = np.quantile(np.median(ratios[drawn], axis=1), [0.025, 0.975])
        each = 1000 * np.median(found[:, 1, which]) / args.runs
        print(f"{name:<18}{np.median(ratios):>8.3f}   {low:.3f} … {high:.3f}   {each:.0f}")


if __name__ == "__main__":
    main()
