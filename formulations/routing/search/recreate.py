"""Recreate (Schrimpf et al. 2000): insert the removed tasks one by one where they raise a guide, a measure, least.

A norm's guide is the growth of Σ_k C_k^p: p = 1 minimises the total, a large p spares the longest tours. The guide by
excess is what exceeds the longest tour that is left, and only in case of a tie the growth of the tour: a long detour of
a UAV with time to spare is then better than the least growth of the longest tour, which no norm in use would say.
A guide drawn anew for each recreation keeps the search from going blind where only the longest tour counts.
Places looked at: behind and before each near task, and both ends of the tours of near depots; now and then one of them
is overlooked (blinks, Christiaens & Vanden Berghe 2020).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, leg, leg_into
from formulations.routing.search.energy import Measure, MeasureKind, excess, p_norm, power
from formulations.routing.search.problem_data import GranularNeighbourhood, Nodes, ProblemData
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.tours import Tours, insertion_change, link, longest
from instances.kernels import njit

GUIDES = (p_norm(1), p_norm(2), p_norm(5), p_norm(12), p_norm(30), excess(1.0))
"""Guides in their order, over lengths in those of the longest tour left; one is drawn for each recreation.

Mean gaps in % with several depots and with one (10 s, measured.md): 0.07 and 0.00 by all; 0.29 and 0.76 by the
first two; 0.50 and 1.50 by the first, the total, alone.
"""
_CONSTRUCTION_GUIDE = p_norm(2)


class RecreateParameters(NamedTuple):
    """Which insertions a recreation looks at.

    width: near tasks whose two sides are looked at. Where all UAVs start at one site annealings look at more
    (strategy.py).
    depots: nearest depots whose tours' ends are looked at; as many again are drawn among the others, so that a UAV far
    away is found too. Annealings look at fewer where all are at one site.
    blink: probability of overlooking a place, at most one for each task; the published value.
    tie: weight of a tour's growth in the guide by excess: small, it only tells ties apart.
    """

    width: int = 12
    depots: int = 4
    blink: float = 0.01
    tie: float = 1e-4


@njit(cache=True, nogil=True)
def growth(length: float, change: float, guide: Measure, tie: float) -> float:
    """Return (length + change)^p − length^p, or the growth of the excess and, to tell ties apart, tie · change.

    Of the exponents in GUIDES, constants here, compilation makes a few multiplications each instead of a loop: a step
    of an annealing takes a tenth less time.
    """
    if guide.kind == MeasureKind.EXCESS:
        return max(length + change - guide.cap, 0.0) - max(length - guide.cap, 0.0) + tie * change
    if guide.p == 1:
        return change
    then, p = length + change, guide.p
    if p == 2:
        return power(then, 2) - power(length, 2)
    if p == 5:
        return power(then, 5) - power(length, 5)
    if p == 12:
        return power(then, 12) - power(length, 12)
    if p == 30:
        return power(then, 30) - power(length, 30)
    return power(then, p) - power(length, p)


@njit(cache=True, nogil=True)
def better_side(costs: Costs, tours: Tours, v: int, u: int) -> tuple[int, float]:
    """Return (node to put task v behind, cost change [s]) for the cheaper of behind u and before u."""
    k, b = tours.tour[u], tours.before[u]
    behind = insertion_change(costs, tours, v, u)
    ahead = leg_into(costs, k, v, b) + leg(costs, k, v, u) - tours.arc[b]
    if ahead < behind:
        return b, ahead
    return u, behind


@njit(cache=True, nogil=True)
def best_insertion(
    costs: Costs,
    near: GranularNeighbourhood,
    tours: Tours,
    v: int,
    guide: Measure,
    scale: float,
    parameters: RecreateParameters,
    blink: float,
    rng: Rng,
) -> tuple[int, float]:
    """Return (node to put task v behind, change of that tour's cost [s]); the node is −1 where all was overlooked.

    1 / scale [s] is the longest tour that is left: the unit of the guide, which keeps powers in range.
    blink: instead of that of the parameters.
    """
    tasks, depots, tour, cost = (
        near.tasks,
        near.depots,
        tours.tour,
        tours.cost,
    )  # once: in a loop references are counted
    n_depots, nearest = depots.shape[1], parameters.depots
    n_tasks_seen = min(parameters.width, tasks.shape[1])
    n_seen = n_tasks_seen + min(2 * nearest, n_depots)
    overlooked = below(rng, int(n_seen / blink)) if blink > 0.0 else -1
    best, best_u, best_change = np.inf, -1, 0.0
    for j in range(n_seen):
        if j < n_tasks_seen:
            node = tasks[v, j]
        elif j < n_tasks_seen + nearest or n_depots <= 2 * nearest:
            node = depots[v, j - n_tasks_seen]
        else:
            node = depots[v, nearest + below(rng, n_depots - nearest)]
        k = tour[node]
        if k < 0 or j == overlooked:
            continue
        u, change = better_side(costs, tours, v, node)
        value = growth(cost[k] * scale, change * scale, guide, parameters.tie)
        if value < best or best_u < 0:
            best, best_u, best_change = value, u, change
    return best_u, best_change


@njit(cache=True, nogil=True)
def recreate(
    costs: Costs,
    near: GranularNeighbourhood,
    tours: Tours,
    queue: Nodes,
    count: int,
    guide: Measure,
    parameters: RecreateParameters,
    rng: Rng,
) -> None:
    """Insert queue[:count] into the tours, in that order, and book the costs."""
    unit = longest(tours.cost)
    scale = 1.0 / unit if unit > 0.0 else 1.0
    for i in range(count):
        v = queue[i]
        u, change = best_insertion(costs, near, tours, v, guide, scale, parameters, parameters.blink, rng)
        if u < 0:
            u, change = best_insertion(costs, near, tours, v, guide, scale, parameters, 0.0, rng)
        k = tours.tour[u]
        link(costs, tours, v, u)
        tours.cost[k] += change


@njit(cache=True, nogil=True)
def shuffle(queue: Nodes, count: int, rng: Rng) -> None:
    """Put queue[:count] in random order (Fisher & Yates)."""
    for i in range(count - 1, 0, -1):
        j = below(rng, i + 1)
        queue[i], queue[j] = queue[j], queue[i]


@njit(cache=True, nogil=True)
def recreate_in_turn(
    data: ProblemData,
    tours: Tours,
    queue: Nodes,
    at_once: int,
    guide: Measure,
    parameters: RecreateParameters,
    rng: Rng,
) -> None:
    """Insert the queue into the tours, by a recreation for each `at_once` of its tasks."""
    for i in range(0, queue.size, at_once):
        count = min(at_once, queue.size - i)
        recreate(data.costs, data.near, tours, queue[i : i + count], count, guide, parameters, rng)


def recreate_all(data: ProblemData, tours: Tours, queue: Nodes, parameters: RecreateParameters, rng: Rng) -> None:
    """Insert the queue into the tours by one recreation, its guide drawn from all."""
    guide = GUIDES[below(rng, len(GUIDES))]
    recreate_in_turn(data, tours, queue, max(1, queue.size), guide, parameters, rng)


def construct(data: ProblemData, tours: Tours, parameters: RecreateParameters, rng: Rng) -> None:
    """Fill empty tours with all tasks in random order, each where it least raises Σ_k C_k²."""
    queue = np.arange(data.size[0], dtype=np.int32)
    shuffle(queue, queue.size, rng)
    recreate_in_turn(data, tours, queue, 1, _CONSTRUCTION_GUIDE, parameters, rng)
