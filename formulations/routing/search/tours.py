"""Tours as doubly linked rings of nodes: insertion, removal and their undoing in constant time.

Each depot n+k is a node of its own ring k; an empty tour is the depot linked to itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from instances import Routes


class Tours(NamedTuple):
    """after, before (n+m,): ring neighbours; tour (n+m,): ring number of each node, −1 for a task taken out;
    cost (m,): C_k [s]; size (m,): tasks of each tour."""

    after: NDArray[np.int32]
    before: NDArray[np.int32]
    tour: NDArray[np.int32]
    cost: NDArray[np.float64]
    size: NDArray[np.int32]


@njit(cache=True, nogil=True)
def empty_tours(n_tasks: int, n_depots: int) -> Tours:
    """Return tours with no task on any of them."""
    after = np.arange(n_tasks + n_depots).astype(np.int32)
    tour = np.full(n_tasks + n_depots, -1, np.int32)
    for k in range(n_depots):
        tour[n_tasks + k] = k
    return Tours(after, after.copy(), tour, np.zeros(n_depots), np.zeros(n_depots, np.int32))


@njit(cache=True, nogil=True)
def copy_tours(source: Tours, target: Tours) -> None:
    """Overwrite `target` with `source`."""
    target.after[:] = source.after
    target.before[:] = source.before
    target.tour[:] = source.tour
    target.cost[:] = source.cost
    target.size[:] = source.size


@njit(cache=True, nogil=True)
def link(tours: Tours, v: int, u: int) -> None:
    """Put task v behind node u; costs are the caller's business."""
    w = tours.after[u]
    k = tours.tour[u]
    tours.after[u] = v
    tours.before[v] = u
    tours.after[v] = w
    tours.before[w] = v
    tours.tour[v] = k
    tours.size[k] += 1


@njit(cache=True, nogil=True)
def unlink(tours: Tours, v: int) -> None:
    """Take task v out of its tour; costs are the caller's business."""
    u, w, k = tours.before[v], tours.after[v], tours.tour[v]
    tours.after[u] = w
    tours.before[w] = u
    tours.tour[v] = -1
    tours.size[k] -= 1


@njit(cache=True, nogil=True)
def removal_change(cost: NDArray[np.float64], tours: Tours, v: int) -> float:
    """Return the change of its tour's cost [s] if task v were taken out."""
    u, w = tours.before[v], tours.after[v]
    return cost[u, w] - cost[u, v] - cost[v, w]


@njit(cache=True, nogil=True)
def insertion_change(cost: NDArray[np.float64], tours: Tours, v: int, u: int) -> float:
    """Return the change of the tour's cost [s] if task v were put behind node u."""
    w = tours.after[u]
    return cost[u, v] + cost[v, w] - cost[u, w]


@njit(cache=True, nogil=True)
def sum_costs(cost: NDArray[np.float64], tours: Tours) -> None:
    """Recompute every C_k from the arcs, so that rounding of many small changes cannot gather."""
    n = tours.after.size - tours.cost.size
    for k in range(tours.cost.size):
        u, total = n + k, 0.0
        while True:
            w = tours.after[u]
            total += cost[u, w]
            u = w
            if u == n + k:
                break
        tours.cost[k] = total


def from_routes(cost: NDArray[np.float64], routes: Routes) -> Tours:
    """Return `routes` as rings with their costs."""
    n_depots = len(routes)
    n_tasks = cost.shape[0] - n_depots
    tours = empty_tours(n_tasks, n_depots)
    for k, route in enumerate(routes):
        u = n_tasks + k
        for v in route:
            link(tours, v, u)
            u = v
    sum_costs(cost, tours)
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
