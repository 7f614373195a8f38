"""Every lower bound on the longest tour C_max there is, each valid in floating point, the quickest first.

farthest, assignment, arborescence
               see ``simple_bounds.py``
total          the least sum of all tours in the linear relaxation, ÷ m (``total.py``)
relaxation     the linear relaxation with subtour cuts (``relaxation.py``)
branch-and-cut, branch-and-price
               the bounds of these solvers at the root of their trees (see there)
capped-total   the total of tours that cost no more than the best routes known, cut by the sets of tasks that need
               several UAVs (``capped_total.py``)
capped-tours   the relaxation over whole tours that cost no more than the best routes known
destructive    the largest cap found at which that relaxation is impossible (``columns/destructive.py``)
straight, headings
               in place of the last five where nodes have several states (``state_bounds.py``)

Without a matrix of costs there are those of ``metric_bounds.py`` alone.

Where costs change with time the last three carry the clock; the others are those of the instance whose legs are
minimised over time windows (``time_windows.py``), which no routes better than those known take less than. Where UAVs
may wait before take-off they are bounds of UAVs that need not (`_off_at_once`). With several
states a node besides, each leg counts at the least of all states at its ends: the chord between the least costs at two
knots is below all of them.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from formulations.limits import Limits
from formulations.routing import capped_total as capped
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.destructive import destructive_bounds
from formulations.routing.greedy import Greedy, greedy_routes
from formulations.routing.metric_bounds import metric_bounds
from formulations.routing.registry import make_solver
from formulations.routing.relaxation import relax
from formulations.routing.search.ruin_recreate import RuinRecreate
from formulations.routing.simple_bounds import SIMPLE, worst_makespan
from formulations.routing.solver import Status, refusal
from formulations.routing.state_bounds import FEW, heading_bounds, straight_bound
from formulations.routing.stateless import stateless
from formulations.routing.time_windows import windowed
from formulations.routing.total import total
from instances import Instance, objective
from instances.arrays import Floats
from instances.metric_costs import MetricCosts

MOST_THETA = 60_000
"""Beyond this a round of the relaxation takes minutes."""
STEPS = 20_000
"""Of a search by the clock for the routes known, where costs change with time."""
ROOTS = ("branch-and-cut", "branch-and-price")
"""Solvers whose bound at the root of their tree is shown."""

_TINY = Instance("warm-up", np.ones((5, 5)) - np.eye(5), 3, 2)


@dataclass(frozen=True)
class Bound:
    """One bound.

    name : which.
    value [s] : no routes have a shorter longest tour; 0 where nothing was found in time.
    elapsed [s] : what it took, compilation left out.
    message : why there is none, or "".
    """

    name: str
    value: float
    elapsed: float
    message: str = ""


def lower_bounds(instance: Instance, *, time_limit: float = 60.0, seed: int = 0) -> Iterator[Bound]:
    """Yield every bound of `instance` as it is ready; `time_limit` [s] is that of each."""
    if instance.by_metric is not None:
        yield from _by_metric(instance, instance.by_metric)
        return
    instance = _off_at_once(instance)
    upper = _upper(instance)
    if {"time", "states"} <= instance.axes:
        instance = stateless(instance)
    plain = stateless(windowed(instance, upper) if "time" in instance.axes else instance)
    for name, bound in SIMPLE.items():
        began = time.perf_counter()
        value = bound(plain, upper)
        yield Bound(name, value, time.perf_counter() - began)
    if upper == 0:
        return
    of_all, price = _total(plain, upper, time_limit)
    yield of_all
    yield _relaxation(plain, upper, time_limit)
    if "states" in instance.axes:
        yield from _of_states(instance, upper, time_limit, seed)
        return
    for solver in ROOTS:
        given = instance if refusal(make_solver(solver), instance) is None else plain
        root, found = _root(solver, given, upper, time_limit, seed)
        upper = found if given is instance else upper
        yield root
    yield _capped_total(plain, upper, time_limit)
    if refusal(BranchAndPrice(), instance) is None:
        yield from _columns(instance, upper, price, time_limit)


def _by_metric(instance: Instance, costs: MetricCosts) -> Iterator[Bound]:
    """Yield the bounds of an instance without a matrix."""
    began = time.perf_counter()
    for name, value, message in metric_bounds(instance, costs):
        yield Bound(name, value, time.perf_counter() - began, message)
        began = time.perf_counter()


def _off_at_once(instance: Instance) -> Instance:
    """Return the instance whose UAVs do not wait, of endurance L_k + window: none lands later for it.

    Who takes off at t ≤ window lands by t + L_k, and who takes off at once on the same tour no later.
    """
    if instance.travel is None or "window" not in instance.axes:
        return instance
    travel = replace(instance.travel, window=0.0)
    return replace(instance, travel=travel, endurance=instance.limits + instance.travel.window)


def _upper(instance: Instance) -> float:
    """Return the cost of greedy routes [s], or one that no routes pass where UAVs cannot fly these."""
    found = Greedy().solve(stateless(instance), limits=Limits(time=float("inf"))).routes
    if "time" in instance.axes:  # windows are as narrow as these routes are short
        plain = stateless(instance)
        steps, start = Limits(time=float("inf"), iterations=STEPS), None if found is None else greedy_routes(plain)
        found = RuinRecreate().solve(plain, limits=steps, start=start).routes
    upper = np.inf if found is None else objective(instance, found)
    return worst_makespan(instance) if np.isinf(upper) else upper


def _of_states(instance: Instance, upper: float, time_limit: float, seed: int) -> Iterator[Bound]:
    """Yield the bounds of an instance between headings."""
    if instance.n_tasks > FEW and refusal(BranchAndPrice(), instance) is None:
        BranchAndPrice().prepare(instance)
    began = time.perf_counter()
    value = straight_bound(instance, upper, time_limit, seed)
    none = "not found in time, too large, or the instance does not say how its UAVs turn"
    yield Bound("straight", value, time.perf_counter() - began, "" if value else none)
    began = time.perf_counter()
    *_, (count, value) = (0, 0.0), *heading_bounds(instance, upper, time_limit, seed)
    words = f"{count} sectors a task" if count else none
    yield Bound("headings", value, time.perf_counter() - began, words)


def _total(instance: Instance, upper: float, time_limit: float) -> tuple[Bound, Floats]:
    """Return the bound of all tours together, and the prices of tasks found with it [s], (n,)."""
    total(_TINY, 4.0, 60.0)
    began = time.perf_counter()
    value, complete, price = total(instance, upper, time_limit)
    return Bound("total", value, time.perf_counter() - began, "" if complete else "stopped by time"), price


def _capped_total(instance: Instance, upper: float, time_limit: float) -> Bound:
    """Return the bound of all tours together, each within the cost of the routes known."""
    if instance.n_tasks > capped.MOST_TASKS:
        return Bound("capped-total", 0.0, 0.0, f"takes at most {capped.MOST_TASKS} tasks")
    capped.capped_total(_TINY, 4.0, 60.0)
    began = time.perf_counter()
    value, complete, _ = capped.capped_total(instance, upper, time_limit)
    return Bound("capped-total", value, time.perf_counter() - began, "" if complete else "there may be more to cut off")


def _relaxation(instance: Instance, upper: float, time_limit: float) -> Bound:
    """Return the bound of the linear relaxation."""
    size = instance.n_depots * (instance.n_tasks + 1) ** 2
    if size > MOST_THETA:
        return Bound("relaxation", 0.0, 0.0, f"would need {size} variables; it takes {MOST_THETA}")
    relax(_TINY, 4.0)
    began = time.perf_counter()
    relaxed = relax(instance, upper, time_limit)
    message = "" if relaxed.complete else f"stopped after {relaxed.rounds} rounds"
    return Bound("relaxation", relaxed.bound, time.perf_counter() - began, message)


def _root(name: str, instance: Instance, upper: float, time_limit: float, seed: int) -> tuple[Bound, float]:
    """Return the bound of a solver at the root of its tree, and the cost of the best routes known after it."""
    solver = make_solver(name)
    reason = refusal(solver, instance)
    if reason:
        return Bound(name, 0.0, 0.0, reason), upper
    solver.prepare(instance)
    result = solver.solve(instance, limits=Limits(time=time_limit, iterations=1), seed=seed)
    message = "" if result.stopped_by in ("proof", "iterations") else f"stopped by {result.stopped_by}"
    if result.status is Status.INFEASIBLE:
        message = "proved that there are no routes"
    return Bound(name, result.bound or 0.0, result.elapsed, message), min(upper, result.objective or upper)


def _columns(instance: Instance, upper: float, price: Floats, time_limit: float) -> Iterator[Bound]:
    """Yield the bound of capped tours and what bisecting the cap makes of it; `price` (n,) [s] is where to begin."""
    BranchAndPrice().prepare(instance)
    began = time.perf_counter()
    bounds = destructive_bounds(instance, 0.0, upper, lambda: began + time_limit - time.perf_counter(), price=price)
    value = next(bounds, 0.0)
    yield Bound("capped-tours", value, time.perf_counter() - began, "" if value else "not solved in time")
    if value:
        *_, value = value, *bounds
        yield Bound("destructive", value, time.perf_counter() - began)
