"""Numbering: where tasks are many a search numbers them anew, so that near tasks have numbers near each other.

What a search of thousands of tasks waits for is costs that the processor's cache does not hold; of near tasks it reads
costs, places and neighbours together. Numbered as they come to be flown to from the first one, each time to the
nearest, these lie together as well. 30 s, four seeds, mean gaps in %, with the numbers of the file, in which few near
tasks follow each other, and with these: rl5915_3 0.40 and 0.21, rl5915_20 0.27 and −0.87.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import AlikeCosts, Costs, part_of
from instances import Routes
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit


class Numbering(NamedTuple):
    """order (n,): which task of the instance each task of the search is."""

    order: Ints

    def costs(self, costs: Costs, n_depots: int) -> Costs:
        """Return an instance's costs by the numbers of the search."""
        n = self.order.size
        if np.array_equal(self.order, np.arange(n)):
            return costs
        uavs = np.arange(n_depots)
        return part_of(costs, np.concatenate([self.order, n + uavs]), uavs)

    def of_instance(self, routes: Routes) -> Routes:
        """Return routes of a search as the instance numbers their tasks."""
        return tuple(tuple(self.order[list(route)].tolist()) for route in routes)

    def of_search(self, routes: Routes) -> Routes:
        """Return routes of an instance as the search numbers their tasks."""
        number = np.argsort(self.order)
        return tuple(tuple(number[list(route)].tolist()) for route in routes)


def numbering(costs: Costs, n_tasks: int, many: int) -> Numbering:
    """Return the numbering of a search.

    That of the instance where tasks are fewer than `many`, UAVs differ or there is no matrix.
    """
    if n_tasks < many or not isinstance(costs, AlikeCosts):
        return Numbering(np.arange(n_tasks))
    return Numbering(_in_turn(costs.out, np.zeros(n_tasks, np.bool_)))


@njit(cache=True, nogil=True)
def _in_turn(cost: Floats, passed: Bools) -> Ints:
    """Return all tasks from the first on, each followed by the nearest that is not `passed`."""
    order = np.zeros(passed.size, np.int64)
    for i in range(passed.size - 1):
        row, w, least = cost[order[i]], -1, np.inf
        passed[order[i]] = True
        for v in range(passed.size):
            if row[v] < least and not passed[v]:
                w, least = v, row[v]
        order[i + 1] = w
    return order
