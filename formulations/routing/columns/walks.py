"""Walks: where a relaxation begins. Tours that may return to tasks they no longer remember are found without labels.

The completion bounds (`completion.py`) are themselves the least reduced costs of such walks, the ng-routes of Baldacci,
Mingozzi, Roberti (Oper. Res. 59, 2011). Following them from each first task on gives one walk each, and the relaxation
over walks is solved while the search for tours, where these are long, has not found its way from the first duals.
Its bound holds for tours as well, and its duals are near theirs. A walk with every task but at its first visit left out
is a tour to begin with, where it is allowed.

A walk of the relaxation that returns to a task says what should have been remembered: the task, at those between. So
the relaxation is solved again and again, each time with memories that hold what walks so far returned to most often
(dynamic ng-routes: Roberti & Mingozzi, "Dynamic ng-path relaxation for the delivery man problem", Transp. Sci. 48,
2014). All pricing that follows remembers the same: completion bounds are then so near to tours that labels find them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from formulations.routing.columns.completion import Memory, bins_left
from formulations.routing.columns.generation import Ended, generate
from formulations.routing.columns.label_search import Subproblem
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import WIDE, Master
from formulations.routing.columns.pricing import Column, DualBound, Duals, Priced, Pricer
from instances.arrays import Floats, Ints
from instances.kernels import njit

_LONGEST = 2  # times the number of tasks: visits of the longest walk
_NARROW = 0.2  # fair shares of the cap: half width of the box of duals after the first relaxation
_GAIN, _DULL = 1e-3, 6  # share of the cap that a memory is to gain, and how many in turn may gain less
_USED = 1e-6  # weight of a walk


class Walked(NamedTuple):
    """What relaxations over walks came to: the best bound, tours to begin with, `returns` (n, n), rounds.

    returns : how often walks came back to a task (second) by way of another (first), as in `Memory.nearest`.
    """

    best: DualBound
    tours: list[Column]
    returns: Floats
    rounds: int


def relax_by_walks(pricer: Pricer, kinds: Ints, tours: Sequence[Column]) -> Walked:
    """Solve the relaxation over walks of cost ≤ the pricer's cap, without cuts, with ever better memories."""
    n, cap = pricer.legs.n_tasks, pricer.cap
    returns = np.zeros((n, n)) if pricer.returns is None else pricer.returns
    found = dict.fromkeys(tours)
    walks, best, rounds, dull = list(tours), None, 0, 0
    while True:
        master = _master(pricer, kinds, walks, best)
        start = None if best is None else best.duals
        relaxation = generate(master, [WalkPricer(pricer)], cap, pricer.out_of_time, start=start)
        rounds += relaxation.rounds
        found |= dict.fromkeys(_tour(pricer.legs, walk) for walk in master.columns)
        gain = np.inf if best is None else relaxation.best.value - best.value
        best = relaxation.best if best is None or gain > 0 else best
        dull = 0 if gain > _GAIN * cap else dull + 1
        more = _returns([walk.tasks for walk in master.columns], relaxation.weight, n)
        if relaxation.ended is not Ended.SOLVED or dull > _DULL or not more.any():
            break
        returns = returns + more
        pricer = pricer.at(pricer.effort, pricer.legs, returns)
        walks = [walk for walk in master.columns if _remembered(walk.tasks, pricer.memory)]
    return Walked(best, [tour for tour in found if tour.cost <= pricer.caps[tour.uav]], returns, rounds)


def _master(pricer: Pricer, kinds: Ints, walks: Sequence[Column], best: DualBound | None) -> Master:
    """Return the master of some walks, its duals in a wide box at first, then in a narrow one around the best."""
    n, cap = pricer.legs.n_tasks, pricer.cap
    half, middle = (WIDE, 0.0) if best is None else (_NARROW, best.duals.price)
    master = Master(n, kinds, half * cap / n, centre=middle)
    master.add([walk for walk in walks if walk.cost <= cap])
    return master


