"""Bars of the searches where UAVs differ and endurance is limited: measured figure beside bar.

    python tests/benchmarks/fleets.py [--seeds 3] [--seconds S] [SECTION...]

Sections: proved (optima of 20 to 40 tasks, without and with endurance, 2 s), peers (40 to 200 tasks beside PyVRP with
a tightening cap, 10 s), large (100/10 against BOUNDS, 300 s). Tasks and depots are uniform in a 20 km square, costs the
paper's at each UAV's own speed, in a wind of (4, −2) m/s plus a rotation. One thread each; limits are CPU seconds of
this process, as in search.py.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
from search import Search, by_solver, gaps_of, has_pyvrp, on_cpu_time, pyvrp_tightening, table

from instances import Instance, Travel, makespan

Speeds = tuple[int, ...]
Limits = tuple[float, ...]

PROVED: dict[tuple[int, Speeds, int, Limits], float] = {
    (30, (20, 25, 30), 0, ()): 1454.373717,
    (30, (20, 20, 30), 0, ()): 1534.109435,
    (40, (15, 20, 25, 30), 0, ()): 1334.456866,
    (40, (15, 20, 25, 30), 1, ()): 1299.068506,
}
"""(tasks, speeds [m/s], seed, endurances [s]) → optimum [s]."""
TEN: Speeds = (15, 15, 20, 20, 20, 25, 25, 25, 30, 30)
BOUNDS: dict[int, float] = {}
"""Seed of 100 tasks at speeds TEN → lower bound [s], by branch-and-price."""


def straight(n: int, speeds: Speeds, seed: int, endurance: Limits = ()) -> Instance:
    """Return an instance whose UAVs fly straight legs at these speeds [m/s], on one battery where it is limited."""
    m = len(speeds)
    p = np.random.default_rng(1000 * n + 100 * m + seed).uniform(0, 20000, (n + m, 2))
    d, (x, y) = p[None] - p[:, None], (p - 10000).T
    wind = 4 * d[..., 0] - 2 * d[..., 1] + 5e-4 * (np.outer(x, y) - np.outer(y, x))
    costs = [np.maximum(np.hypot(d[..., 0], d[..., 1]) / v - wind / v**2, 0.0) for v in speeds]
    name = f"{n}-{m}-{seed}" + "-limited" * bool(endurance)
    return Instance.of_travel(name, Travel.of_uavs(costs), n, coordinates=p, endurance=endurance or None)


def proved(args: argparse.Namespace) -> None:
    """Proved optima found in 95 % of runs of 2 s."""
    search, hits, runs = by_solver("memetic"), 0, 0
    for case, best in PROVED.items():
        gaps = gaps_of(search, straight(*case), best, args.seconds or 2.0, args.seeds)
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
    instances = [straight(n, speeds, seed) for n, speeds in sizes for seed in range(2)]
    longest = [(instance, makespan(instance, searches["memetic"](instance, 5.0, 99))) for instance in instances]
    table("fleets, against 5 s of memetic", longest, searches, args, 10.0)
    print("bar: memetic's mean not above PyVRP's")


def large(args: argparse.Namespace) -> None:
    """100/10 within 1 % of the bound after 300 s."""
    search, seconds = by_solver("memetic"), args.seconds or 300.0
    for seed in range(args.seeds):
        instance = straight(100, TEN, seed)
        value = makespan(instance, search(instance, seconds, 0))
        gap = f"{value / BOUNDS[seed] - 1:+.2%} of the bound" if seed in BOUNDS else "no bound known"
        print(f"100/10 seed {seed}: {value:.6f} s, {gap} (bar: 1 % in 5 of 10)", flush=True)


SECTIONS: dict[str, Callable[[argparse.Namespace], None]] = {f.__name__: f for f in (proved, peers, large)}


def main() -> None:
    """Run the sections asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", choices=[*SECTIONS, []], help="all but large, if none is named")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=None, help="CPU seconds of a run, instead of the section's")
    args = parser.parse_args()
    args.keep = None
    on_cpu_time()
    for name in args.sections or ("proved", "peers"):
        SECTIONS[name](args)


if __name__ == "__main__":
    main()
