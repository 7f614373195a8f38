"""Crossover: inherit whole tours from the other parent (best-cost route crossover, Ombuki-Berman & Hanshar 2009).

The child is the first parent with some of the second parent's tours instead of its own at the same depots; tasks of the
replaced tours that are then on no tour are inserted again (recreate.py). Tours inherited are any, or those of a region,
which then fit each other as they did in the other parent: selective route exchange (Nagata & Kobayashi 2010), as PyVRP
has it, begins with tours side by side, too.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.search.costs import Costs
from formulations.routing.search.decomposition import DecompositionParameters, around
from formulations.routing.search.problem_data import Nodes, ProblemData
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import RecreateParameters, recreate_all, shuffle
from formulations.routing.search.tours import Tours, clear, link, sum_costs, unlink
from instances.arrays import Ints
from instances.kernels import njit

_MANY = 5
"""Tours from which on regions are inherited: of fewer, nearly all border on each other."""
_REGION = DecompositionParameters(anywhere=0.0)


@njit(cache=True, nogil=True)
def matching_tour(child: Tours, donor: Tours, k: int, site: Ints) -> int:
    """Return the child's tour from the site of donor tour k that shares most tasks with it."""
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
        if site[h] == site[k] and shared[h] > shared[best]:
            best = h
    return best


@njit(cache=True, nogil=True)
def inherit(costs: Costs, child: Tours, donor: Tours, k: int, h: int, removed: Nodes, count: int) -> int:
    """Make child tour h a copy of donor tour k; add tasks left on no tour to `removed`, return the new count."""
    n = child.after.size - child.cost.size
    count += clear(costs, child, h, removed[count:])
    u, v = n + h, donor.after[n + k]
    while v < n:
        if child.tour[v] >= 0:
            unlink(costs, child, v)
        link(costs, child, v, u)
        u, v = v, donor.after[v]
    kept = 0
    for i in range(count):
        if child.tour[removed[i]] < 0:
            removed[kept] = removed[i]
            kept += 1
    return kept


def crossover(
    data: ProblemData, child: Tours, donor: Tours, regions: float, parameters: RecreateParameters, rng: Rng
) -> None:
    """Turn `child`, a copy of the first parent, into its child with `donor`, who gives up to half of the tours.

    regions: probability that these are of one region, where there are many tours.
    """
    m = data.size[1]
    given = some_tours(m, rng)
    if m >= _MANY and regions > 0.0 and uniform(rng) < regions:
        given = around(data.near, donor, int(given[0]), given.size, _REGION, rng)
    recreate_all(data, child, inherit_some(data.costs, data.site, child, donor, given, rng), parameters, rng)


@njit(cache=True, nogil=True)
def some_tours(m: int, rng: Rng) -> Nodes:
    """Return up to half of m tours, drawn at random."""
    order = np.empty(m, np.int32)
    for k in range(m):
        order[k] = k
    shuffle(order, m, rng)
    return order[: 1 + below(rng, (m + 1) // 2)]


@njit(cache=True, nogil=True)
def inherit_some(costs: Costs, site: Ints, child: Tours, donor: Tours, given: Nodes, rng: Rng) -> Nodes:
    """Make child tours those `given` of the donor; return the tasks left on no tour, in random order."""
    m = child.cost.size
    removed = np.empty(child.after.size - m, np.int32)
    count = 0
    taken = np.zeros(m, np.uint8)
    for k in given:
        h = matching_tour(child, donor, k, site)
        if not taken[h]:
            taken[h] = 1
            count = inherit(costs, child, donor, k, h, removed, count)
    sum_costs(child)
    shuffle(removed, count, rng)
    return removed[:count]
