"""Ways: the cheapest legs between points on the visibility graph of a region, costed in the wind.

A leg is a straight line or bends at corners of obstacles, its cost that of the mission (`instances.moving_cost`), found
by Dijkstra on the graph that the moving costs' searches share (`moving_cost.graph`). That is within a re-plan's time
where the search of `moving_cost.refined` is not; what it gives away is the bending of paths in the wind's vorticity, a
fraction of a per cent of a tour.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.moving_cost.field import search_field
from formulations.moving_cost.free_space import free_space
from formulations.moving_cost.graph import build_graph
from formulations.moving_cost.tree import shortest_path_trees, tree_paths
from instances.arrays import Floats
from instances.environment.region import Region
from instances.moving_cost import CostMeasure
from instances.paths import Paths


@dataclass(frozen=True, eq=False)
class Legs:
    """Legs between n points: `cost` (n, n) [s], +inf where there is no way, and the way itself by `path`.

    points : (n, 2) [m]; ways : between the same, in the region; none between points at one place.
    """

    points: Floats
    cost: Floats
    ways: Paths

    def path(self, i: int, j: int) -> Floats:
        """Return the polyline from point i to point j, shape (k, 2) [m], k ≥ 2."""
        # a point beyond the border is left by the nearest point of the region
        line = np.concatenate([self.points[[i]], self.ways.between(i, j), self.points[[j]]])
        kept = np.append(True, (np.diff(line, axis=0) != 0).any(axis=1))
        return line[kept] if kept.sum() > 1 else line[[0, -1]]


class Ways:
    """Where legs may lead and what they cost."""

    def __init__(self, region: Region, measure: CostMeasure) -> None:
        self.region, self.measure = region, measure
        self._field, self._space = search_field(measure, region), free_space(region)

    def between(self, points: Floats) -> Legs:
        """Return the legs between `points` (n, 2) [m]."""
        n, measure = len(points), self.measure.rough
        nodes = np.concatenate([self.region.snap(points), self._space.corners])
        pairs = np.column_stack(np.triu_indices(len(nodes), 1))
        pairs = pairs[(nodes[pairs[:, 0]] != nodes[pairs[:, 1]]).any(axis=1)]
        graph = build_graph(nodes, pairs, measure, self._field, self._space)
        _, predecessor = shortest_path_trees(graph.free_matrix(), np.arange(n))
        stops, offsets = tree_paths(predecessor, np.arange(n), np.arange(n))
        ways = Paths(n, nodes[stops], offsets)
        cost = measure.polylines(ways.points, offsets).reshape(n, n)
        apart = (nodes[:n, None] != nodes[None, :n]).any(axis=2)
        cost[apart & (np.diff(offsets).reshape(n, n) == 0)] = np.inf
        return Legs(points, cost, ways)
