"""Lower bounds on the longest tour that take milliseconds: farthest task, assignment, arborescence.

    farthest       max_i min_k (cheapest way from depot k to task i + back): the UAV that visits i flies that far
    assignment     every task is entered and left once: the cheapest such arcs, subtours allowed, ÷ m, because
                   Σ_k C_k ≤ m·C_max (a UAV at home is the arc depot → depot of cost 0)
    arborescence   the arcs of all routes without the last ones span the tasks from the depots taken as one root:
                   (cheapest arborescence + cheapest way home) ÷ m, and the same with all arcs reversed

Where UAVs differ, farthest takes the ways of each UAV, and the others use that for any weights w_k ≥ 0

    Σ_k w_k C_k ≤ Σ_k w_k · C_max   and   Σ_k w_k C_k ≥ the cheapest choice of arcs at min_k w_k c_ijk (paper, costsum)

so that ÷ m becomes ÷ Σ_k w_k. With w_k ∝ the speed v_k of UAVs that differ in nothing else, w_k c_ijk is the same for
all, and the bound is that of the length ÷ Σ_k v_k.

Each subtracts (n+m)²·2^-52·U for rounding: costs are cut off at 2U, U the cost of routes known, and none of them adds
or subtracts more than (n+m)² such numbers one after another.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from instances import Instance
from instances.arrays import Floats, Ints
from instances.walks import shortest_walks


def farthest(instance: Instance, upper: float) -> float:
    """Return the longest way out to a task and back that cannot be avoided [s]."""
    costs, uavs = least_costs(instance)
    costs = np.minimum(costs, 2 * upper)
    between = [ways_between_tasks(cost, instance.n_tasks) for cost in costs]
    ways = [ways_from_depot(costs[g], between[g], k) for k, g in zip(instance.depots, uavs, strict=True)]
    return _down(float(np.min([out + back for out, back in ways], axis=0).max()), instance, upper)


def assignment(instance: Instance, upper: float) -> float:
    """Return the cheapest choice of one arc into and one out of every task, a UAV's share of it [s]."""
    cost, weight = weighted_costs(instance, upper)
    return _down(_cheapest_arcs(cost, instance, upper) / weight, instance, upper)


def least_sum(instance: Instance, upper: float) -> float:
    """Return the cheapest choice of one arc into and one out of every task [s]: Σ_k C_k of no routes is less.

    upper : a cost [s] that the sum need not pass.
    """
    return _down(_cheapest_arcs(np.minimum(instance.cost, 2 * upper), instance, upper), instance, upper)


def _cheapest_arcs(cost: Floats, instance: Instance, upper: float) -> float:
    """Return the cost [s] of the cheapest choice of arcs at `cost` (N, N) ≤ 2·upper, which is overwritten."""
    n = instance.n_tasks
    never = 4.0 * upper * instance.n_nodes
    cost[:n, :n][np.diag_indices(n)] = never
    between_depots = cost[n:, n:]
    between_depots[:] = never
    np.fill_diagonal(between_depots, 0.0)
    rows, columns = linear_sum_assignment(cost)
    return float(cost[rows, columns].sum())


def arborescence(instance: Instance, upper: float) -> float:
    """Return the cheapest arborescence from the depots and a way home, or reversed, a UAV's share of it [s]."""
    n, (forwards, weight) = instance.n_tasks, weighted_costs(instance, upper)
    best = 0.0
    for cost in (forwards, forwards.T):
        merged = np.full((n + 1, n + 1), np.inf)
        merged[:n, :n] = cost[:n, :n]
        merged[n, :n] = cost[n:, :n].min(axis=0)
        total = cheapest_arborescence(merged) + float(cost[:n, n:].min())
        best = max(best, total / weight)
    return _down(best, instance, upper)


def least_costs(instance: Instance) -> tuple[Floats, Ints]:
    """Return what the legs cost each class of UAV at least [s], (G, N, N), and the class of each UAV, (m,)."""
    if instance.axes & {"time", "states"}:
        return instance.cost[None], np.zeros(instance.n_depots, dtype=np.int64)
    return instance.class_costs, instance.classes


def weighted_costs(instance: Instance, upper: float) -> tuple[Floats, float]:
    """Return min_k w_k c_ijk [s], (N, N), with costs cut off at twice `upper`, and Σ_k w_k; greatest w_k 1.

    w_k is inverse to what the legs that all classes fly cost UAV k, so that cheap UAVs do not pass for all. An arc that
    begins or ends at a depot is of its UAV. Products are rounded down, and the sum up.
    """
    n, (costs, uavs) = instance.n_tasks, least_costs(instance)
    if len(costs) == 1:
        return np.minimum(costs[0], 2 * upper), instance.n_depots
    sums = costs[:, np.isfinite(costs).all(axis=0)].sum(axis=1)
    least = sums.min()
    weight = least / sums if least > 0 else np.ones(len(costs))
    weighted = weight[:, None, None] * np.minimum(costs, 2 * upper) * (1 - 2.0**-51)
    cost = weighted.min(axis=0)
    depots = np.array(instance.depots)
    cost[depots, :n], cost[:n, depots] = weighted[uavs, depots, :n], weighted[uavs, :n, depots].T
    return cost, float(weight[uavs].sum()) * (1 + len(uavs) * 2.0**-52)


def worst_makespan(instance: Instance) -> float:
    """Return a cost > 0 [s] that the longest tour of no routes passes: what to begin with where none are known.

    A tour enters each node at most once, and ends within the endurance.
    """
    longest = 0.0
    for k, (depot, limit) in enumerate(zip(instance.depots, instance.limits, strict=True)):
        nodes = [*instance.tasks, depot]
        cost = dearest_legs(instance, k)[np.ix_(nodes, nodes)]
        dearest = np.where(np.isfinite(cost), cost, 0.0).max(axis=0)
        longest = max(longest, min(float(dearest.sum()), float(limit)))
    return longest * (1 + 1e-8) or 1.0


def dearest_legs(instance: Instance, k: int) -> Floats:
    """Return the most that legs between nodes cost UAV k [s], over all states and times, (N, N)."""
    if instance.travel is None or not instance.axes & {"states", "time"}:
        return instance.uav_cost(k)
    cost = instance.travel.cost[instance.travel.classes[k]]
    first = np.searchsorted(instance.travel.nodes, np.arange(instance.n_nodes))
    cost = np.where(np.isfinite(cost), cost, 0.0).max(axis=0)
    return np.maximum.reduceat(np.maximum.reduceat(cost, first, axis=0), first, axis=1)


SIMPLE = {"farthest": farthest, "assignment": assignment, "arborescence": arborescence}


def cheapest_arborescence(cost: Floats) -> float:
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


def ways_between_tasks(cost: Floats, n_tasks: int) -> Floats:
    """Return the cost of the cheapest way from each task to each, over tasks only, shape (n, n), rounded down."""
    return shortest_walks(cost[:n_tasks, :n_tasks]) * (1 - (n_tasks + 2) * 2.0**-52)


def ways_from_depot(cost: Floats, between: Floats, k: int) -> tuple[Floats, Floats]:
    """Return the cheapest ways from depot k (node number) to each task and back, shape (n,) each, rounded down."""
    n = len(between)
    out = (cost[k, :n, None] + between).min(axis=0)
    back = (between + cost[None, :n, k]).min(axis=1)
    return out * (1 - 2.0**-52), back * (1 - 2.0**-52)
