"""Lineage: what populations share, with and without a clock: members, their selection, and when stages begin and end.

A newcomer that is no copy of a member replaces the worst member where it is better. What brings forth nothing new for a
while keeps its best member and restarts with fresh founders, annealed twice as long.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.search.energy import Measure, MeasureKind, excess, fitness
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import ProblemData
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.tours import Tours, broken_pairs, duplicate


class Lineage:
    """Members, the best tours so far, and the stage under way.

    Times are fractions of the limit; `founder` is the length of a founder's stage, `founders` how many there are.
    """

    best: Tours

    def __init__(self, data: ProblemData, parameters: SearchParameters, rng: Rng, founders: int) -> None:
        self.data, self.parameters, self.rng = data, parameters, rng
        self.strategy = parameters.strategy(data)
        recreate = parameters.annealing.recreate._replace(width=self.strategy.width)
        self.annealing = parameters.annealing._replace(recreate=recreate)
        self.members: list[Tours] = []
        self.founder, self.founders, self.stages = 1.0, founders, 0
        self._since_restart, self._barren = 0, 0
        self._step_length = 0.0
        self._begin, self.end = 0.0, 1.0

    def plan(self, step: float) -> None:
        """Say which part of the limit a step takes; founders are then annealed as deep as they should.

        That begins with the newcomer under way, unless the limit allows fewer than three founders.
        """
        self._step_length = step
        parameters = self.parameters.population
        least = max(parameters.least, min(parameters.enough, parameters.per_task * self.data.size[0]))
        founder = step * max(least, parameters.depth * self.data.crowding)
        if founder <= 1.0 / 3.0:
            self.founder = founder
            self.founders = min(parameters.size, max(2, int(0.5 / founder)))
            self.end = self._begin + founder

    @property
    def incumbent(self) -> float:
        """The longest of the best tours, scaled for endurance [s]."""
        return float(self.best.cost.max())

    @property
    def measure(self) -> Measure:
        """The measure of fitness at present."""
        measure = self.strategy.measure
        return measure if measure.kind == MeasureKind.P_NORM else excess(self.incumbent)

    def _done(self, now: float) -> float:
        """Return the share of the stage that is over, 0..1."""
        return min(1.0, (now - self._begin) / max(self.end - self._begin, 1e-12))

    def _fitting(self, length: float, now: float) -> float:
        """Return the end of a stage begun now, its length stretched so that a whole number of them fill the limit."""
        left = max(1.0 - now, 0.0)
        return now + left / max(1, round(left / length))

    def _take_in(self, newcomer: Tours, migrant: Tours | None = None) -> None:
        """End a stage: take its newcomer in, and a migrant; restart where nothing new came for long."""
        self.stages += 1
        self._since_restart += 1
        self._barren = 0 if self._select(newcomer) else self._barren + 1
        if migrant is not None:
            self._select(migrant)
        if self._since_restart >= self.founders and self._barren > self.strategy.patience * self.founders:
            self.members = [duplicate(self.best)]
            self._since_restart, self._barren = 1, 0
            self.founder = min(2.0 * self.founder, 1.0 / 3.0)

    @property
    def _founding(self) -> bool:
        """Whether the next newcomer is a founder."""
        return self._since_restart < self.founders or len(self.members) < 2

    @property
    def _staleness(self) -> float:
        """How long nothing was new, for the strategy."""
        return self._barren / (self.strategy.settling * self.founders)

    def _select(self, newcomer: Tours) -> bool:
        """Add a copy of `newcomer` where it is better than a member; return whether it is new and in.

        An equal of members takes the place of that most like it, unless there is room for an equal that is no copy;
        new it is not: the best of equals may change without end.
        """
        measure, same = self.measure, self.parameters.population.same * self.incumbent
        value = fitness(newcomer.cost, measure)
        values = [fitness(member.cost, measure) for member in self.members]
        equals = [i for i, other in enumerate(values) if abs(value - other) <= same]
        full = len(values) >= max(2, self.founders)
        worst = int(np.argmax(values)) if values else -1
        if equals:
            change, nearest = min((broken_pairs(newcomer, self.members[i], self.data.site), i) for i in equals)
            copy = change <= self.parameters.population.apart * self.data.size[0]
            if copy or (full and value + same >= values[worst]):
                if value <= values[nearest]:
                    self.members[nearest] = duplicate(newcomer)
                return False
        elif full and value >= values[worst]:
            return False
        if full:
            del self.members[worst]
        self.members.append(duplicate(newcomer))
        return not equals

    def _parents(self) -> tuple[Tours, Tours]:
        """Return a copy of a random member, to become a child, and another member."""
        i = below(self.rng, len(self.members))
        j = (i + 1 + below(self.rng, len(self.members) - 1)) % len(self.members)
        return duplicate(self.members[i]), self.members[j]
