"""Lower bounds on the longest tour that take milliseconds: farthest task, assignment, arborescence.

    farthest       max_i min_k (cheapest way from depot k to task i + back): the UAV that visits i flies that far
    assignment     every task is entered and left once: the cheapest such arcs, subtours allowed, ÷ m, because
                   Σ_k C_k ≤ m·C_max (a UAV at home is the arc depot → depot of cost 0)
    arborescence   the arcs of all routes without the last ones span the tasks from the depots taken as one root:
                   (cheapest arborescence + cheapest way home) ÷ m, and the same with all arcs reversed

Each subtracts (n+m)²·2^-52·U for rounding: costs are cut off at 2U, U the cost of routes known, and none of them adds
or subtracts more than (n+m)² such numbers one after another.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from instances import Instance
from instances.arrays import Floats
from instances.walks import shortest_walks


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
