"""Walks: where a relaxation begins. Tours that may return to tasks they no longer remember are found without labels.

The completion bounds (`completion.py`) are themselves the least reduced costs of such walks, the ng-routes of Baldacci,
Mingozzi, Roberti (Oper. Res. 59, 2011). Following them from each first task on gives one walk each, and the relaxation
over walks is solved while the search for tours, where these are long, has not found its way from the first duals.
Its bound holds for tours as well, and its duals are near theirs. A walk with every task but at its first visit left out
is a tour to begin with, where it is allowed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from formulations.routing.columns.completion import bins_left
from formulations.routing.columns.generation import Relaxation, generate
from formulations.routing.columns.label_search import Subproblem
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import WIDE, Master
from formulations.routing.columns.pricing import Column, Duals, Priced, Pricer
from instances.arrays import Floats, Ints
from instances.kernels import njit

_LONGEST = 2  # times the number of tasks: visits of the longest walk


def relax_by_walks(pricer: Pricer, kinds: Ints, tours: Sequence[Column]) -> tuple[Relaxation, list[Column]]:
    """Solve the relaxation over walks of cost ≤ the pricer's cap, without cuts; return it, and `tours` and more."""
    n, cap = pricer.legs.n_tasks, pricer.cap
    master = Master(n, kinds, WIDE * cap / n)
    master.add([tour for tour in tours if tour.cost <= cap])
    relaxation = generate(master, [WalkPricer(pricer)], cap, pricer.out_of_time)
    more = [_tour(pricer.legs, walk) for walk in master.columns]
    return relaxation, [*tours, *(tour for tour in more if tour.cost <= pricer.caps[tour.uav])]


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
        walks, values, costs = _walks(self.tours.subproblem(k, duals), _LONGEST * duals.price.size)
        below = np.flatnonzero((values < threshold) & (costs < np.inf))
        chosen = below[np.argsort(values[below], kind="stable")]
        columns = [Column(k, tuple(walks[f][walks[f] >= 0].tolist()), float(costs[f])) for f in chosen]
        return Priced(float(values.min()), columns, True)


@njit(cache=True)
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
