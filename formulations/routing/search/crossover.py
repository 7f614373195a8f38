"""Crossover: plant whole tours of one parent into the other (best-cost route crossover, Ombuki-Berman & Hanshar 2009).

The child is the first parent with some of the second parent's tours laid over its own at the same depots; tasks of the
displaced tours that are then on no tour are put back where they hurt least.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from formulations.routing.search.annealing import POWERS
from formulations.routing.search.costs import Costs
from formulations.routing.search.neighbours import Neighbours
from formulations.routing.search.randomness import below
from formulations.routing.search.recreate import WIDTH, recreate, shuffle
from formulations.routing.search.tours import Tours, link, sum_costs, unlink
from instances.arrays import Ints


@njit(cache=True, nogil=True)
def places(costs: Costs, n_tasks: int) -> Ints:
    """Return for each depot the first depot at the same place, shape (m,): the one with the same costs to all tasks."""
    n_depots = costs.out.shape[0] - n_tasks
    place = np.arange(n_depots)
    for k in range(n_depots):
        for h in range(k):
            row, other = n_tasks + k, n_tasks + h
            if np.all(costs.out[row, :n_tasks] == costs.out[other, :n_tasks]) and np.all(
                costs.into[row, :n_tasks] == costs.into[other, :n_tasks]
            ):
                place[k] = h
                break
    return place


@njit(cache=True, nogil=True)
def matching_tour(child: Tours, donor: Tours, k: int, place: Ints) -> int:
    """Return the child's tour from the place of donor tour k that shares most tasks with it."""
    n_depots = child.cost.size
    depot = child.after.size - n_depots + k
    shared = np.zeros(n_depots, np.int64)
    v = donor.after[depot]
    while v != depot:
        if child.tour[v] >= 0:
            shared[child.tour[v]] += 1
        v = donor.after[v]
    best = k
    for h in range(n_depots):
        if place[h] == place[k] and shared[h] > shared[best]:
            best = h
    return best


@njit(cache=True, nogil=True)
def lay_over(costs: Costs, child: Tours, donor: Tours, k: int, h: int, homeless: NDArray[np.int32], count: int) -> int:
    """Make child tour h a copy of donor tour k; add tasks left on no tour to `homeless`, return the new count."""
    n = child.after.size - child.cost.size
    v = child.after[n + h]
    while v < n:
        w = child.after[v]
        unlink(costs, child, v)
        homeless[count] = v
        count += 1
        v = w
    u, v = n + h, donor.after[n + k]
    while v < n:
        if child.tour[v] >= 0:
            unlink(costs, child, v)
        link(costs, child, v, u)
        u, v = v, donor.after[v]
    kept = 0
    for i in range(count):
        if child.tour[homeless[i]] < 0:
            homeless[kept] = homeless[i]
            kept += 1
    return kept


@njit(cache=True, nogil=True)
def crossover(costs: Costs, near: Neighbours, child: Tours, donor: Tours, place: Ints, rng: NDArray[np.uint64]) -> None:
    """Turn `child`, a copy of the first parent, into its child with `donor`, who gives up to half of the tours."""
    n, m = near.tasks.shape[0], child.cost.size
    homeless = np.empty(n, np.int32)
    order = np.arange(m).astype(np.int32)
    shuffle(order, m, rng)
    count = 0
    taken = np.zeros(m, np.uint8)
    for i in range(1 + below(rng, (m + 1) // 2)):
        h = matching_tour(child, donor, order[i], place)
        if not taken[h]:
            taken[h] = 1
            count = lay_over(costs, child, donor, order[i], h, homeless, count)
    sum_costs(child)
    shuffle(homeless, count, rng)
    recreate(costs, near, child, homeless, count, POWERS[below(rng, len(POWERS))], WIDTH, rng)
