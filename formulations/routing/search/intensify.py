"""Intensification: every tour gets a better order of its tasks, each by a search of its own (local_search.py)."""

from __future__ import annotations

import numpy as np

from formulations.routing.search.costs import Costs
from formulations.routing.search.local_search import LocalSearchParameters, closed_tour, improve
from formulations.routing.search.randomness import Rng
from formulations.routing.search.tours import Tours, clear, fill, sum_costs
from instances.kernels import njit


@njit(cache=True, nogil=True)
def intensify(costs: Costs, tours: Tours, rng: Rng, kicks: float, parameters: LocalSearchParameters) -> None:
    """Improve the order of every tour, in place, with `kicks` double bridges for each of its tasks."""
    for k in range(tours.cost.size):
        if tours.size[k] >= parameters.fewest:
            _intensify_one(costs, tours, k, rng, kicks, parameters)
    sum_costs(tours)


@njit(cache=True, nogil=True)
def _intensify_one(
    costs: Costs, tours: Tours, k: int, rng: Rng, kicks: float, parameters: LocalSearchParameters
) -> None:
    """Improve the order of tour k; its cost is the caller's business."""
    nodes = np.empty(tours.size[k] + 1, np.int32)
    nodes[0] = tours.after.size - tours.cost.size + k
    for i in range(1, nodes.size):
        nodes[i] = tours.after[nodes[i - 1]]
    cost = np.empty((nodes.size, nodes.size))
    for i in range(nodes.size):
        for j in range(nodes.size):
            cost[i, j] = costs.out[nodes[i], nodes[j]]
    tour = closed_tour(cost, parameters)
    before = tour.segments.forward[-1]
    improve(tour, rng, int(kicks * tours.size[k]))
    if tour.segments.forward[-1] < before:
        clear(costs, tours, k, np.empty(nodes.size, np.int32))
        fill(costs, tours, k, nodes[tour.segments.nodes[1:-1]])
