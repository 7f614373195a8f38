"""Relief: send a UAV with time to spare to where the tours are long, however far away that is.

Ruin and recreate moves a few tasks at a time between tours that touch, so which UAV serves which crowd of tasks is
settled early in an annealing. Here a UAV leaves all its tasks to the others and takes over a piece of a long tour.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from formulations.routing.search.annealing import POWERS
from formulations.routing.search.costs import Costs
from formulations.routing.search.neighbours import Neighbours
from formulations.routing.search.randomness import below, uniform
from formulations.routing.search.recreate import WIDTH, recreate, shuffle
from formulations.routing.search.tours import Tours, clear, link, sum_costs, unlink

TRIES = 50
"""Draws of a UAV and a task before giving up."""


@njit(cache=True, nogil=True)
def reliever(costs: Costs, tours: Tours, rng: NDArray[np.uint64]) -> tuple[int, int]:
    """Return (UAV, task): the shorter of two random tours, and of two random tasks the one on the longer tour.

    The UAV can fly to the task and back in less than the longest tour. (−1, −1) where none such is drawn.
    """
    m, longest = tours.cost.size, tours.cost.max()
    n = tours.after.size - m
    for _ in range(TRIES):
        h, v = below(rng, m), below(rng, n)
        g, w = below(rng, m), below(rng, n)
        if tours.cost[g] < tours.cost[h]:
            h = g
        if tours.cost[tours.tour[w]] > tours.cost[tours.tour[v]]:
            v = w
        if tours.tour[v] != h and costs.out[n + h, v] + costs.into[n + h, v] < longest:
            return h, v
    return -1, -1


@njit(cache=True, nogil=True)
def take_over(costs: Costs, tours: Tours, h: int, v: int, limit: float) -> None:
    """Move task v, and those flown after it while tour h stays within `limit` [s], to the empty tour h."""
    n = tours.after.size - tours.cost.size
    u, so_far = n + h, 0.0
    while v < n:
        so_far += costs.into[v, u]
        if u < n and so_far + costs.out[v, n + h] > limit:
            break
        after = tours.after[v]
        unlink(costs, tours, v)
        link(costs, tours, v, u)
        u, v = v, after


@njit(cache=True, nogil=True)
def relieve(costs: Costs, near: Neighbours, tours: Tours, rng: NDArray[np.uint64]) -> None:
    """Let one UAV leave its tasks to the others and take over a piece, of random length, of a long tour."""
    h, v = reliever(costs, tours, rng)
    if h < 0:
        return
    n = near.tasks.shape[0]
    homeless = np.empty(n, np.int32)
    there_and_back = costs.out[n + h, v] + costs.into[n + h, v]
    limit = there_and_back + uniform(rng) * (tours.cost.max() - there_and_back)
    count = clear(costs, tours, h, homeless)
    take_over(costs, tours, h, v, limit)
    sum_costs(tours)
    shuffle(homeless, count, rng)
    recreate(costs, near, tours, homeless, count, POWERS[below(rng, len(POWERS))], WIDTH, rng)
