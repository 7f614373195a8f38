"""Lineage: what populations share, with and without a clock: members, their selection, and when stages begin and end.

A newcomer near members competes with them, any other with the worst: members stay apart, as a population of nearly the
same solutions has nothing left to cross (crowding, De Jong 1975). What brings forth nothing new for a while keeps its
best member and restarts with fresh founders, annealed twice as long. How often newcomers of an origin were new says how
often more of it follow (probability matching; Fialho et al., Ann. Math. Artif. Intell. 60, 2010, compare such rules).
Lineages in several threads are of one family: each has a stage of its own under way, the members are those of all.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from formulations.routing.search.energy import Measure, MeasureKind, excess, fitness
from formulations.routing.search.eras import Eras
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import ProblemData
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.tours import Tours, broken_pairs, duplicate

_SELDOM = 0.01
"""Added to rates of success, so that what never succeeds is still tried."""


@dataclass
class Successes:
    """How often newcomers of one origin were new, of late: a mean in which the older ones weigh less and less."""

    rate: float = 0.5

    def note(self, new: bool, weight: float) -> None:
        """Learn what became of one, which counts for `weight` (0 to 1)."""
        self.rate += weight * (new - self.rate)

    def share(self, others: Successes, even: float) -> float:
        """Return the share of stages that this origin gets beside another; `even` where both succeed as often."""
        mine, theirs = even * (self.rate + _SELDOM), (1.0 - even) * (others.rate + _SELDOM)
        return mine / (mine + theirs)


@dataclass
class Family:
    """What the lineages of all threads have in common.

    members: the solutions kept; founder: the length of a founder's stage, as a fraction of the limit; founders: how
    many there are; stages: newcomers taken in, of them since_restart since the last restart and barren since the last
    that was new; in_long: what all long founders (strategy.py) took, as a fraction of the limit; children, perturbed:
    how often such newcomers were new; packed: how often capped founders were (packing.py); eras: see eras.py.
    """

    threads: int = 1
    members: list[Tours] = field(default_factory=list)
    founder: float = 1.0
    founders: int = 1
    stages: int = 0
    since_restart: int = 0
    barren: int = 0
    in_long: float = 0.0
    children: Successes = field(default_factory=Successes)
    perturbed: Successes = field(default_factory=Successes)
    packed: Successes = field(default_factory=Successes)
    eras: Eras = field(default_factory=Eras)

    @property
    def longest(self) -> float:
        """The longest stage of a founder, as a fraction of the limit: three fit into what all threads have."""
        return min(self.threads, 2) / 3.0

    def begin_anew(self) -> None:
        """Forget all members, and whether capped founders were new."""
        self.members, self.since_restart, self.barren, self.packed = [], 0, 0, Successes()


class Lineage:
    """The best tours so far, and the stage under way in one thread; times are fractions of the limit."""

    best: Tours

    def __init__(self, data: ProblemData, parameters: SearchParameters, rng: Rng, family: Family) -> None:
        self.strategy = parameters.strategy(data)
        self.data, self.parameters, self.rng = data, parameters.by(self.strategy), rng
        annealing, strategy = self.parameters.annealing, self.strategy
        recreate = annealing.recreate._replace(width=strategy.width, depots=strategy.depots)
        self.annealing = annealing._replace(recreate=recreate)
        self.family = family
        self._step_length = 0.0
        self._begin, self.end = 0.0, 1.0

    def plan(self, step: float) -> None:
        """Say which part of the limit a step takes; founders are then annealed as deep as they should.

        That begins with the newcomer under way, unless the limit allows fewer than three founders.
        """
        family = self.family
        self._step_length = step
        parameters = self.parameters.population
        least = max(parameters.least, min(parameters.enough, parameters.per_task * self.data.size[0]))
        founder = step * max(least, parameters.depth * self.strategy.depth * self.data.crowding)
        if founder <= family.longest:
            family.founder = founder
            family.founders = min(self.strategy.size, max(2, int(0.5 * family.threads / founder)))
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

    def _take_in(self, newcomer: Tours) -> bool:
        """End a stage: take its newcomer in, return whether it is new; restart where nothing new came for long."""
        family, new = self.family, self.select(newcomer)
        family.stages += 1
        family.since_restart += 1
        family.barren = 0 if new else family.barren + 1
        if family.since_restart >= family.founders and family.barren > self.strategy.patience * family.founders:
            family.members = [duplicate(self.best)]
            family.since_restart, family.barren = 1, 0
            family.founder = min(2.0 * family.founder, family.longest)
        return new

    def _founding(self, others: int = 0) -> bool:
        """Return whether the next newcomer is a founder; `others` are under way in other threads."""
        return self.family.since_restart + others < self.family.founders or len(self.family.members) < 2

    @property
    def _staleness(self) -> float:
        """How long nothing was new, for the strategy."""
        return self.family.barren / (self.strategy.settling * self.family.founders)

    def select(self, newcomer: Tours) -> bool:
        """Add a copy of `newcomer` where it is better than a member; return whether it is new and in.

        Near members are all replaced by a newcomer better than the best of them, and keep every other out: members
        stay apart. No equal of a member is new: the best of equals may change without end.
        """
        measure, same = self.measure, self.parameters.population.same * self.incumbent
        value, members = fitness(newcomer.cost, measure), self.family.members
        values = [fitness(member.cost, measure) for member in members]
        equal = any(abs(value - other) <= same for other in values)
        apart = self.strategy.distinct() * self.data.size[0]
        near = [i for i, member in enumerate(members) if broken_pairs(newcomer, member, self.data.site) <= apart]
        if near:
            if value > min(values[i] for i in near):
                return False
            rivals = near
        else:
            rivals = [int(np.argmax(values))] if len(values) >= max(2, self.family.founders) else []
            if rivals and value + (same if equal else 0.0) >= values[rivals[0]]:
                return False
        self.family.members = [member for i, member in enumerate(members) if i not in rivals]
        self.family.members.append(duplicate(newcomer))
        return not equal

    def _parents(self) -> tuple[Tours, Tours]:
        """Return a copy of a random member, to become a child, and another member."""
        members = self.family.members
        i = below(self.rng, len(members))
        j = (i + 1 + below(self.rng, len(members) - 1)) % len(members)
        return duplicate(members[i]), members[j]
