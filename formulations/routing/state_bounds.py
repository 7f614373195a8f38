"""Lower bounds of instances with states beside those of the matrix of least legs (`bounds`).

straight    what straight legs allow, proved by branch-and-price: no path between two places is shorter. For any number
            of tasks, and weak where tasks lie near each other
headings    the optimum over sectors of headings (`moving_cost.turns`), by subset-dp, more and more sectors until the
            time is up: valid for all headings there are, not only those of the states

Both need to know how the UAVs turn, which instances between headings say in their provenance.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

from formulations.limits import Limits
from formulations.moving_cost.turns.travel import relaxed, turns_of
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.subset_dp import SubsetDp
from instances import Instance
from instances.metrics import distances

FIRST, LAST = 16, 256
"""Sectors a task, doubled from the first to the last."""
CLOSE = 1e-3
"""Share of the best routes known below which more sectors are not worth their time."""
MOST_TASKS = 12
"""Tasks up to which sectors are tried."""
_GROWTH = 5.0  # what twice as many sectors take, about
_ROUNDING = 1e-9


def straight_bound(instance: Instance, upper: float, time_limit: float, seed: int) -> float:
    """Return the bound of straight legs [s], 0 where the instance does not say how its UAVs turn."""
    known = turns_of(instance)
    if known is None or instance.coordinates is None:
        return 0.0
    straight = replace(instance, cost=distances(instance.coordinates) / known[0].speed, travel=None)
    solver = BranchAndPrice()
    solver.prepare(straight)
    result = solver.solve(straight, limits=Limits(time=time_limit), seed=seed)
    return min(upper, (result.bound or 0.0) * (1 - _ROUNDING))


def heading_bounds(instance: Instance, upper: float, time_limit: float) -> Iterator[tuple[int, float]]:
    """Yield (sectors a task, bound [s]), the bound rising, while time and memory allow."""
    began, took = time.perf_counter(), 0.0
    count, best = FIRST, 0.0
    while count <= LAST and instance.n_tasks <= MOST_TASKS and best < upper * (1 - CLOSE):
        left = time_limit - (time.perf_counter() - began)
        if left < _GROWTH * took or left <= 0:
            return
        since = time.perf_counter()
        looser = relaxed(instance, count)
        if looser is None or SubsetDp().accepts(looser) is not None:
            return
        result = SubsetDp().solve(looser, limits=Limits(time=max(left, 1e-3)))
        if result.stopped_by != "proof" or result.bound is None:
            return
        took = time.perf_counter() - since
        if result.bound > best:
            best = min(upper, float(result.bound) * (1 - _ROUNDING))
            yield count, best
        count *= 2
