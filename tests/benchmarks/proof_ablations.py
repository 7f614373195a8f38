"""Ablation: proofs by `branch-and-price` as it is and without each of its parts, side by side.

    python tests/benchmarks/proof_ablations.py [--tasks 100] [--uavs 10] [--seeds 10] [--first 0] [--seconds 90]
                                               [--lines "one side,no rough rounds"] [--known]

CPU seconds of one thread. Trees differ from one to the other by chance: only sums over several seeds tell. When routes
are found is chance as well: with --known all begin with the best of a run before, as it is, up to three times as long.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from contextlib import ExitStack
from types import ModuleType
from unittest.mock import patch

from exact import wind_instance

import formulations.routing.branch_and_price as solving
from formulations.limits import Limits
from formulations.routing import search_beside
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns import generation, tightening
from formulations.routing.columns.pricing import Efforts, efforts
from formulations.routing.solver import Result, Status
from instances import Instance, Routes


def from_one_side(n_tasks: int, bins: int, *, both: bool) -> tuple[Efforts, Efforts]:
    """Return how hard to work where tours are looked for from the depot alone, whatever is asked."""
    return efforts(n_tasks, bins, both=False)


def half_way(share: float, *_: object) -> float:
    """Return the share of the way to the master's duals as it was."""
    return share


def nobody(*_: object) -> None:
    """Say that no UAV sets the relaxation alone."""


def no_steps(*_: object) -> int:
    """Search in no parts; return the steps made."""
    return 0


Change = tuple[ModuleType, str, int | float | Callable[..., object]]
LINES: dict[str, tuple[Change, ...]] = {
    "as it is": (),
    "one side": ((solving, "efforts", from_one_side),),
    "nobody exempt": ((tightening, "sole_bottleneck", nobody),),
    "half-way": ((generation, "adapted", half_way),),
    # of fewer cuts a round less is asked before it is the last
    "no rough rounds": ((tightening, "_ROUGH_ROUNDS", 0), (tightening, "_DEAR", 0.08)),
    "rough rounds anywhere": ((tightening, "_ROUGH_UP_TO", 300),),
    "no trials": ((tightening, "_HASTY", -1.0),),
    "no parts": ((search_beside, "improve_in_parts", no_steps),),
}


def run(instance: Instance, line: str, seconds: float, start: Routes | None) -> tuple[Result, float]:
    """Solve without one part; return the result and the CPU seconds."""
    with ExitStack() as changed:
        for module, name, value in LINES[line]:
            changed.enter_context(patch.object(module, name, value))
        began = time.process_time()
        result = BranchAndPrice().solve(instance, limits=Limits(time=seconds), start=start)
    return result, time.process_time() - began


def main() -> None:
    """Print, for each seed, the seconds to the proof or the gap left, and the sums, an open one as the limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in (("tasks", 100), ("uavs", 10), ("seeds", 10), ("first", 0), ("seconds", 90)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--lines", default=",".join(list(LINES)[1:]))
    parser.add_argument("--known", action="store_true")
    asked = parser.parse_args()
    lines, total, proved = ["as it is", *asked.lines.split(",")], {}, {}
    BranchAndPrice().prepare(wind_instance(17, 3, 0))
    print(f"{asked.tasks} tasks, {asked.uavs} UAVs, {asked.seconds} s: " + " | ".join(lines))
    for seed in range(asked.first, asked.first + asked.seeds):
        instance, cells = wind_instance(asked.tasks, asked.uavs, seed), []
        start = run(instance, "as it is", 3 * asked.seconds, None)[0].routes if asked.known else None
        for line in lines:
            result, spent = run(instance, line, asked.seconds, start)
            done = result.status is Status.OPTIMAL
            proved[line] = proved.get(line, 0) + done
            total[line] = total.get(line, 0.0) + (min(spent, asked.seconds) if done else asked.seconds)
            cells.append(f"{spent:.1f}" if done else f"open at {result.gap:.2%}")
        print(f"seed {seed}: " + " | ".join(cells), flush=True)
    print("proved " + " | ".join(f"{proved[line]} of {asked.seeds}, {total[line]:.0f} s" for line in lines))


if __name__ == "__main__":
    main()