def _returns(walks: Sequence[Sequence[int]], weight: Floats, n_tasks: int) -> Floats:
    """Return how often walks of these weights come back to a task (second) by way of another (first), (n, n).

    A return counts for one in all tasks between together: the fewer there are, the less has to be remembered.
    """
    returns = np.zeros((n_tasks, n_tasks))
    for p in np.flatnonzero(weight > _USED).tolist():
        last: dict[int, int] = {}
        for visit, task in enumerate(walks[p]):
            if task in last:
                between = [other for other in walks[p][last[task] + 1 : visit] if other != task]
                returns[between, task] += weight[p] / len(between)
            last[task] = visit
    return returns


def _remembered(walk: Sequence[int], memory: Memory) -> bool:
    """Say whether a walk keeps to a memory: returns to no task it remembers."""
    step, held = memory.step, 0
    for here, there in pairwise(walk):
        held = int(step[here, there, held])
        if held == step.shape[2]:
            return False
    return True


def _tour(legs: Legs, walk: Column) -> Column:
    """Return the walk with every task at its first visit only, at an infinite cost where it is not allowed."""
    out, between, home = legs.of_uav(walk.uav)
    tasks = tuple(dict.fromkeys(walk.tasks))
    cost = out[tasks[0]] + sum(between[i, j] for i, j in pairwise(tasks)) + home[tasks[-1]]
    return Column(walk.uav, tasks, float(cost))


class WalkPricer:
    """Prices walks instead of tours: always completely."""

    def __init__(self, tours: Pricer) -> None:
        self.tours, self.n_uavs = tours, tours.n_uavs

    def price(self, k: int, duals: Duals, threshold: float) -> Priced:
        """Return UAV k's best walks of reduced cost below `threshold` ≤ 0, one for each first task, and the least."""
        if self.tours.out_of_time():
            return Priced.unknown()
        walks, values, costs = _walks(self.tours.subproblem(k, duals), _LONGEST * duals.price.size)
        below = np.flatnonzero((values < threshold) & (costs < np.inf))
        chosen = below[np.argsort(values[below], kind="stable")]
        columns = [Column(k, tuple(walks[f][walks[f] >= 0].tolist()), float(costs[f])) for f in chosen]
        return Priced(float(values.min()), columns, True)

    def price_all(self, uavs: Sequence[int], duals: Duals, thresholds: Floats) -> dict[int, Priced]:
        """Return what `price` would of each of some UAVs, at their thresholds (m,)."""
        self.tours.watch(duals)  # once for all threads
        priced = self.tours.each(lambda k: self.price(k, duals, float(thresholds[k])), uavs)
        return dict(zip(uavs, priced, strict=True))


@njit(cache=True, nogil=True)
def _walks(problem: Subproblem, most: int) -> tuple[Ints, Floats, Floats]:
    """Return the best walk from every first task, −1 behind its end, their reduced costs and costs [s].

    A walk of more than `most` visits is not followed to its end, and its cost said to be infinite.
    """
    bins, step, best, price, sigma = problem.bins, problem.memory.step, problem.best, problem.price, problem.sigma
    legs, cost, out, n = bins.legs[0], bins.cost[0], problem.legs.out, problem.price.size
    walks, values, costs = np.full((n, most), -1), np.full(n, np.inf), np.zeros(n)
    for first in range(n):
        if not out[first] <= problem.cap:
            continue
        left, memory, here = bins_left(problem.cap - out[first], bins), 0, first
        values[first] = sigma * out[first] - price[first] + best[first, left, 0]
        if not values[first] < np.inf:
            continue
        costs[first] = out[first]
        for visit in range(most):
            walks[first, visit] = here
            least, then = (sigma * cost[here, n] if legs[here, n] <= left else np.inf), n
            for j in range(n):
                if legs[here, j] <= left:
                    value = sigma * cost[here, j] - price[j] + best[j, left - legs[here, j], step[here, j, memory]]
                    if value < least:
                        least, then = value, j
            costs[first] += cost[here, then]
            if then == n:
                break
            left, memory, here = left - legs[here, then], step[here, then, memory], then
        else:
            costs[first] = np.inf
    return walks, values, costs
