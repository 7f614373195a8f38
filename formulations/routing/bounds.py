"""Lower bounds on the longest tour C_max, each valid in floating point, from the quickest to the strongest.

    farthest       max_i min_k (cheapest way from depot k to task i + back): the UAV that visits i flies that far
    assignment     every task is entered and left once: the cheapest such arcs, subtours allowed, ÷ m, because
                   Σ_k C_k ≤ m·C_max (a UAV at home is the arc depot → depot of cost 0)
    arborescence   the arcs of all routes without the last ones span the tasks from the depots taken as one root:
                   (cheapest arborescence + cheapest way home) ÷ m, and the same with all arcs reversed
    relaxation     the linear relaxation with subtour cuts (``relaxation.py``)
    branch-and-cut, branch-and-price
                   the bounds of these solvers at the root of their trees (see there)
    capped-tours   the relaxation over whole tours that cost no more than the best routes known
    destructive    the largest cap found at which that relaxation is impossible (``columns/destructive.py``)

The first three subtract (n+m)²·2^-52·U for rounding: costs are cut off at 2U, U the cost of routes known, and none of
them adds or subtracts more than (n+m)² such numbers one after another.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from formulations.registry import make_solver
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.destructive import destructive_bounds
from formulations.routing.greedy import greedy_routes
from formulations.routing.relaxation import relax
from formulations.routing.ways import ways_between_tasks, ways_from_depot
from formulations.solver import Limits
from instances import Instance, makespan

MOST_THETA = 60_000
"""Beyond this a round of the relaxation takes minutes."""
ROOTS = ("branch-and-cut", "branch-and-price")
"""Solvers whose bound at the root of their tree is shown."""


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
    """Yield every bound of `instance` as it is ready.

    time_limit [s] : of each bound.
    """
    upper = makespan(instance, greedy_routes(instance))
    for name, bound in SIMPLE.items():
        began = time.perf_counter()
        value = bound(instance, upper)
        yield Bound(name, value, time.perf_counter() - began)
    if upper == 0:
        return
    yield _relaxation(instance, upper, time_limit)
    for solver in ROOTS:
        root, upper = _root(solver, instance, upper, time_limit, seed)
        yield root
    if BranchAndPrice().accepts(instance) is None:
        yield from _columns(instance, upper, time_limit)


def _relaxation(instance: Instance, upper: float, time_limit: float) -> Bound:
    """Return the bound of the linear relaxation."""
    size = instance.n_depots * (instance.n_tasks + 1) ** 2
    if size > MOST_THETA:
        return Bound("relaxation", 0.0, 0.0, f"would need {size} variables; it takes {MOST_THETA}")
    relax(Instance("warm-up", np.ones((2, 2)) - np.eye(2), 1, 1), 2.0)
    began = time.perf_counter()
    relaxed = relax(instance, upper, time_limit)
    message = "" if relaxed.complete else f"stopped after {relaxed.rounds} rounds"
    return Bound("relaxation", relaxed.bound, time.perf_counter() - began, message)


def _root(name: str, instance: Instance, upper: float, time_limit: float, seed: int) -> tuple[Bound, float]:
    """Return the bound of a solver at the root of its tree, and the cost of the best routes known after it."""
    solver = make_solver(name)
    reason = solver.accepts(instance)
    if reason:
        return Bound(name, 0.0, 0.0, reason), upper
    solver.prepare(instance)
    result = solver.solve(instance, limits=Limits(time=time_limit, iterations=1), seed=seed)
    message = "" if result.stopped_by in ("proof", "iterations") else f"stopped by {result.stopped_by}"
    return Bound(name, result.bound or 0.0, result.elapsed, message), min(upper, result.objective or upper)


def _columns(instance: Instance, upper: float, time_limit: float) -> Iterator[Bound]:
    """Yield the bound of capped tours and what bisecting the cap makes of it."""
    BranchAndPrice().prepare(instance)
    began = time.perf_counter()
    name, value, elapsed = "capped-tours", 0.0, 0.0
    for value in destructive_bounds(instance, 0.0, upper, lambda: time.perf_counter() - began > time_limit):
        elapsed = time.perf_counter() - began
        if name == "capped-tours":
            yield Bound(name, value, elapsed)
            name = "destructive"
    yield Bound(name, value, time.perf_counter() - began, "" if value else "not solved in time")


def farthest(instance: Instance, upper: float) -> float:
    """Return the longest way out to a task and back that cannot be avoided [s]."""
    cost = np.minimum(instance.cost, 2 * upper)
    between = ways_between_tasks(cost, instance.n_tasks)
    ways = [ways_from_depot(cost, between, k) for k in instance.depots]
    return _down(float(np.min([out + back for out, back in ways], axis=0).max()), instance, upper)


def assignment(instance: Instance, upper: float) -> float:
    """Return the cheapest choice of one arc into and one out of every task, a UAV's share of it [s]."""
    n = instance.n_tasks
    cost = np.minimum(instance.cost, 2 * upper)
    never = 4.0 * upper * instance.n_nodes
    cost[:n, :n][np.diag_indices(n)] = never
    between_depots = cost[n:, n:]
    between_depots[:] = never
    np.fill_diagonal(between_depots, 0.0)
    rows, columns = linear_sum_assignment(cost)
    return _down(float(cost[rows, columns].sum()) / instance.n_depots, instance, upper)


