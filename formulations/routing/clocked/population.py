"""Population by the clock: good solutions, renewed by annealed founders, children and reheated members.

A small sister of `search.population`, whose parameters and strategies it takes. The first stage anneals the plan for
the costs of half time, each tour flown in its better direction, gently; the next ones anneal founders from scratch.
Later a stage anneals the child of two members (whole tours inherited, what is left inserted by the clock) or reheats
one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from formulations.routing.clocked.annealing import anneal_by_clock
from formulations.routing.clocked.problem import ClockedProblem
from formulations.routing.clocked.recreate import recreate
from formulations.routing.search.crossover import inherit_some, some_tours
from formulations.routing.search.energy import p_norm
from formulations.routing.search.lineage import Family, Lineage
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import shuffle
from formulations.routing.search.tours import Tours, duplicate

_CONSTRUCTION_GUIDE = p_norm(2)


class ClockedPopulation(Lineage):
    """Members, the newcomer under way and the best tours; times are fractions of the limit."""

    def __init__(
        self, problem: ClockedProblem, parameters: SearchParameters, rng: Rng, start: Tours, now: float
    ) -> None:
        parameters = replace(parameters, several_depots=replace(parameters.several_depots, short=None))  # not tried
        super().__init__(problem.data, parameters, rng, Family(founders=2))
        self.problem, self.best = problem, duplicate(start)
        self._start(now, start, parameters.schedule.child, 1.0)

    def advance(self, now: float, steps: int) -> None:
        """Anneal the newcomer by `steps` steps at the temperature that belongs to `now`."""
        schedule = self.parameters.schedule
        temperature, objective = self._schedule.at(self._done(now), self._fittest, self.incumbent, schedule)
        how = self.annealing
        anneal_by_clock(
            self._search, self.best, self._fittest, self.rng, steps, temperature, objective, self.measure, how
        )
        self.problem.follow(self.best, *self.family.members, self._fittest)

    def next_stage(self, now: float) -> None:
        """Take the newcomer in and begin the next stage."""
        self._take_in(self._fittest)
        schedule = self.parameters.schedule
        if self._founding():
            self._start(now, self._constructed(), schedule.founder, self.family.founder)
        elif uniform(self.rng) < 0.5:
            self._start(now, self._child(), schedule.child, self.parameters.population.child * self.family.founder)
        else:
            member = duplicate(self.family.members[below(self.rng, len(self.family.members))])
            self._start(now, member, schedule.perturbed, self.parameters.population.child * self.family.founder)

    def _start(self, now: float, tours: Tours, first: float, length: float) -> None:
        """Begin to anneal `tours` from a `first` temperature on, in mean legs."""
        self._schedule = self.strategy.draw_schedule(first, self._staleness, self.parameters.schedule, self.rng)
        self._search, self._fittest = self.problem.search(tours, self.annealing.removals), duplicate(tours)
        self._begin, self.end = now, self._fitting(length, now)

    def _constructed(self) -> Tours:
        """Return tours from nothing: tasks in random order, each where it least raises Σ_k C_k²."""
        n = self.data.size[0]
        queue, tours = np.arange(n, dtype=np.int32), self.problem.tours()
        shuffle(queue, n, self.rng)
        for i in range(n):
            self._insert(tours, queue[i : i + 1])
        return tours

    def _child(self) -> Tours:
        """Return the child of two random members."""
        child, other = self._parents()
        given = some_tours(self.data.size[1], self.rng)
        left = inherit_some(self.data.costs, self.data.site, child, other, given, self.rng)
        self._insert(child, left)
        return child

    def _insert(self, tours: Tours, queue: Nodes) -> None:
        """Insert the queue into tours that may not be booked yet."""
        search, touched = self.problem.search(tours, 1), np.zeros(self.data.size[1], dtype=bool)
        recreate(
            search.clocks,
            search.eras,
            search.data.costs,
            search.data.near,
            tours,
            search.bookings,
            queue,
            len(queue),
            _CONSTRUCTION_GUIDE,
            self.parameters.annealing.recreate,
            self.rng,
            touched,
        )
