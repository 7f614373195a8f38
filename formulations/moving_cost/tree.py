"""Trees of a multi-query search: one per start, and the paths read off them."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from formulations.moving_cost.method import MovingCosts, Query
from instances.arrays import Bools, Floats, Ints
from instances.errors import InputError
from instances.kernels import njit
from instances.paths import Paths


def shortest_path_trees(matrix: csr_array, starts: Ints) -> tuple[Floats, Ints]:
    """Return Dijkstra's distances (k, N) and predecessors (k, N), −9999 where there is none, from each of `starts`."""
    distance, predecessor = dijkstra(matrix, indices=starts, return_predecessors=True)
    return np.atleast_2d(distance), np.atleast_2d(predecessor).astype(np.int64)


@njit(cache=True)
def tree_paths(predecessor: Ints, starts: Ints, targets: Ints) -> tuple[Ints, Ints]:
    """Return the node sequences start → target in every tree, held end to end, and their offsets.

    Order: tree by tree, target by target; empty from a start to itself and where a target is not in the tree.
    """
    offsets = np.zeros(len(starts) * len(targets) + 1, dtype=np.int64)
    for fill in range(2):
        nodes = np.empty(offsets[-1] if fill else 0, dtype=np.int64)
        k = 0
        for i in range(len(starts)):
            for j in range(len(targets)):
                count = 0
                v = targets[j]
                if v != starts[i] and predecessor[i, v] >= 0:
                    while v >= 0:
                        if fill:
                            nodes[offsets[k + 1] - 1 - count] = v
                        count += 1
                        v = predecessor[i, v] if v != starts[i] else -1
                if not fill:
                    offsets[k + 1] = offsets[k] + count
                k += 1
    return nodes, offsets


def costs_of_trees(query: Query, points: Floats, predecessor: Ints, figures: dict[str, Any]) -> MovingCosts:
    """Return costs and paths between all terminals, tree k of `predecessor` (n, N) starting at terminal k = node k."""
    n = len(predecessor)
    nodes, offsets = tree_paths(predecessor, np.arange(n), np.arange(n))
    require_reached(query, (np.diff(offsets) > 0).reshape(n, n))
    cost = query.measure.polylines(points[nodes], offsets).reshape(n, n)
    return MovingCosts(cost, Paths(n, points[nodes], offsets), figures)


def require_reached(query: Query, reached: Bools) -> None:
    """Raise InputError naming the first terminal that was not `reached` (N, N), and from where."""
    n = len(query.terminals)
    missing = np.argwhere(~reached & ~np.eye(n, dtype=bool))
    if len(missing):
        i, j = missing[0]
        (ax, ay), (bx, by) = query.terminals[i], query.terminals[j]
        raise InputError(
            f"node {j} at ({bx:g}, {by:g}) m was not reached from node {i} at ({ax:g}, {ay:g}) m "
            f"({len(missing)} of {n * (n - 1)} pairs); a narrow passage needs more samples"
        )
