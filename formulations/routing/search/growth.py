"""Growth: tours that begin with the farthest tasks, and are annealed each time that nearer ones have joined.

Where the farthest task decides, few tours can fly far and most could take near tasks on their way. An annealing of all
tasks spends itself on the near ones, and leaves the far ones on too few tours or on the wrong ones: no later search
finds a way out, for it takes several tours anew at once. Here the far ones alone are packed first, under a cap as in
packing.py. All nearer tasks then find the tours that pass them, and those that have not taken off.

    E = w Σ C_k + Σ max(0, C_k − cap)

The cap is what no tour can be shorter than, the trip to the farthest task and back, or the mean tour where that is
longer. Which tasks are there to begin with is what a multilevel search decides (Walshaw, Annals of OR 131, 2004).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from formulations.routing.search.annealing import AnnealingParameters, anneal
from formulations.routing.search.costs import AlikeCosts
from formulations.routing.search.energy import excess
from formulations.routing.search.packing import CappedSchedule
from formulations.routing.search.problem_data import NeighbourhoodParameters, ProblemData, data_between
from formulations.routing.search.randomness import Rng
from formulations.routing.search.recreate import recreate_in_turn, shuffle
from formulations.routing.search.schedule import ScheduleParameters
from formulations.routing.search.tours import Tours, duplicate, empty_tours, fill, sum_costs, to_routes


class GrowthParameters(NamedTuple):
    """Which tasks join when, and how tours are annealed.

    u2152_20, by script, 5 s of growth and 8 s of what follows, eight seeds: with w = 0.01 0.23 %, 0.02 0.34, 0.03 0.44.

    levels: tasks whose trips are longer than such a share of the longest trip have joined, in the end all; each
    takes as long.
    weight: w; first, later, last: temperatures of the first level, of the others and of the end of each, as shares of
    w mean legs.
    """

    levels: tuple[float, ...] = (0.85, 0.7, 0.5, 0.3)
    weight: float = 0.01
    first: float = 0.25
    later: float = 0.15
    last: float = 0.05


class Growth:
    """Tours under way, of the tasks that have joined; their `longest` [s] is infinite until all have."""

    def __init__(
        self,
        whole: ProblemData,
        parameters: GrowthParameters,
        annealing: AnnealingParameters,
        neighbourhood: NeighbourhoodParameters,
        rng: Rng,
    ) -> None:
        self._whole, self._parameters, self._annealing, self._rng = whole, parameters, annealing, rng
        self._neighbourhood = neighbourhood
        costs, (n, m) = whole.costs, whole.size
        assert isinstance(costs, AlikeCosts)
        trips = costs.out[n, :n] + costs.out[:n, n]
        self._farthest, self._order = float(trips.max()), np.argsort(-trips, kind="stable").astype(np.int32)
        self._counts = [max(1, int((trips > share * self._farthest).sum())) for share in parameters.levels]
        self._counts.append(n)
        self._level, self._nodes = -1, np.empty(0, np.int32)
        self._tours = self._best = empty_tours(0, m)
        self.longest = float("inf")
        self._next_level()

    def advance(self, done: float, steps: int) -> bool:
        """Anneal by `steps` steps at `done` in 0..1; return whether all have joined and the longest became shorter."""
        how, levels = self._parameters, len(self._counts)
        while self._level < min(int(done * levels), levels - 1):
            self._next_level()
        schedule = CappedSchedule(how.later if self._level else how.first, how.last, how.weight, margin=0.0)
        cap = max(self._farthest, float(self._tours.cost.mean()))
        temperature, objective = schedule.at(done * levels - self._level, self._tours, cap, ScheduleParameters())
        tours, best, before = self._tours, self._best, self.longest
        measure = excess(float(best.cost.max()))
        anneal(
            self._data, tours, best, self._fittest, self._rng, steps, temperature, objective, measure, self._annealing
        )
        if self._level == levels - 1:
            self.longest = float(best.cost.max())
        return self.longest < before

    def best(self) -> Tours:
        """Return the tours whose longest was shortest since all tasks have joined."""
        return duplicate(self._best)

    def grown(self) -> Tours:
        """Return the tours as they are, all tasks on them."""
        while self._level < len(self._counts) - 1:
            self._next_level()
        return duplicate(self._tours)

    def _next_level(self) -> None:
        """Let the tasks of the next level join, each where it costs least, those farther away before others."""
        whole, rng, (n, m) = self._whole, self._rng, self._whole.size
        joined, tours = self._nodes[:-m], self._tours
        self._level += 1
        count = self._counts[self._level]
        self._data = whole  # before costs are copied: those of the last level are let go
        if count == n:
            self._nodes = np.arange(n + m, dtype=np.int32)
        else:
            self._nodes = np.concatenate([self._order[:count], np.arange(n, n + m, dtype=np.int32)])
            self._data = data_between(whole, self._nodes, np.arange(m), self._neighbourhood)
        number = np.empty(n, np.int32)
        number[self._nodes[:count]] = np.arange(count)
        self._tours = empty_tours(count, m)
        for k, route in enumerate(to_routes(tours)):
            fill(self._data.costs, self._tours, k, number[joined[list(route)]])
        sum_costs(self._tours)
        queue = number[self._order[joined.size : count]]
        if joined.size == 0:
            shuffle(queue, queue.size, rng)
        cap = excess(self._farthest)
        recreate_in_turn(self._data, self._tours, queue, 1, cap, self._annealing.recreate, rng)
        sum_costs(self._tours)
        self._best, self._fittest = duplicate(self._tours), duplicate(self._tours)
