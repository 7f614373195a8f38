"""Perturbation: relocate a UAV with time to spare to where the tours are long, however far away that is.

Ruin and recreate moves a few tasks at a time between tours that touch, so which UAV serves which crowd of tasks is
settled early in an annealing. Here a UAV leaves all its tasks to the others and takes over a segment of a long tour.
A bounded relocation is one that makes no tour longer than the longest. Where tours are short that is too much to ask:
a far crowd takes most of what a UAV may fly, and one that is free for it has it only in part at first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import Costs, leg, leg_into
from formulations.routing.search.problem_data import Nodes, ProblemData
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import RecreateParameters, recreate_all, shuffle
from formulations.routing.search.tours import Tours, clear, link, longest, sum_costs, unlink
from instances.kernels import njit


class PerturbationParameters(NamedTuple):
    """draws: of a UAV and a task before giving up; only where nearly every UAV is out of reach do all of them fail.

    bounded: whether the UAV must be able to fly the segment, of random length, within the longest tour; else it takes
    over all the rest of the long tour.
    """

    draws: int = 50
    bounded: bool = True


@njit(cache=True, nogil=True)
def draw_relocation(costs: Costs, tours: Tours, limit: float, draws: int, rng: Rng) -> tuple[int, int]:
    """Return (UAV, task): the shorter of two random tours, and of two random tasks the one on the longer tour.

    The UAV can fly to the task and back in less than the limit [s]. (−1, −1) where none such is drawn.
    """
    m = tours.cost.size
    n = tours.after.size - m
    for _ in range(draws):
        h, v = below(rng, m), below(rng, n)
        g, w = below(rng, m), below(rng, n)
        if tours.cost[g] < tours.cost[h]:
            h = g
        if tours.cost[tours.tour[w]] > tours.cost[tours.tour[v]]:
            v = w
        if tours.tour[v] != h and leg(costs, h, n + h, v) + leg_into(costs, h, n + h, v) < limit:
            return h, v
    return -1, -1


@njit(cache=True, nogil=True)
def relocate(costs: Costs, tours: Tours, h: int, v: int, limit: float) -> None:
    """Move task v, and those flown after it while tour h stays within `limit` [s], to the empty tour h."""
    n = tours.after.size - tours.cost.size
    u, so_far = n + h, 0.0
    while v < n:
        so_far += leg_into(costs, h, v, u)
        if u < n and so_far + leg(costs, h, v, n + h) > limit:
            break
        after = tours.after[v]
        unlink(costs, tours, v)
        link(costs, tours, v, u)
        u, v = v, after


def perturb(
    data: ProblemData, tours: Tours, parameters: PerturbationParameters, recreation: RecreateParameters, rng: Rng
) -> None:
    """Let one UAV leave its tasks to the others and take over a segment of a long tour."""
    count, removed = relocate_one(data.costs, tours, parameters, rng)
    if count >= 0:
        recreate_all(data, tours, removed[:count], recreation, rng)


@njit(cache=True, nogil=True)
def relocate_one(costs: Costs, tours: Tours, parameters: PerturbationParameters, rng: Rng) -> tuple[int, Nodes]:
    """Relocate a UAV; return how many tasks it left, −1 where none is drawn, and these in random order."""
    limit = longest(tours.cost) if parameters.bounded else np.inf
    h, v = draw_relocation(costs, tours, limit, parameters.draws, rng)
    n = tours.after.size - tours.cost.size
    removed = np.empty(n, np.int32)
    if h < 0:
        return -1, removed
    if parameters.bounded:
        there_and_back = leg(costs, h, n + h, v) + leg_into(costs, h, n + h, v)
        limit = there_and_back + uniform(rng) * (limit - there_and_back)
    count = clear(costs, tours, h, removed)
    relocate(costs, tours, h, v, limit)
    sum_costs(tours)
    shuffle(removed, count, rng)
    return count, removed
