"""How near bounds over sectors of headings come to routes found, and what they take.

python tests/benchmarks/turn_certificates.py [TASKS UAVS SPACING SECTORS SEEDS SECONDS]
python tests/benchmarks/turn_certificates.py few

A line an instance, as CSV: routes by 1500 steps of memetic a task, bounds by branch-and-price over sectors; times are
processor time. `few` is ten instances of 8 to 12 tasks, 3.5 to 5.5 radii apart, with 64 headings a task: sectors are
doubled until the bound is within 1.5 %, and branch-and-price proves the optimum of the headings themselves.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.moving_cost.turns.travel import relaxed
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.search.memetic import Memetic
from formulations.routing.solver import Result
from instances import Instance, Routes

STEPS = 1500
"""Of memetic, a task."""
CLOSE = 0.015


def timed(run: Callable[[], Result]) -> tuple[Result, float]:
    """Return the result and the processor time it took [s]."""
    began = time.process_time()
    return run(), time.process_time() - began


def searched(instance: Instance) -> tuple[Result, float]:
    """Return routes of a search of so many steps."""
    limits = Limits(time=3600.0, iterations=STEPS * instance.n_tasks)
    return timed(lambda: Memetic().solve(instance, limits=limits, seed=0))


def bounded(instance: Instance, sectors: int, start: Routes | None, seconds: float) -> tuple[Result, float]:
    """Return the bound over sectors of headings."""

    def run() -> Result:
        looser = relaxed(instance, sectors)
        assert looser is not None
        return BranchAndPrice(starts=0).solve(looser, limits=Limits(time=seconds), start=start)

    return timed(run)


def proved(instance: Instance, start: Routes | None) -> tuple[Result, float]:
    """Return the optimum of the instance's own headings."""
    return timed(lambda: BranchAndPrice(starts=0).solve(instance, limits=Limits(time=600.0), start=start))


def few() -> None:
    """Certify ten small instances within 1.5 % of their proved optimum."""
    print("seed,tasks,uavs,spacing,searched,seconds,optimum,seconds,sectors,bound,gap,seconds")
    close = reached = 0
    for seed in range(10):
        instance = generate("dense-survey", 8 + seed % 5, 2 + seed % 2, seed, spacing=3.5 + seed % 3, headings=64)
        BranchAndPrice().prepare(instance)
        best, searching = searched(instance)
        exact, proving = proved(instance, best.routes)
        assert exact.stopped_by == "proof"
        optimum, sectors, bounding, bound = exact.objective or 0.0, 16, 0.0, 0.0
        while bound < optimum / (1 + CLOSE) and sectors < 256:
            sectors *= 2
            result, took = bounded(instance, sectors, best.routes, 600.0)
            bounding, bound = bounding + took, result.bound or 0.0
        close += bound >= optimum / (1 + CLOSE)
        reached += (best.objective or 0.0) <= optimum * (1 + 1e-9)
        print(
            f"{seed},{instance.n_tasks},{instance.n_depots},{3.5 + seed % 3},{best.objective:.3f},{searching:.1f},"
            f"{optimum:.3f},{proving:.1f},{sectors},{bound:.3f},{100 * (1 - bound / optimum):.2f},{bounding:.1f}",
            flush=True,
        )
    print(f"within 1.5 %: {close} of 10; reached by the search: {reached} of 10")


def main(
    tasks: int = 40, uavs: int = 3, spacing: float = 6.0, sectors: int = 32, seeds: int = 2, seconds: float = 600.0
) -> None:
    """Certify instances of one size and spacing, with 24 uniform headings and the sights of 4 nodes."""
    print("seed,searched,seconds,bound,gap,ended,seconds")
    for seed in range(seeds):
        instance = generate("dense-survey", tasks, uavs, seed, spacing=spacing, headings=24, sights=4)
        BranchAndPrice().prepare(instance)
        best, searching = searched(instance)
        result, bounding = bounded(instance, sectors, best.routes, seconds)
        value, bound = best.objective or 0.0, result.bound or 0.0
        print(
            f"{seed},{value:.2f},{searching:.1f},{bound:.2f},{100 * (1 - bound / value):.2f},{result.stopped_by},"
            f"{bounding:.1f}",
            flush=True,
        )


if __name__ == "__main__":
    if sys.argv[1:] == ["few"]:
        few()
    else:
        main(*(kind(word) for kind, word in zip((int, int, float, int, int, float), sys.argv[1:], strict=False)))
