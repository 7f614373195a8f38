"""Earliest arrivals on a graph by the clock: how long an edge takes depends on when it is begun.

The time τ_e(t) of edge e begun at t is integrated along it once for each frame of the wind (`wind_frames`), whatever
trees ask for it, and is linear between them. Whoever begins an edge later is not sooner at its end,
τ_e(t') + t' ≥ τ_e(t) + t, and lines between such times keep that ("first in, first out"). Then the earliest arrival at
a node is all there is to know of the ways to it, and Dijkstra's rule, with arrivals for distances, finds it exactly on
the graph:

    a_root = departure,    a_x = min over edges e = (z, x) of a_z + τ_e(a_z)

Source: E. W. Dijkstra, Numer. Math. 1 (1959) 269–271; S. E. Dreyfus, Oper. Res. 17 (1969) 395–412, for times that
change.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from formulations.moving_cost.graph import Graph
from formulations.moving_cost.heap import pop, push
from formulations.moving_cost.method import Progress, Query
from formulations.moving_cost.tree import require_reached, tree_paths
from formulations.moving_cost.wind_frames import WindFrames, segment_times
from instances.arrays import Floats, Ints
from instances.kernels import njit
from instances.paths import Paths

THREADS = 2
"""Parts of the edges integrated, or departures searched for, at once."""


class Timetable(NamedTuple):
    """What every edge of a graph costs [s] begun at moments `step` [s] apart from 0 on, (M, frames); the last is held.

    One frame is what edges cost at all times.
    """

    step: float
    costs: Floats


def timetable(a: Floats, b: Floats, wind: WindFrames) -> Timetable:
    """Return how long edges `a` → `b`, (M, 2) [m], take in a wind that changes; inf where it is too strong for them."""
    parts = np.array_split(np.arange(len(a)), THREADS)
    with ThreadPoolExecutor(THREADS) as pool:
        costs = np.concatenate(list(pool.map(lambda part: segment_times(a[part], b[part], wind), parts)))
    for frame in range(costs.shape[1] - 2, -1, -1):  # each is integrated by itself, and off by its last digits
        np.minimum(costs[:, frame], costs[:, frame + 1] + wind.step, out=costs[:, frame])
    return Timetable(wind.step, costs)


@njit(cache=True)
def cost_at(table: Timetable, edge: int, time: float) -> float:
    """Return what `edge` costs [s] begun at `time` [s]."""
    last = table.costs.shape[1] - 1
    frame = time / table.step
    if frame >= last:
        return table.costs[edge, last]
    k = int(frame)
    return table.costs[edge, k] + (frame - k) * (table.costs[edge, k + 1] - table.costs[edge, k])


@njit(cache=True, nogil=True)
def earliest_arrivals(
    start: Ints, neighbour: Ints, table: Timetable, root: int, departure: float
) -> tuple[Floats, Ints]:
    """Return when each node is reached [s], inf where it is not, and from which, −1 for none and the root: (N,) each.

    start, neighbour : a graph in compressed rows.
    """
    n = len(start) - 1
    arrival, parent = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
    settled = np.zeros(n, dtype=np.bool_)
    keys, items = np.empty(len(neighbour) + 1), np.empty(len(neighbour) + 1, dtype=np.int64)
    arrival[root] = departure
    push(keys, items, 0, departure, root)
    size = 1
    while size > 0:
        z = pop(keys, items, size)
        size -= 1
        if settled[z]:
            continue
        settled[z] = True
        for e in range(start[z], start[z + 1]):
            x = neighbour[e]
            reached = arrival[z] + cost_at(table, e, arrival[z])
            if reached < arrival[x]:
                arrival[x], parent[x] = reached, z
                push(keys, items, size, reached, x)
                size += 1
    return arrival, parent


def earliest_paths(query: Query, graph: Graph, wind: WindFrames, moments: Floats, progress: Progress) -> list[Paths]:
    """Return the paths of earliest arrival on `graph`, whose edges are free, for departures at `moments` (k,) [s]."""
    table = timetable(graph.points[graph.tails()], graph.points[graph.neighbour], wind)

    def tree(root: int, departure: float) -> Ints:
        return earliest_arrivals(graph.start, graph.neighbour, table, root, departure)[1]

    return paths_of_trees(query, graph.points, moments, tree, progress)


def paths_of_trees(
    query: Query, points: Floats, moments: Floats, tree: Callable[[int, float], Ints], progress: Progress
) -> list[Paths]:
    """Return the paths between all terminals for departures at `moments` (k,) [s], a tree for each terminal of each.

    tree : predecessors (N,) from a terminal on, departing at a time [s]. Terminals are the first of `points`.
    """
    n = len(query.terminals)

    def plan(moment: float) -> Paths:
        nodes, offsets = tree_paths(np.stack([tree(i, moment) for i in range(n)]), np.arange(n), np.arange(n))
        require_reached(query, (np.diff(offsets) > 0).reshape(n, n))
        return Paths(n, points[nodes], offsets)

    plans = list[Paths]()
    with ThreadPoolExecutor(THREADS) as pool:
        for made in pool.map(plan, moments.tolist()):
            plans.append(made)
            progress(len(plans) / len(moments), f"trees of {len(plans)} departures of {len(moments)}")
    return plans
