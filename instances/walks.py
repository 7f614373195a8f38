"""Shortest walks: the cheapest way from each node to each other one, over any of the nodes."""

from __future__ import annotations

import numpy as np

from instances.arrays import Floats


def shortest_walks(cost: Floats) -> Floats:
    """Return the cheapest cost of getting from each node to each, over any nodes, 0 on the diagonal.

    cost : ``cost[i, j]`` ≥ 0 of the leg i → j, infinite where there is none, shape (n, n); the diagonal is ignored. Any
        unit. Floyd, "Algorithm 97: Shortest path", Commun. ACM 5 (1962); Warshall, J. ACM 9 (1962).
    """
    walk = cost.copy()
    np.fill_diagonal(walk, 0.0)
    for via in range(len(walk)):
        np.minimum(walk, walk[:, via, None] + walk[None, via, :], out=walk)
    return walk
