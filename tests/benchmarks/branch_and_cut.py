"""Measure branch-and-cut against its bars, in one run: python tests/benchmarks/branch_and_cut.py [--quick].

Instances: tasks and depots uniform in a 20 km square, 20 m/s, uniform wind and a rotation (the closed form of a
straight leg). Limits and figures are CPU seconds of this process, compilation left out; run with OMP_NUM_THREADS=1.
The optima of n = 20 are those of subset programming; larger ones were proved by column generation, and agree.
--quick: n = 20 alone. --ablation: each option off in turn, n = 20, m = 3.
"""

from __future__ import annotations

import sys
import time
from dataclasses import fields

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.branch_and_cut import BranchAndCut
from formulations.routing.solver import Result, Status
from instances import Instance

OPTIMA = {
    (20, 2): (2295.084, 2048.518, 1979.242),
    (20, 3): (1578.891, 1603.418, 1697.514),
    (20, 4): (1173.440, 1288.910, 1235.960),
    (40, 2): (2616.011, 2509.269, 2621.851),
}
LIMIT = {20: 60.0, 40: 120.0, 50: 120.0}


def windy(n: int, m: int, seed: int) -> Instance:
    """Return the random instance of this size and seed."""
    return generate("square-wind", n, m, seed)


def timed(solver: BranchAndCut, instance: Instance, limit: float) -> tuple[Result, float]:
    """Return the result and its CPU seconds; the wall clock may run three times as long."""
    solver.prepare(instance)
    began = time.process_time()
    result = solver.solve(instance, limits=Limits(time=3 * limit))
    return result, time.process_time() - began


def proofs(n: int, m: int) -> bool:
    """Print one line per seed: proved within the limit, and the value known."""
    kept = True
    for seed in range(3):
        result, cpu = timed(BranchAndCut(), windy(n, m, seed), LIMIT[n])
        known = OPTIMA.get((n, m), (None,) * 3)[seed]
        ok = result.status is Status.OPTIMAL and cpu <= LIMIT[n]
        ok &= known is None or abs((result.objective or 0.0) - known) < 6e-4 + result.tolerance
        counts = result.statistics
        cuts = counts.get("two_cycle_cuts", 0) + counts.get("fractional_cuts", 0) + counts.get("lazy_cuts", 0)
        print(
            f"{'ok  ' if ok else 'MISS'}  n {n} m {m} seed {seed}  {result.status:8s} {result.objective:10.3f} s  "
            f"gap {result.gap or 0:7.4%}  {cpu:6.2f} CPU s  {counts.get('nodes', 0):5d} nodes  {cuts:5d} cuts   "
            f"bar: proved in {LIMIT[n]:g} s" + ("" if known is None else f", {known}"),
            flush=True,
        )
        kept &= ok
    return kept


def ablation() -> None:
    """Print CPU seconds with each option off, n = 20, m = 3."""
    for name in ("none", *(field.name for field in fields(BranchAndCut))):
        solver = BranchAndCut() if name == "none" else BranchAndCut(**{name: False})
        runs = [timed(solver, windy(20, 3, seed), 60.0) for seed in range(3)]
        told = ", ".join(f"{cpu:6.2f} s ({result.gap or 0:.1%})" for result, cpu in runs)
        print(f"      off: {name:18s} {told}", flush=True)


def main(arguments: list[str]) -> int:
    """Run the bars; return 1 where one is missed."""
    if "--ablation" in arguments:
        ablation()
        return 0
    sizes = [(20, 2), (20, 3), (20, 4)] + ([] if "--quick" in arguments else [(40, 2), (50, 2)])
    kept = [proofs(n, m) for n, m in sizes]
    return 0 if all(kept) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
