"""Bars of the searches where UAVs differ and endurance is limited: measured figure beside bar.

    python tests/benchmarks/fleets.py [--seeds 3] [--seconds S] [proved] [peers]

Sections: proved (optima of 20 to 40 tasks, without and with endurance, 2 s), peers (40 to 200 tasks beside PyVRP with
a tightening cap, 10 s). The instances are those of exact.py, which also measures the certified gap of 100/10. One
thread each; limits are CPU seconds of this process, as in search.py.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace

from exact import TEN, fleet
from gap_table import Search, gaps_of, table
from search import by_solver, has_pyvrp, on_cpu_time, pyvrp_tightening

from instances import Instance, makespan

INF = float("inf")
Speeds = tuple[int, ...]
Limits = tuple[float, ...]

PROVED: dict[tuple[int, Speeds, int, Limits], float] = {
    (20, (20, 30), 0, ()): 1844.194495,
    (20, (20, 25, 30), 0, ()): 1180.881873,
    (20, (20, 25, 30), 0, (1063, INF, 945)): 1682.226553,
    (20, (15, 20, 25, 30), 0, ()): 1134.701626,
    (20, (15, 20, 25, 30), 0, (1021, INF, INF, 908)): 1134.701626,
    (30, (20, 25, 30), 0, ()): 1454.373717,
    (30, (20, 25, 30), 0, (1309, INF, 1163)): 1971.549620,
    (30, (20, 25, 30), 1, ()): 1439.115833,
    (30, (20, 25, 30), 1, (1295, INF, 1151)): 1824.910007,
    (30, (20, 25, 30), 2, ()): 1523.596103,
    (30, (20, 20, 30), 0, ()): 1534.109435,
    (40, (15, 20, 25, 30), 0, ()): 1334.456866,
    (40, (15, 20, 25, 30), 1, ()): 1299.068506,
}
"""(tasks, speeds [m/s], seed, endurances [s]) → optimum [s], proved by branch-and-price."""


def limited(n: int, speeds: Speeds, seed: int, endurance: Limits) -> Instance:
    """Return a fleet of exact.py with these endurances [s], unlimited where there are none."""
    return replace(fleet(n, speeds, seed), endurance=endurance or None)


def proved(args: argparse.Namespace) -> None:
    """Proved optima found in 95 % of runs of 2 s."""
    search, hits, runs = by_solver("memetic"), 0, 0
    for case, best in PROVED.items():
        gaps = gaps_of(search, limited(*case), best, args.seconds or 2.0, args.seeds)
        hits += sum(g < 1e-4 for g in gaps)
        runs += len(gaps)
        if max(gaps) >= 1e-4:
            print(f"missed {case}: {', '.join(f'{g:.3f}' for g in gaps)} %", flush=True)
    print(f"proved optimum found in {hits} of {runs} runs ({hits / runs:.1%}), bar: 95 %")


def peers(args: argparse.Namespace) -> None:
    """Side by side in one run: memetic never behind PyVRP in the mean."""
    searches: dict[str, Search] = {"memetic": by_solver("memetic")}
    if has_pyvrp():
        searches["PyVRP, tightening"] = pyvrp_tightening
    sizes = ((40, (15, 20, 25, 30)), (60, (20, 25, 30)), (100, TEN[::2]), (100, TEN), (200, TEN))
    instances = [fleet(n, speeds, seed) for n, speeds in sizes for seed in range(2)]
    longest = [(instance, makespan(instance, searches["memetic"](instance, 5.0, 99))) for instance in instances]
    table("fleets, against 5 s of memetic", longest, searches, args, 10.0)
    print("bar: memetic's mean not above PyVRP's")


SECTIONS: dict[str, Callable[[argparse.Namespace], None]] = {"proved": proved, "peers": peers}


def main() -> None:
    """Run the sections asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", choices=[*SECTIONS, []], help="all, if none is named")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=None, help="CPU seconds of a run, instead of the section's")
    args = parser.parse_args()
    args.keep = args.runs = None
    on_cpu_time()
    for name in args.sections or SECTIONS:
        SECTIONS[name](args)


if __name__ == "__main__":
    main()
