"""fmt-star: the paper's modified Fast Marching Tree (§Calculation of Moving Cost).

Fast Marching Tree* (Janson, Schmerling, Clark & Pavone, IJRR 34, 2015): random samples, and a tree grown outward
in order of cost; each new sample is connected to the best open neighbour, and only that one edge is tested for
collision (lazy). The paper's modifications:

1. the cost of an edge is its energy or time in the wind (`instances.moving_cost`), another one each way;
2. multi-query: one tree per start gives the paths to all other terminals, n problems instead of n²;
3. the n problems share the information on edges: costs are computed once, and so is every collision test.

`share = False` switches 3 off, for the measurement of what it saves.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from formulations.moving_cost.arrivals import Timetable, cost_at, paths_of_trees, timetable
from formulations.moving_cost.field import search_field
from formulations.moving_cost.free_space import FreeSpace, free_space, segment_free
from formulations.moving_cost.graph import BLOCKED, FREE, UNKNOWN, Graph, build_graph, near_pairs, standard_radius
from formulations.moving_cost.heap import pop, push
from formulations.moving_cost.method import MovingCostMethod, MovingCosts, Progress, Query, silent
from formulations.moving_cost.tree import costs_of_trees
from formulations.moving_cost.wind_frames import WindFrames
from instances.arrays import Floats, Ints
from instances.errors import InputError
from instances.kernels import njit
from instances.paths import Paths

UNVISITED, OPEN, CLOSED = 0, 1, 2
"""What a node is while a tree grows; open nodes are in the heap."""


@dataclass(frozen=True)
class FmtStar(MovingCostMethod):
    """FMT* as in the paper.

    samples : random samples besides the terminals (at least 1).
    radius_factor : connection radius over the standard one (above 0, at most 100); twice the radius gives five times
        smaller excess.
    seed : of the samples.
    share : whether the starts share edge and collision information.
    """

    samples: int = 10_000
    radius_factor: float = 1.0
    seed: int = 0
    share: bool = True

    def __post_init__(self) -> None:
        if self.samples < 1 or not 0 < self.radius_factor <= 100:
            raise InputError("fmt-star: samples must be at least 1 and radius_factor from 0 to 100")

    def solve(self, query: Query, progress: Progress = silent) -> MovingCosts:
        """Return costs and paths between all terminals."""
        began = time.process_time()
        n = len(query.terminals)
        field, space = search_field(query.measure, query.region), free_space(query.region)
        points = sample_points(query, self.samples, self.seed)
        pairs = near_pairs(points, self.radius_factor * standard_radius(query.region.area, len(points)))
        predecessor = np.empty((n, len(points)), dtype=np.int64)
        graph: Graph | None = None
        tests = 0
        for i in range(n):
            if graph is None or not self.share:
                graph = build_graph(points, pairs, query.measure, field, None)
            predecessor[i], tested = grow_tree(graph, Timetable(1.0, graph.back[:, None]), space, i, 0.0)
            tests += tested
            progress((i + 1) / n, f"tree {i + 1} of {n}")
        planned = time.process_time() - began
        figures = {"nodes": len(points), "edges": 2 * len(pairs), "collision_tests": tests, "planning_cpu": planned}
        return costs_of_trees(query, points, predecessor, figures)

    def by_clock(self, query: Query, wind: WindFrames, moments: Floats, progress: Progress = silent) -> list[Paths]:
        """Return the paths between all terminals for departures at `moments`: open neighbours compared by arrival."""
        field, space = search_field(query.measure, query.region), free_space(query.region)
        points = sample_points(query, self.samples, self.seed)
        pairs = near_pairs(points, self.radius_factor * standard_radius(query.region.area, len(points)))
        graph = build_graph(points, pairs, query.measure, field, None)
        a, b = points[graph.tails()], points[graph.neighbour]
        back = timetable(b, a, wind)

        def tree(root: int, departure: float) -> Ints:
            return grow_tree(graph, back, space, root, departure)[0]

        return paths_of_trees(query, points, moments, tree, progress)


def sample_points(query: Query, samples: int, seed: int) -> Floats:
    """Return the terminals followed by uniform random samples of the region, (N, 2) [m]."""
    return np.concatenate([query.terminals, query.region.sample(samples, np.random.default_rng(seed))])


@njit(cache=True)
def _best_open_neighbour(
    x: int, graph: Graph, back: Timetable, status: NDArray[np.int8], value: Floats
) -> tuple[float, int]:
    """Return the least cost of reaching `x` from an open node, and the edge out of `x` to that node."""
    best, via = np.inf, -1
    for e in range(graph.start[x], graph.start[x + 1]):
        y = graph.neighbour[e]
        if status[y] == OPEN:
            reached = value[y] + cost_at(back, e, value[y])
            if reached < best:
                best, via = reached, e
    return best, via


@njit(cache=True, nogil=True)
def grow_tree(graph: Graph, back: Timetable, space: FreeSpace, root: int, departure: float) -> tuple[Ints, int]:
    """Grow one FMT* tree from `root` on: predecessors (N,), −1 for the root and what was not reached; tests made.

    back : what edges flown backwards cost. departure : when it is begun [s], where that matters.
    """
    points, start, neighbour, state = graph.points, graph.start, graph.neighbour, graph.state
    n = len(points)
    status = np.zeros(n, dtype=np.int8)
    value = np.full(n, np.inf)
    parent = np.full(n, -1, dtype=np.int64)
    keys, items = np.empty(n), np.empty(n, dtype=np.int64)
    push(keys, items, 0, departure, root)
    size, tests = 1, 0
    status[root], value[root] = OPEN, departure
    fresh = np.empty(n, dtype=np.int64)
    while size > 0:
        z = pop(keys, items, size)
        size -= 1
        count = 0
        for e in range(start[z], start[z + 1]):
            x = neighbour[e]
            if status[x] != UNVISITED:
                continue
            best, via = _best_open_neighbour(x, graph, back, status, value)
            k = graph.pair[via]
            if state[k] == UNKNOWN:
                tests += 1
                y = neighbour[via]
                free = segment_free(points[y, 0], points[y, 1], points[x, 0], points[x, 1], space)
                state[k] = FREE if free else BLOCKED
            if state[k] == FREE:
                value[x], parent[x] = best, neighbour[via]
                fresh[count] = x
                count += 1
                status[x] = CLOSED  # not a parent for others found in this same round
        for i in range(count):
            x = fresh[i]
            status[x] = OPEN
            push(keys, items, size, value[x], x)
            size += 1
        status[z] = CLOSED
    return parent, tests
