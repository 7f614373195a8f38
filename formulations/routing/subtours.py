"""Subtours: finding them, and repairing a solution that has some.

A subtour is a route "which only has vertices i ∈ T and is not from the set of depots" (paper, below eq. const6).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from instances import Instance, Routes, as_routes
from instances.arrays import Floats

Arc = tuple[int, int]


def find_subtours(arcs: Sequence[Arc], depot: int, n_tasks: int) -> list[list[int]]:
    """Return the sets S of tasks that form subtours in the arcs of one UAV.

    They are the strong components of its arcs, of two tasks or more, that do not hold its depot.
    """
    if not arcs:
        return []
    node = np.array(arcs)
    size = max(depot + 1, n_tasks)
    graph = csr_array((np.ones(len(node)), (node[:, 0], node[:, 1])), shape=(size, size))
    _, label = connected_components(graph, directed=True, connection="strong")
    components: dict[int, list[int]] = {}
    for i in sorted({i for arc in arcs for i in arc}):
        components.setdefault(int(label[i]), []).append(i)
    return [S for S in components.values() if len(S) >= 2 and depot not in S]


def walk(arcs: Sequence[Arc], first: int) -> list[int]:
    """Return the nodes in the order the arcs pass them, from `first` until it comes again (left out)."""
    successor = dict(arcs)
    order = [first]
    node = successor.get(first, first)
    while node != first:
        order.append(node)
        node = successor[node]
    return order


def repair(instance: Instance, arcs_of: Sequence[Sequence[Arc]]) -> Routes:
    """Return feasible routes near a solution with subtours: each subtour is spliced into a tour.

    arcs_of : the used arcs of each UAV, in depot order; every task is entered and left once over all of them.

    The subtours go in from the longest down, each opened at the arc, and put into the tour and place, that leave the
    shortest tour of the UAV that takes it, within its endurance if one can take it. Routes that no UAV can fly may
    come of it where UAVs differ.
    """
    n, limits = instance.n_tasks, instance.limits
    costs = [instance.uav_cost(k) for k in range(instance.n_depots)]
    tours = [walk(arcs, n + k)[1:] for k, arcs in enumerate(arcs_of)]
    cycles = [walk(arcs, S[0]) for k, arcs in enumerate(arcs_of) for S in find_subtours(arcs, n + k, n)]
    lengths = np.array([_length(costs[k], [n + k, *tour]) for k, tour in enumerate(tours)])
    for cycle in sorted(cycles, key=len, reverse=True):
        k, place, opening, lengths[k] = min(
            (_best_splice(costs[k], [n + k, *tour], cycle, lengths[k], k) for k, tour in enumerate(tours)),
            key=lambda choice: (choice[3] > limits[choice[0]], choice[3]),
        )
        tours[k][place:place] = cycle[opening:] + cycle[:opening]
    return as_routes(tours)


def _length(cost: Floats, cycle: Sequence[int]) -> float:
    at = np.array(cycle)
    return float(cost[at, np.roll(at, -1)].sum())


def _best_splice(
    cost: Floats, tour: Sequence[int], cycle: Sequence[int], length: float, k: int
) -> tuple[int, int, int, float]:
    """Return (k, place, opening, length of the tour) of the best splice of `cycle` into `tour` (its depot first)."""
    inner = _length(cost, cycle)
    if np.isinf(length + inner):  # UAV k cannot fly the tour or the cycle, so differences have no meaning
        return k, 0, 0, np.inf
    a = np.array(tour)
    b = np.roll(a, -1)
    first = np.array(cycle)
    last = np.roll(first, 1)
    # a UAV at home is the tour (depot), whose arc depot → depot costs 0 (the diagonal)
    extra = cost[np.ix_(a, first)] + cost[np.ix_(last, b)].T - cost[a, b][:, None] - cost[last, first][None, :]
    place, opening = np.unravel_index(int(np.argmin(extra)), extra.shape)
    return k, int(place), int(opening), length + inner + float(extra[place, opening])