def arborescence(instance: Instance, upper: float) -> float:
    """Return the cheapest arborescence from the depots and a way home, or reversed, a UAV's share of it [s]."""
    n = instance.n_tasks
    best = 0.0
    for cost in (np.minimum(instance.cost, 2 * upper), np.minimum(instance.cost.T, 2 * upper)):
        merged = np.full((n + 1, n + 1), np.inf)
        merged[:n, :n] = cost[:n, :n]
        merged[n, :n] = cost[n:, :n].min(axis=0)
        total = cheapest_arborescence(merged) + float(cost[:n, n:].min())
        best = max(best, total / instance.n_depots)
    return _down(best, instance, upper)


SIMPLE: dict[str, Callable[[Instance, float], float]] = {
    "farthest": farthest,
    "assignment": assignment,
    "arborescence": arborescence,
}


def cheapest_arborescence(cost: NDArray[np.float64]) -> float:
    """Return the cost of the cheapest arborescence from the last node that spans all nodes.

    cost : ``cost[i, j]`` of the arc i → j; the diagonal is ignored.

    Chu & Liu (1965), Edmonds (1967): take the cheapest arc into each node off all arcs into it; where the arcs of cost
    0 so made form a cycle, contract it, and go on. What was taken off is the cost.
    """
    cost = cost.copy()
    total = 0.0
    while True:
        root = len(cost) - 1
        np.fill_diagonal(cost, np.inf)
        parent = cost[:, :root].argmin(axis=0)
        least = cost[parent, np.arange(root)]
        total += float(least.sum())
        cost[:, :root] -= least
        cycle = _cycle(parent)
        if not len(cycle):
            return total
        others = np.setdiff1d(np.arange(root + 1), cycle)
        contracted = np.full((len(others) + 1, len(others) + 1), np.inf)
        # the contracted node goes first: the root stays last
        contracted[1:, 1:] = cost[np.ix_(others, others)]
        contracted[0, 1:] = cost[np.ix_(cycle, others)].min(axis=0)
        contracted[1:, 0] = cost[np.ix_(others, cycle)].min(axis=1)
        cost = contracted


def _cycle(parent: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the nodes of one cycle of the arcs parent → node, or none; the root has no parent."""
    root = len(parent)
    seen = np.full(root + 1, -1)
    seen[root] = root
    for first in range(root):
        node = first
        while seen[node] < 0:
            seen[node] = first
            node = int(parent[node])
        if node != root and seen[node] == first:
            cycle = [node]
            while (node := int(parent[node])) != cycle[0]:
                cycle.append(node)
            return np.array(cycle)
    return np.array([], dtype=np.intp)


def _down(value: float, instance: Instance, upper: float) -> float:
    """Return `value` less its rounding error, no more than `upper` and no less than 0."""
    return min(upper, max(0.0, value - instance.n_nodes**2 * 2.0**-52 * upper))
