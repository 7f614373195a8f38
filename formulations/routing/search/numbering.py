"""Numbering: where tasks are many a search numbers them anew, so that near tasks have numbers near each other.

What a search of thousands of tasks waits for is costs that the processor's cache does not hold; of near tasks it reads
costs, places and neighbours together. Numbered as they come to be flown to from the first one, each time to the
nearest, these lie together as well: kicks on rl5915_10, in whose file few near tasks follow each other, take 15 % less
time. Gaps with and without: `tests/benchmarks/search.py ablation`, measured.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, between, both_ways, search_costs
from formulations.routing.search.nearest_in_turn import visited_in_turn
from formulations.routing.search.problem_data import Nodes
from instances import Instance, Routes

_A_SECOND = 5_000_000
"""Costs that are copied for each second of the limit, at most: that takes 3 to 15 % of it where memory is scarce."""


class Numbering(NamedTuple):
    """order (n,): which task of the instance each task of the search is."""

    order: Nodes

    def costs(self, instance: Instance) -> Costs:
        """Return the costs of the instance's UAVs by the numbers of the search."""
        n, m = instance.n_tasks, instance.n_depots
        if np.array_equal(self.order, np.arange(n)):
            return search_costs(instance)
        return both_ways(between(instance.cost, np.concatenate([self.order, n + np.arange(m)])))

    def of_instance(self, routes: Routes) -> Routes:
        """Return routes of a search as the instance numbers their tasks."""
        return tuple(tuple(self.order[list(route)].tolist()) for route in routes)

    def of_search(self, routes: Routes) -> Routes:
        """Return routes of an instance as the search numbers their tasks."""
        number = np.argsort(self.order)
        return tuple(tuple(number[list(route)].tolist()) for route in routes)


def numbering(instance: Instance, many: int, limit: float) -> Numbering:
    """Return the numbering of a search that may take `limit` [s].

    That of the instance where tasks are fewer than `many` or too many to be numbered soon, UAVs differ or there is no
    matrix.
    """
    entries = (instance.n_tasks + instance.n_depots) ** 2
    if instance.n_tasks < many or entries > _A_SECOND * limit or instance.axes or instance.by_metric is not None:
        return Numbering(np.arange(instance.n_tasks, dtype=np.int32))
    order, _ = visited_in_turn(instance.cost, np.empty((instance.n_tasks, 0), np.int32), 0)
    return Numbering(order)
