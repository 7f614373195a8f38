"""Ablation: proofs by `branch-and-price` that look for tours from both sides, and from one alone, side by side.

    python tests/benchmarks/two_sided.py [--tasks 100] [--uavs 10] [--seeds 10] [--first 0] [--seconds 90]

CPU seconds of one thread. Trees differ from one to the other by chance: only sums over several seeds tell.
"""

from __future__ import annotations

import argparse
import time

from exact import wind_instance

import formulations.routing.branch_and_price as solving
from formulations.limits import Limits
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.pricing import Efforts, efforts
from formulations.routing.solver import Status


def from_one_side(n_tasks: int, bins: int, *, both: bool) -> tuple[Efforts, Efforts]:
    """Return how hard to work where tours are looked for from the depot alone, whatever is asked."""
    return efforts(n_tasks, bins, both=False)


def from_both(n_tasks: int, bins: int, *, both: bool) -> tuple[Efforts, Efforts]:
    """Return how hard to work where they are looked for from both sides, whatever is asked."""
    return efforts(n_tasks, bins, both=True)


def main() -> None:
    """Print, for each seed, the seconds to the proof or the gap left, and the sums, an open one as the limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in (("tasks", 100), ("uavs", 10), ("seeds", 10), ("first", 0), ("seconds", 90)):
        parser.add_argument(f"--{name}", type=int, default=default)
    asked = parser.parse_args()
    ways, total, proved = {"both sides": from_both, "one side": from_one_side}, {}, {}
    solver = BranchAndPrice()
    solver.prepare(wind_instance(17, 3, 0))
    print(f"{asked.tasks} tasks, {asked.uavs} UAVs, {asked.seconds} s: " + " | ".join(ways))
    for seed in range(asked.first, asked.first + asked.seeds):
        cells = []
        for way, how in ways.items():
            solving.efforts = how
            began = time.process_time()
            result = solver.solve(wind_instance(asked.tasks, asked.uavs, seed), limits=Limits(time=asked.seconds))
            spent = min(time.process_time() - began, float(asked.seconds))
            done = result.status is Status.OPTIMAL
            proved[way] = proved.get(way, 0) + done
            total[way] = total.get(way, 0.0) + (spent if done else asked.seconds)
            cells.append(f"{spent:.1f}" if done else f"open at {result.gap:.2%}")
        print(f"seed {seed}: " + " | ".join(cells), flush=True)
    print("proved " + " | ".join(f"{proved[way]} of {asked.seeds}, {total[way]:.0f} s" for way in ways))


if __name__ == "__main__":
    main()
