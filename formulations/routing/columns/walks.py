"""Walks: where a relaxation begins. Tours that may return to tasks they no longer remember are found without labels.

The completion bounds (`completion.py`) are themselves the least reduced costs of such walks, the ng-routes of Baldacci,
Mingozzi, Roberti (Oper. Res. 59, 2011). Following them from each first task on gives one walk each, and the relaxation
over walks is solved while the search for tours, where these are long, has not found its way from the first duals.
Its bound holds for tours as well, and its duals are near theirs. A walk with every task but at its first visit left out
is a tour to begin with, where it is allowed.

A walk of the relaxation that returns to a task says what should have been remembered (`recall.py`). So the relaxation
is solved again and again, each time with memories that hold what walks so far returned to most often. All pricing that
follows remembers the same: completion bounds are then so near to tours that labels find them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from formulations.routing.columns.completion import Memory
from formulations.routing.columns.generation import Ended, generate
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import WIDE, Master
from formulations.routing.columns.pricing import Column, DualBound, Duals, Priced, Pricer
from formulations.routing.columns.recall import walks_from_each
from instances.arrays import Floats, Ints

_NARROW = 0.2  # fair shares of the cap: half width of the box of duals after the first relaxation
_GAIN, _DULL = 1e-3, 6  # share of the cap that a memory is to gain, and how many in turn may gain less
_USED = 1e-6  # weight of a walk


class Walked(NamedTuple):
    """What relaxations over walks came to: the best bound, tours to begin with, rounds."""

    best: DualBound
    tours: list[Column]
    rounds: int


def relax_by_walks(pricer: Pricer, kinds: Ints, tours: Sequence[Column]) -> Walked:
    """Solve the relaxation over walks of cost ≤ the pricer's cap, without cuts, with ever better memories."""
    cap = pricer.cap
    found = dict.fromkeys(tours)
    walks, best, rounds, dull = list(tours), None, 0, 0
    while True:
        master = _master(pricer, kinds, walks, best)
        start = None if best is None else best.duals
        relaxation = generate(master, [WalkPricer(pricer)], cap, pricer.time_left, start=start, steady=True)
        rounds += relaxation.rounds
        found |= dict.fromkeys(_tour(pricer.legs, walk) for walk in master.columns)
        gain = np.inf if best is None else relaxation.best.value - best.value
        best = relaxation.best if best is None or gain > 0 else best
        dull = 0 if gain > _GAIN * cap else dull + 1
        if relaxation.ended is not Ended.SOLVED or dull > _DULL:
            break
        used = np.flatnonzero(relaxation.weight > _USED)
        if not pricer.recall.learn([master.columns[p].tasks for p in used], relaxation.weight[used]):
            break
        walks = [walk for walk in master.columns if _remembered(walk.tasks, pricer.memory)]
    return Walked(best, [tour for tour in found if tour.cost <= pricer.caps[tour.uav]], rounds)


def _master(pricer: Pricer, kinds: Ints, walks: Sequence[Column], best: DualBound | None) -> Master:
    """Return the master of some walks, its duals in a wide box at first, then in a narrow one around the best."""
    n, cap = pricer.legs.n_tasks, pricer.cap
    half, middle = (WIDE, 0.0) if best is None else (_NARROW, best.duals.price)
    master = Master(n, kinds, half * cap / n, centre=middle)
    master.add([walk for walk in walks if walk.cost <= cap])
    return master


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
        if self.tours.time_left() <= 0:
            return Priced.unknown()
        walks, values, costs = walks_from_each(self.tours.subproblem(k, duals))
        below = np.flatnonzero((values < threshold) & (costs < np.inf))
        chosen = below[np.argsort(values[below], kind="stable")]
        columns = [Column(k, tuple(walks[f][walks[f] >= 0].tolist()), float(costs[f])) for f in chosen]
        return Priced(float(values.min()), columns, True)

    def price_all(self, uavs: Sequence[int], duals: Duals, thresholds: Floats) -> dict[int, Priced]:
        """Return what `price` would of each of some UAVs, at their thresholds (m,)."""
        self.tours.watch(duals)  # once for all threads
        priced = self.tours.each(lambda k: self.price(k, duals, float(thresholds[k])), uavs)
        return dict(zip(uavs, priced, strict=True))
