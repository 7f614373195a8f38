"""Lower bounds of instances with states beside those of the matrix of least legs (`bounds`).

straight    what straight legs allow, proved by branch-and-price: no path between two places is shorter. For any number
            of tasks, and weak where tasks lie near each other
headings    the optimum over sectors of headings (`moving_cost.turns`), more and more of them until the time is up:
            valid for all headings there are, not only those of the states. By subset-dp where tasks are few, else by
            branch-and-price, whose bound counts when it is not the optimum yet

Straight legs hold in a steady wind, too, sectors in calm air. Both need to know how the UAVs turn, which instances
between headings say in their provenance.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

from formulations.limits import Limits
from formulations.moving_cost.turns.travel import relaxed, steady_turns_of
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.search.memetic import Memetic
from formulations.routing.solver import Result, Status, refusal
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Routes

FIRST, LAST = 16, 256
"""Sectors a task, doubled from the first to the last."""
FIRST_OF_MANY, LAST_OF_MANY = 32, 64
"""The same for more tasks than FEW."""
CLOSE = 1e-3
"""Share of the best routes known below which more sectors are not worth their time."""
FEW = 12
"""Tasks up to which subset-dp is the method."""
_SEARCH, _SEARCH_MOST = 0.1, 5.0
"""Share of the time to look for routes in, where tasks are many, and seconds at most."""
MOST_SECTORS = 6000
"""Sectors of all tasks together: more have a cost array of 300 MB, which takes a minute to make."""
_GROWTH = 5.0  # what twice as many sectors take, about
_ROUNDING = 1e-9


def straight_bound(instance: Instance, upper: float, time_limit: float, seed: int) -> float:
    """Return the bound of straight legs [s], 0 where the instance does not say how its UAVs turn."""
    known = steady_turns_of(instance)
    if known is None or instance.coordinates is None:
        return 0.0
    straight = replace(instance, cost=known[0].straight_times(instance.coordinates), travel=None)
    solver = BranchAndPrice()
    solver.prepare(straight)
    result = solver.solve(straight, limits=Limits(time=time_limit), seed=seed)
    return min(upper, (result.bound or 0.0) * (1 - _ROUNDING))


def heading_bounds(instance: Instance, upper: float, time_limit: float, seed: int = 0) -> Iterator[tuple[int, float]]:
    """Yield (sectors a task, bound [s]), the bound rising, while time and memory allow."""
    began, took = time.perf_counter(), 0.0
    few = instance.n_tasks <= FEW
    count, last = (FIRST, LAST) if few else (FIRST_OF_MANY, LAST_OF_MANY)
    best, routes = 0.0, None
    while count <= last and count * instance.n_tasks <= MOST_SECTORS and best < upper * (1 - CLOSE):
        since = time.perf_counter()
        left = time_limit - (since - began)
        if left < _GROWTH * took or left <= 0:
            return
        looser = relaxed(instance, count)
        if looser is None or (not few and refusal(BranchAndPrice(), looser) is not None):
            return
        if few:
            result = _over_few(looser, left)
        else:
            routes = routes or _routes(instance, min(_SEARCH * left, _SEARCH_MOST), seed)
            result = _over_many(looser, time_limit - (time.perf_counter() - began), routes, seed)
            routes = result.routes
        took = time.perf_counter() - since
        if (result.bound or 0.0) > best:
            best = min(upper, float(result.bound or 0.0) * (1 - _ROUNDING))
            yield count, best
        if result.stopped_by != "proof":
            return
        count *= 2


def _over_few(looser: Instance, left: float) -> Result:
    """Return what subset-dp proves in the time left; nothing where it takes too much memory."""
    if SubsetDp().accepts(looser) is not None:
        return Result(Status.NO_SOLUTION, stopped_by="memory")
    result = SubsetDp().solve(looser, limits=Limits(time=max(left, 1e-3)))
    return result if result.stopped_by == "proof" else replace(result, bound=None)


def _over_many(looser: Instance, left: float, routes: Routes | None, seed: int) -> Result:
    """Return what branch-and-price proves in the time left: it begins with routes of the instance itself."""
    solver = BranchAndPrice(starts=0)
    return solver.solve(looser, limits=Limits(time=max(left, 1e-3)), seed=seed, start=routes)


def _routes(instance: Instance, seconds: float, seed: int) -> Routes | None:
    """Return routes of the instance, by a short search."""
    if refusal(Memetic(), instance) is not None:
        return None
    return Memetic().solve(instance, limits=Limits(time=max(seconds, 1e-3)), seed=seed).routes
