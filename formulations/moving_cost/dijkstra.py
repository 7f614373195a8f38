"""dijkstra: shortest paths on the random graph of fmt-star, every edge tested for collision first.

E. W. Dijkstra, Numer. Math. 1 (1959). On the same graph it is never worse than FMT*, which settles each node
with one lazily tested edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.moving_cost.arrivals import earliest_paths
from formulations.moving_cost.field import search_field
from formulations.moving_cost.fmt_star import sample_points
from formulations.moving_cost.free_space import free_space
from formulations.moving_cost.graph import Graph, build_graph, near_pairs, standard_radius
from formulations.moving_cost.method import MovingCostMethod, MovingCosts, Progress, Query, silent
from formulations.moving_cost.tree import costs_of_trees, shortest_path_trees
from formulations.moving_cost.wind_frames import WindFrames
from instances.arrays import Floats
from instances.errors import InputError
from instances.paths import Paths


@dataclass(frozen=True)
class Dijkstra(MovingCostMethod):
    """Dijkstra's trees on the graph of fmt-star.

    samples : random samples besides the terminals (at least 1).
    radius_factor : connection radius over the standard one (above 0, at most 100).
    seed : of the samples.
    """

    samples: int = 10_000
    radius_factor: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        if self.samples < 1 or not 0 < self.radius_factor <= 100:
            raise InputError("dijkstra: samples must be at least 1 and radius_factor from 0 to 100")

    def solve(self, query: Query, progress: Progress = silent) -> MovingCosts:
        """Return costs and paths between all terminals."""
        graph, tests = self._graph(query)
        progress(0.5, "edges")
        _, predecessor = shortest_path_trees(graph.free_matrix(), np.arange(len(query.terminals)))
        progress(1.0, "trees")
        figures = {"nodes": len(graph.points), "edges": len(graph.cost), "collision_tests": tests}
        return costs_of_trees(query, graph.points, predecessor, figures)

    def by_clock(self, query: Query, wind: WindFrames, moments: Floats, progress: Progress = silent) -> list[Paths]:
        """Return the paths of earliest arrival on the graph for departures at `moments`, exact but for its frames."""
        return earliest_paths(query, self._graph(query)[0], wind, moments, progress)

    def _graph(self, query: Query) -> tuple[Graph, int]:
        """Return the graph of free edges, and how many were tested for collision."""
        field, space = search_field(query.measure, query.region), free_space(query.region)
        points = sample_points(query, self.samples, self.seed)
        pairs = near_pairs(points, self.radius_factor * standard_radius(query.region.area, len(points)))
        return build_graph(points, pairs, query.measure, field, space), len(pairs)
