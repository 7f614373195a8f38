"""Tours as doubly linked rings of nodes: insertion, removal and their undoing in constant time.

Each depot n+k is a node of its own ring k; an empty tour is the depot linked to itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, leg, leg_into, n_nodes
from formulations.routing.search.problem_data import Nodes
from instances import Routes
from instances.arrays import Floats, Ints
from instances.kernels import njit


class Tours(NamedTuple):
    """Rings.

    after, before (n+m,): neighbours; arc (n+m,): cost of flying on to `after` [s]; back (n+m,): cost of flying that
    leg the other way [s]; tour (n+m,): ring number of each node, −1 for a task taken out; cost (m,): C_k [s];
    size (m,): tasks of each tour.
    """

    after: Nodes
    before: Nodes
    arc: Floats
    back: Floats
    tour: Nodes
    cost: Floats
    size: Nodes


def empty_tours(n_tasks: int, n_depots: int) -> Tours:
    """Return tours with no task on any of them."""
    after = np.arange(n_tasks + n_depots, dtype=np.int32)
    tour = np.full(n_tasks + n_depots, -1, np.int32)
    tour[n_tasks:] = np.arange(n_depots)
    arc = np.zeros(n_tasks + n_depots)
    return Tours(after, after.copy(), arc, arc.copy(), tour, np.zeros(n_depots), np.zeros(n_depots, np.int32))


@njit(cache=True, nogil=True)
def copy_tours(source: Tours, target: Tours) -> None:
    """Overwrite `target` with `source`."""
    for u in range(source.after.size):  # numba compiles assigned slices ten times as long, to word their errors
        target.after[u] = source.after[u]
        target.before[u] = source.before[u]
        target.arc[u] = source.arc[u]
        target.back[u] = source.back[u]
        target.tour[u] = source.tour[u]
    for k in range(source.cost.size):
        target.cost[k] = source.cost[k]
        target.size[k] = source.size[k]


def duplicate(tours: Tours) -> Tours:
    """Return a copy."""
    return Tours._make(array.copy() for array in tours)


@njit(cache=True, nogil=True)
def longest(lengths: Floats) -> float:
    """Return the greatest of lengths (m,) ≥ 0 [s]; compiled in a fraction of the time of numpy's."""
    most = 0.0
    for length in lengths:
        if length > most:
            most = length
    return most


@njit(cache=True, nogil=True)
def join(costs: Costs, tours: Tours, k: int, u: int, w: int) -> None:
    """Let node w follow node u on tour k."""
    tours.after[u] = w
    tours.before[w] = u
    tours.arc[u] = leg(costs, k, u, w)
    tours.back[u] = leg_into(costs, k, u, w)


@njit(cache=True, nogil=True)
def link(costs: Costs, tours: Tours, v: int, u: int) -> None:
    """Put task v behind node u; the tour's cost is the caller's business."""
    w = tours.after[u]
    k = tours.tour[u]
    tours.after[u] = v
    tours.before[v] = u
    tours.after[v] = w
    tours.before[w] = v
    tours.arc[u] = leg_into(costs, k, v, u)
    tours.arc[v] = leg(costs, k, v, w)
    tours.back[u] = leg(costs, k, v, u)
    tours.back[v] = leg_into(costs, k, v, w)
    tours.tour[v] = k
    tours.size[k] += 1


@njit(cache=True, nogil=True)
def unlink(costs: Costs, tours: Tours, v: int) -> None:
    """Take task v out of its tour; the tour's cost is the caller's business."""
    u, w, k = tours.before[v], tours.after[v], tours.tour[v]
    join(costs, tours, k, u, w)
    tours.tour[v] = -1
    tours.size[k] -= 1


@njit(cache=True, nogil=True)
def removal_change(costs: Costs, tours: Tours, v: int) -> float:
    """Return the change of its tour's cost [s] if task v were taken out."""
    u, w = tours.before[v], tours.after[v]
    return leg(costs, tours.tour[v], u, w) - tours.arc[u] - tours.arc[v]


@njit(cache=True, nogil=True)
def insertion_change(costs: Costs, tours: Tours, v: int, u: int) -> float:
    """Return the change of the tour's cost [s] if task v were put behind node u."""
    k = tours.tour[u]
    return leg_into(costs, k, v, u) + leg(costs, k, v, tours.after[u]) - tours.arc[u]


@njit(cache=True, nogil=True)
def sum_costs(tours: Tours) -> None:
    """Recompute every C_k from the arcs, so that rounding of many small changes cannot gather."""
    n = tours.after.size - tours.cost.size
    for k in range(tours.cost.size):
        u, total = n + k, 0.0
        while True:
            total += tours.arc[u]
            u = tours.after[u]
            if u == n + k:
                break
        tours.cost[k] = total


@njit(cache=True, nogil=True)
def reprice(costs: Costs, tours: Tours) -> None:
    """Book anew what every leg and tour costs, after the costs have changed."""
    for u in range(tours.after.size):
        if tours.tour[u] >= 0:
            join(costs, tours, tours.tour[u], u, tours.after[u])
    sum_costs(tours)


def broken_pairs(tours: Tours, other: Tours, site: Ints) -> int:
    """Return how many tasks are flown before another node in `tours` than they are before or behind in `other`.

    Depots at one site, as `site` (m,) says, are one node: the distance of Prins, Comput. Oper. Res. 36 (2009).
    """
    n = tours.after.size - site.size
    node = np.concatenate([np.arange(n), n + site])
    after, others, behind = (node[ring[:n]] for ring in (tours.after, other.after, other.before))
    return int(np.count_nonzero((after != others) & (after != behind)))


@njit(cache=True, nogil=True)
def clear(costs: Costs, tours: Tours, k: int, removed: Nodes) -> int:
    """Take all tasks out of tour k and write them, in their order, to `removed`; return how many."""
    n = tours.after.size - tours.cost.size
    count = 0
    while tours.after[n + k] < n:
        removed[count] = tours.after[n + k]
        unlink(costs, tours, removed[count])
        count += 1
    return count


@njit(cache=True, nogil=True)
def fill(costs: Costs, tours: Tours, k: int, tasks: Nodes) -> None:
    """Fill the empty tour k with `tasks`, in their order; its cost is the caller's business."""
    u = tours.after.size - tours.cost.size + k
    for v in tasks:
        link(costs, tours, v, u)
        u = v


def from_routes(costs: Costs, routes: Routes) -> Tours:
    """Return `routes` as rings with their costs."""
    n_depots = len(routes)
    n_tasks = n_nodes(costs) - n_depots
    tours = empty_tours(n_tasks, n_depots)
    for k, route in enumerate(routes):
        fill(costs, tours, k, np.array(route, np.int32))
    sum_costs(tours)
    return tours


def to_routes(tours: Tours) -> Routes:
    """Return the rings as Routes."""
    n_depots = tours.cost.size
    n_tasks = tours.after.size - n_depots
    after = tours.after.tolist()
    routes = []
    for k in range(n_depots):
        route, v = [], after[n_tasks + k]
        while v != n_tasks + k:
            route.append(v)
            v = after[v]
        routes.append(tuple(route))
    return tuple(routes)
