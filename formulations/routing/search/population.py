"""Population: a few good tours, renewed by annealed founders and annealed children of crossover.

A stage anneals one newcomer. The first stages make founders from scratch; later ones take a member and send a UAV of
it elsewhere (relief), or make a child of two members.
A newcomer that is no copy of a member replaces the worst member where it is better; a population that brings forth
nothing new for a while keeps its best member and starts over with fresh founders, annealed twice as long.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search import cooling
from formulations.routing.search.annealing import Habits, anneal
from formulations.routing.search.costs import Costs
from formulations.routing.search.crossover import crossover
from formulations.routing.search.neighbours import Neighbours
from formulations.routing.search.randomness import below, uniform
from formulations.routing.search.recreate import construct
from formulations.routing.search.relief import relieve
from formulations.routing.search.tours import Tours, copy_tours, empty_tours

MEMBERS = 8
"""Members at most."""
CHILD, RELIEF = 0.5, 0.15
"""Lengths of the stages of a child and of a relief, in those of a founder."""
BARREN = 3
"""Stages in a row without a new member, for each founder, after which the population starts over."""
SAME = 1e-9
"""Tours whose longest differ by less than this share count as copies."""


class Ground(NamedTuple):
    """What all searches of one instance share, read only: costs, neighbours, the place of each depot."""

    costs: Costs
    near: Neighbours
    place: NDArray[np.int64]


class Population:
    """Members, the newcomer being annealed, and the best tours so far.

    Times are fractions of the limit; `founder` is the length of a founder's stage; reliefs: share of the later stages
    that are reliefs.
    """

    def __init__(
        self, ground: Ground, habits: Habits, reliefs: float, rng: NDArray[np.uint64], start: Tours | None
    ) -> None:
        self.ground, self.habits, self.reliefs, self.rng = ground, habits, reliefs, rng
        self.members: list[Tours] = []
        self.founder, self.founders = 1.0, 1
        self.stages = 0
        self._fresh, self._barren = 0, 0
        self._newcomer = start if start is not None else self._constructed()
        self._best_of_stage = self._copy(self._newcomer)
        self.best = self._copy(self._newcomer)
        self.improved = True
        self._first, self._begin, self.end = cooling.HOT, 0.0, 1.0

    def plan(self, founder: float) -> None:
        """Set the length of a founder's stage, the one under way included; a third of the limit is its least use."""
        if founder <= 1.0 / 3.0:
            self.founder = founder
            self.founders = min(MEMBERS, max(2, int(0.5 / founder)))
            self.end = self._begin + founder

    def advance(self, now: float, steps: int) -> None:
        """Anneal the newcomer by `steps` steps at the temperature that belongs to `now`."""
        done = min(1.0, (now - self._begin) / max(self.end - self._begin, 1e-12))
        temperature = cooling.mean_leg(self._best_of_stage) * cooling.temperature(self._first, done)
        evenness = cooling.evenness(self._first, done)
        costs, near, _ = self.ground
        anneal(costs, near, self._newcomer, self._best_of_stage, self.rng, steps, temperature, evenness, self.habits)
        if self._best_of_stage.cost.max() < self.best.cost.max():
            self.improved = True
            copy_tours(self._best_of_stage, self.best)

    def next_stage(self, now: float, guest: Tours | None = None) -> None:
        """Take the newcomer (and a guest from another population) in and begin the next newcomer."""
        self.stages += 1
        self._fresh += 1
        self._barren = 0 if self._welcome(self._best_of_stage) else self._barren + 1
        if guest is not None:
            self._welcome(guest)
        if self._fresh >= self.founders and self._barren > BARREN * self.founders:
            self.members = [self._copy(self.best)]
            self._fresh, self._barren = 1, 0
            self.founder = min(2.0 * self.founder, 1.0 / 3.0)
        if self._fresh < self.founders or len(self.members) < 2:
            self._newcomer, self._first, length = self._constructed(), cooling.HOT, self.founder
        else:
            self._newcomer, self._first, length = self._renewed()
        self._best_of_stage = self._copy(self._newcomer)
        self._begin, self.end = now, self._fitting(length, now)

    def _fitting(self, length: float, now: float) -> float:
        """Return the end of a stage begun now, its length stretched so that a whole number of them fill the limit."""
        left = max(1.0 - now, 0.0)
        return now + left / max(1, round(left / length))

    def _welcome(self, newcomer: Tours) -> bool:
        """Add a copy of `newcomer` unless a member equals it; keep the best members; return whether it is in."""
        value = newcomer.cost.max()
        values = [member.cost.max() for member in self.members]
        if any(abs(value - other) <= SAME * max(value, other) for other in values):
            return False
        if len(values) >= max(2, self.founders):
            worst = int(np.argmax(values))
            if value >= values[worst]:
                return False
            del self.members[worst]
        self.members.append(self._copy(newcomer))
        return True

    def _renewed(self) -> tuple[Tours, float, float]:
        """Return a newcomer made from members, its first temperature and the length of its stage."""
        if uniform(self.rng) < self.reliefs:
            return self.relieved(), cooling.MILD, RELIEF * self.founder
        return self.child(), cooling.WARM, CHILD * self.founder

    def relieved(self) -> Tours:
        """Return a copy of a random member, one of its UAVs sent elsewhere."""
        tours = self._copy(self.members[below(self.rng, len(self.members))])
        relieve(self.ground.costs, self.ground.near, tours, self.rng)
        return tours

    def child(self) -> Tours:
        """Return the child of two random members."""
        i = below(self.rng, len(self.members))
        j = (i + 1 + below(self.rng, len(self.members) - 1)) % len(self.members)
        child = self._copy(self.members[i])
        crossover(self.ground.costs, self.ground.near, child, self.members[j], self.ground.place, self.rng)
        return child

    def _constructed(self) -> Tours:
        tours = empty_tours(self.ground.near.tasks.shape[0], self.ground.place.size)
        construct(self.ground.costs, self.ground.near, tours, self.rng)
        return tours

    def _copy(self, tours: Tours) -> Tours:
        copy = empty_tours(tours.after.size - tours.cost.size, tours.cost.size)
        copy_tours(tours, copy)
        return copy
