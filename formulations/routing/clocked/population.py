"""Population by the clock: good solutions, renewed by annealed founders, children and reheated members.

A small sister of `search.population`, whose parameters and strategies it takes. The first stage anneals the plan for
the costs of half time, each tour flown in its better direction, gently; the next ones anneal founders from scratch.
Later a stage anneals the child of two members (whole tours inherited, what is left inserted by the clock) or reheats
one. What brings forth nothing new for a while restarts with fresh founders, annealed twice as long.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.clocked.annealing import anneal_by_clock
from formulations.routing.clocked.problem import ClockedProblem
from formulations.routing.clocked.recreate import recreate
from formulations.routing.search.crossover import inherit_some
from formulations.routing.search.energy import Measure, MeasureKind, excess, fitness, p_norm
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.recreate import shuffle
from formulations.routing.search.tours import Tours, duplicate

_CONSTRUCTION_GUIDE = p_norm(2)


class ClockedPopulation:
    """Members, the newcomer under way and the best tours; times are fractions of the limit."""

    def __init__(
        self, problem: ClockedProblem, parameters: SearchParameters, rng: Rng, start: Tours, now: float
    ) -> None:
        self.problem, self.parameters, self.rng = problem, parameters, rng
        self.strategy = parameters.strategy(problem.data)
        recreate = parameters.annealing.recreate._replace(width=self.strategy.width)
        self.annealing = parameters.annealing._replace(recreate=recreate)
        self.best, self.members, self.stages = duplicate(start), list[Tours](), 0
        self.length, self.founders = 1.0, 2
        self._since_restart, self._barren = 0, 0
        self._begin(now, start, parameters.schedule.child, 1.0)

    def plan(self, step: float) -> None:
        """Say which part of the limit a step takes; a founder's stage is then as deep as it should be."""
        sizes = self.parameters.population
        least = max(sizes.least, min(sizes.enough, sizes.per_task * self.problem.data.size[0]))
        length = step * max(least, sizes.depth * self.problem.data.crowding)
        if length <= 1.0 / 3.0:
            self.length, self.founders = length, min(sizes.size, max(2, int(0.5 / length)))
            self.end = self._from + length

    @property
    def incumbent(self) -> float:
        """The longest of the best tours, scaled for endurance [s]."""
        return float(self.best.cost.max())

    @property
    def measure(self) -> Measure:
        """The measure of fitness at present."""
        measure = self.strategy.measure
        return measure if measure.kind == MeasureKind.P_NORM else excess(self.incumbent)

    def advance(self, now: float, steps: int) -> None:
        """Anneal the newcomer by `steps` steps at the temperature that belongs to `now`."""
        done = min(1.0, (now - self._from) / max(self.end - self._from, 1e-12))
        schedule = self.parameters.schedule
        temperature, objective = self._schedule.at(done, self._fittest, self.incumbent, schedule)
        how = self.annealing
        anneal_by_clock(
            self._search, self.best, self._fittest, self.rng, steps, temperature, objective, self.measure, how
        )
        self.problem.follow(self.best, *self.members, self._fittest)

    def next_stage(self, now: float) -> None:
        """Take the newcomer in and begin the next stage."""
        self.stages += 1
        self._since_restart += 1
        self._barren = 0 if self._select(self._fittest) else self._barren + 1
        if self._since_restart >= self.founders and self._barren > self.strategy.patience * self.founders:
            self.members, self._since_restart, self._barren = [duplicate(self.best)], 1, 0
            self.length = min(2.0 * self.length, 1.0 / 3.0)
        schedule = self.parameters.schedule
        if self._since_restart < self.founders or len(self.members) < 2:
            self._begin(now, self._constructed(), schedule.founder, self.length)
        elif uniform(self.rng) < 0.5:
            share = self.parameters.population.child
            self._begin(now, self._child(), schedule.child, share * self.length)
        else:
            member = duplicate(self.members[below(self.rng, len(self.members))])
            self._begin(now, member, schedule.perturbed, self.parameters.population.child * self.length)

    def _begin(self, now: float, tours: Tours, first: float, length: float) -> None:
        staleness = self._barren / (self.strategy.settling * self.founders)
        self._schedule = self.strategy.draw_schedule(first, staleness, self.parameters.schedule, self.rng)
        self._search, self._fittest = self.problem.search(tours, self.annealing.removals), duplicate(tours)
        left = max(1.0 - now, 0.0)
        self._from, self.end = now, now + left / max(1, round(left / length))

    def _select(self, newcomer: Tours) -> bool:
        """Add a copy of `newcomer` unless a member equals it; keep the best members; return whether it is in."""
        measure, same = self.measure, self.parameters.population.same * self.incumbent
        value = fitness(newcomer.cost, measure)
        values = [fitness(member.cost, measure) for member in self.members]
        if any(abs(value - other) <= same for other in values):
            return False
        if len(values) >= max(2, self.founders):
            worst = int(np.argmax(values))
            if value >= values[worst]:
                return False
            del self.members[worst]
        self.members.append(duplicate(newcomer))
        return True

    def _constructed(self) -> Tours:
        """Return tours from nothing: tasks in random order, each where it least raises Σ_k C_k²."""
        n = self.problem.data.size[0]
        queue, tours = np.arange(n, dtype=np.int32), self.problem.tours()
        shuffle(queue, n, self.rng)
        for i in range(n):
            self._insert(tours, queue[i : i + 1])
        return tours

    def _child(self) -> Tours:
        """Return the child of two random members."""
        i = below(self.rng, len(self.members))
        j = (i + 1 + below(self.rng, len(self.members) - 1)) % len(self.members)
        child, data = duplicate(self.members[i]), self.problem.data
        left = inherit_some(data.costs, data.site, child, self.members[j], self.rng)
        self._insert(child, left)
        return child

    def _insert(self, tours: Tours, queue: Nodes) -> None:
        """Insert the queue into tours that may not be booked yet."""
        search, touched = self.problem.search(tours, 1), np.zeros(self.problem.data.size[1], dtype=bool)
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
