"""Ways: the cheapest legs between points on the visibility graph of a region, costed in the wind.

A leg is a straight line or bends at corners of obstacles, its cost that of the mission (`instances.moving_cost`), found
by Dijkstra. That is within a re-plan's time where the search of `moving_cost.refined` is not; what it gives away is the
bending of paths in the wind's vorticity, a fraction of a per cent of a tour.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from formulations.moving_cost.free_space import free_space, segments_free
from formulations.moving_cost.tree import shortest_path_trees
from instances.arrays import Floats, Ints
from instances.environment.region import Region
from instances.moving_cost import CostMeasure


@dataclass(frozen=True, eq=False)
class Legs:
    """Legs between n points: `cost` (n, n) [s], +inf where there is no way, and the way itself by `path`.

    points : (n, 2) [m]; nodes : the same in the region, then its corners; predecessor : (n, nodes), < 0 for none.
    """

    points: Floats
    nodes: Floats
    cost: Floats
    predecessor: Ints

    def path(self, i: int, j: int) -> Floats:
        """Return the polyline from point i to point j, shape (k, 2) [m], k ≥ 2."""
        node, between = int(self.predecessor[i, j]), list[int]()
        while node >= 0 and node != i:
            between.append(node)
            node = int(self.predecessor[i, node])
        # a point beyond the border is left by the nearest point of the region
        line = np.concatenate([self.points[[i]], self.nodes[[i, *between[::-1], j]], self.points[[j]]])
        kept = np.append(True, (np.diff(line, axis=0) != 0).any(axis=1))
        return line[kept] if kept.sum() > 1 else line[[0, -1]]


class Ways:
    """Where legs may lead and what they cost."""

    def __init__(self, region: Region, measure: CostMeasure) -> None:
        self.region, self.measure = region, measure
        self._space = free_space(region)
        self._corners = self._space.corners
        self._between_corners = self._edges(self._corners, np.column_stack(np.triu_indices(len(self._corners), 1)))

    def _edges(self, nodes: Floats, pairs: Ints) -> tuple[Ints, Ints, Floats]:
        """Return (from, to, cost) of the free ones of `pairs`, both ways."""
        pairs = pairs[segments_free(nodes[pairs[:, 0]], nodes[pairs[:, 1]], self._space)]
        a, b = np.concatenate([pairs, pairs[:, ::-1]]).T
        # a wind faster than the ground speed makes energies negative: no search bears that, and no claim rests on it
        return a, b, np.maximum(self.measure.rough.segments(nodes[a], nodes[b]), 0.0)

    def between(self, points: Floats) -> Legs:
        """Return the legs between `points` (n, 2) [m]."""
        n, corners = len(points), len(self._corners)
        nodes = np.concatenate([self.region.snap(points), self._corners])
        own = np.column_stack(np.triu_indices(n, 1))
        to_corners = np.stack(np.meshgrid(np.arange(n), np.arange(n, n + corners)), axis=-1).reshape(-1, 2)
        a, b, cost = self._edges(nodes, np.concatenate([own, to_corners]))
        if len(a) == n * (n - 1) and not corners:
            direct = np.zeros((n, n))
            direct[a, b] = cost
            return Legs(points, nodes, direct, np.full((n, n), -9999, dtype=np.int64))
        more = self._between_corners
        ends = np.concatenate([a, more[0] + n]), np.concatenate([b, more[1] + n])
        graph = csr_array((np.concatenate([cost, more[2]]), ends), shape=(len(nodes), len(nodes)))
        away, predecessor = shortest_path_trees(graph, np.arange(n))
        return Legs(points, nodes, away[:, :n], predecessor)
