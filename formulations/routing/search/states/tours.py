"""Tours over states: orders of nodes, with prefixes and suffixes of the cheapest chains kept at every node."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.states.costs import Singles, StateCosts
from instances import Routes
from instances.arrays import Floats, Ints
from instances.kernels import njit


class StateTours(NamedTuple):
    """The tours of all UAVs. Arrays are changed in place.

    order (m, n), size (m,) : tasks of each tour in flying order. tour, place (n,) : where a task is; tour −1: nowhere.
    prefix, suffix (N, H) : least cost from the depot to each state of a node, and from there home; of a depot what a
    tour begins and ends with, 0 or +inf. near, home (N,) : the least of them. cost (m,) : C_k.
    kept (m,) : the state of the depot that a closed tour begins and ends in; −1: any.
    """

    order: Ints
    size: Ints
    tour: Ints
    place: Ints
    prefix: Singles
    suffix: Singles
    near: Floats
    home: Floats
    cost: Floats
    kept: Ints


def empty_tours(costs: StateCosts) -> StateTours:
    """Return tours of which every UAV stays home."""
    m, nodes = costs.classes.size, costs.first.size - 1
    n, widest = nodes - m, int(np.diff(costs.first).max())
    tours = StateTours(
        np.zeros((m, n), np.int64),
        np.zeros(m, np.int64),
        np.full(n, -1, np.int64),
        np.zeros(n, np.int64),
        np.full((nodes, widest), np.inf, np.float32),
        np.full((nodes, widest), np.inf, np.float32),
        np.zeros(nodes),
        np.zeros(nodes),
        np.zeros(m),
        np.full(m, 0 if costs.closed else -1, np.int64),
    )
    for k in range(m):
        keep(costs, tours, k, tours.kept[k])
    return tours


@njit(cache=True, nogil=True)
def keep(costs: StateCosts, tours: StateTours, k: int, state: int) -> None:
    """Let tour k begin and end in this state of its depot, −1: in any; it is then to be booked."""
    depot = costs.first.size - 1 - costs.classes.size + k
    tours.kept[k] = state
    for a in range(costs.first[depot + 1] - costs.first[depot]):
        tours.prefix[depot, a] = tours.suffix[depot, a] = 0.0 if state < 0 or a == state else np.inf


@njit(cache=True, nogil=True)
def chain(legs: Singles, spent: Singles, u: int, w: int, first: Ints, out: Singles) -> None:
    """Write to `out` the least cost to each state of node w, with `spent` for each of node u and `legs` (S, S)."""
    width = first[w + 1] - first[w]
    out[:width] = np.inf
    for a in range(first[u + 1] - first[u]):
        row, before = legs[first[u] + a, first[w] : first[w + 1]], spent[a]
        if before < np.inf:
            for c in range(width):
                total = before + row[c]
                out[c] = total if total < out[c] else out[c]


@njit(cache=True, nogil=True)
def book(costs: StateCosts, tours: StateTours, k: int, begin: int, end: int) -> None:
    """Renew prefixes from position `begin` of tour k on, suffixes from position `end` back, and its cost."""
    first, g, size = costs.first, costs.classes[k], tours.size[k]
    depot = first.size - 1 - costs.classes.size + k
    order = tours.order[k]
    if size == 0:
        tours.cost[k] = 0.0
        return
    for p in range(begin, size):
        u, v = order[p - 1] if p else depot, order[p]
        chain(costs.legs[g], tours.prefix[u], u, v, first, tours.prefix[v])
        tours.near[v] = tours.prefix[v, : first[v + 1] - first[v]].min()
        tours.tour[v], tours.place[v] = k, p
    for p in range(end, -1, -1):
        v, w = order[p], order[p + 1] if p + 1 < size else depot
        chain(costs.back[g], tours.suffix[w], w, v, first, tours.suffix[v])
        tours.home[v] = tours.suffix[v, : first[v + 1] - first[v]].min()
    best, v = np.inf, order[0]
    for c in range(first[v + 1] - first[v]):
        best = min(best, tours.prefix[v, c] + tours.suffix[v, c])
    tours.cost[k] = best


@njit(cache=True, nogil=True)
def with_task(costs: StateCosts, tours: StateTours, k: int, v: int, p: int, room: Singles) -> float:
    """Return what tour k costs with task v at position p; `room` (2, H) is written to."""
    first, g = costs.first, costs.classes[k]
    depot = first.size - 1 - costs.classes.size + k
    u = tours.order[k, p - 1] if p else depot
    w = tours.order[k, p] if p < tours.size[k] else depot
    chain(costs.legs[g], tours.prefix[u], u, v, first, room[0])
    chain(costs.back[g], tours.suffix[w], w, v, first, room[1])
    best = np.float32(np.inf)
    for c in range(first[v + 1] - first[v]):
        total = room[0, c] + room[1, c]
        best = total if total < best else best
    return float(best)


@njit(cache=True, nogil=True)
def insert(costs: StateCosts, tours: StateTours, k: int, v: int, p: int) -> None:
    """Put task v at position p of tour k and book it."""
    order = tours.order[k]
    for q in range(tours.size[k], p, -1):
        order[q] = order[q - 1]
    order[p] = v
    tours.size[k] += 1
    book(costs, tours, k, p, p)


@njit(cache=True, nogil=True)
def rekeep(costs: StateCosts, tours: StateTours, k: int) -> None:
    """Let the closed tour k begin and end in the state of its depot that makes it cheapest."""
    depot = costs.first.size - 1 - costs.classes.size + k
    best, kept = tours.cost[k], tours.kept[k]
    for state in range(costs.first[depot + 1] - costs.first[depot]):
        keep(costs, tours, k, state)
        book(costs, tours, k, 0, tours.size[k] - 1)
        if tours.cost[k] < best:
            best, kept = tours.cost[k], state
    keep(costs, tours, k, kept)
    book(costs, tours, k, 0, tours.size[k] - 1)


@njit(cache=True, nogil=True)
def copy_tours(of: StateTours, to: StateTours) -> None:
    """Copy all of `of` into `to`."""
    to.order[:], to.size[:], to.tour[:], to.place[:] = of.order, of.size, of.tour, of.place
    to.prefix[:], to.suffix[:], to.near[:], to.home[:] = of.prefix, of.suffix, of.near, of.home
    to.cost[:], to.kept[:] = of.cost, of.kept


def from_routes(costs: StateCosts, routes: Routes) -> StateTours:
    """Return complete routes as tours."""
    tours = empty_tours(costs)
    for k, route in enumerate(routes):
        tours.order[k, : len(route)] = route
        tours.size[k] = len(route)
        book(costs, tours, k, 0, len(route) - 1)
        if costs.closed and route:
            rekeep(costs, tours, k)
    return tours


def to_routes(tours: StateTours) -> Routes:
    """Return the tours as routes."""
    return tuple(tuple(row[:size].tolist()) for row, size in zip(tours.order, tours.size, strict=True))
