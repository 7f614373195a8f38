"""Population: a few good tours, renewed by annealed founders and annealed children of crossover.

A stage anneals one newcomer. The first stages make founders from scratch; later ones search some tours of a member
alone (focus), take a member and send a UAV of it elsewhere (relief), or make a child of two members.
At the end of a stage every tour of the newcomer gets a better order (intensify).
A newcomer that is no copy of a member replaces the worst member where it is better; a population that brings forth
nothing new for a while keeps its best member and starts over with fresh founders, annealed twice as long. The longer
nothing is new, the more annealings are fine (cooling.py).

With several depots it is a matter of which UAV serves which crowd of tasks: members are compared by a norm, which sees
all crowds whose tours are too long. Where all UAVs start at one place (`packing`) tours can be packed tightly: members
are compared by what exceeds the best known longest tour, in which many tours nearly as long as that are no fault; and
where nothing is new most annealings are fine, many of them a stirring: a good member as it is, annealed from a
temperature so low that it keeps most of itself. The basins of good packings lie near each other. And a task may have to
go to a tour that passes none of its nearest tasks: the annealings' recreations look at all near tasks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search import cooling
from formulations.routing.search.annealing import Habits, anneal
from formulations.routing.search.crossover import crossover
from formulations.routing.search.energy import fitness
from formulations.routing.search.focus import MOST, Part, around_longest, part_of, put_back
from formulations.routing.search.ground import Ground
from formulations.routing.search.intensify import intensify
from formulations.routing.search.neighbours import NEAR_TASKS
from formulations.routing.search.randomness import below, uniform
from formulations.routing.search.recreate import construct
from formulations.routing.search.relief import relieve
from formulations.routing.search.tours import Tours, copy_tours, empty_tours

MEMBERS = 8
"""Members at most."""
CHILD, RELIEF = 0.5, 0.15
"""Lengths of the stages of a child and of a relief, in those of a founder."""
BARREN, BARREN_PACKING = 3, 9
"""Stages in a row without a new member, for each founder, after which the population starts over; and when packing."""
ALL_FINE = 1
"""As many, when packing, after which annealings are fine as often as they may be; else that is BARREN."""
FEWEST, A_TASK, ENOUGH = 10_000, 250, 25_000
"""Steps of a founder, at least: FEWEST, or A_TASK for each task up to ENOUGH; small instances gain more by starts."""
FOCUS, BRIEFEST = 5.0, 10_000
"""Steps of a focus on s tasks of w tours, in s² / w; at least."""
STIR = 40_000
"""Steps of a stirring."""
STRINGS = 0.2
"""Share of ruins by strings in a PACKED annealing, in that of the others: packing is moving single tasks."""
RELIEVED = 0.3
"""Share of focuses that begin with a relief, not from scratch."""
SAME = 1e-9
"""Tours whose fitness differs by less than this share of the best known longest tour count as copies."""


class Shares(NamedTuple):
    """Which of the later stages: the share of focuses in all, and of reliefs in the others; the rest are crossovers."""

    focuses: float
    reliefs: float


class Population:
    """Members, the newcomer being annealed, and the best tours so far.

    Times are fractions of the limit; `founder` is the length of a founder's stage.
    """

    def __init__(
        self,
        ground: Ground,
        habits: Habits,
        shares: Shares,
        kicks: float,
        rng: NDArray[np.uint64],
        start: Tours | None,
    ) -> None:
        self.packing = bool(np.all(ground.place == 0))
        self.habits = habits._replace(width=NEAR_TASKS) if self.packing else habits
        self.ground, self.shares, self.kicks, self.rng = ground, shares, kicks, rng
        self.members: list[Tours] = []
        self.founder, self.founders = 1.0, 1
        self.stages = 0
        self._fresh, self._barren = 0, 0
        self._part: Part | None = None
        self._newcomer = start if start is not None else self._constructed()
        self._whole = self._newcomer
        self._step = 0.0
        self._fittest = self._copy(self._newcomer)
        self.best = self._copy(self._newcomer)
        self.improved = True
        self._manner = cooling.Manner(cooling.HOT, cooling.SOFT[0], cooling.COARSE)
        self._begin, self.end = 0.0, 1.0

    def plan(self, step: float, depth: float) -> None:
        """Say which part of the limit a step takes, and how deep founders are annealed.

        That begins with the founder under way, unless the limit allows fewer than three.
        """
        self._step = step
        least = max(FEWEST, min(ENOUGH, A_TASK * self.ground.size[0]))
        founder = step * max(least, depth * self.ground.crowding)
        if founder <= 1.0 / 3.0:
            self.founder = founder
            self.founders = min(MEMBERS, max(2, int(0.5 / founder)))
            self.end = self._begin + founder

    def advance(self, now: float, steps: int) -> None:
        """Anneal the newcomer by `steps` steps at the temperature that belongs to `now`."""
        done = min(1.0, (now - self._begin) / max(self.end - self._begin, 1e-12))
        costs, near, _ = self.ground if self._part is None else self._part.ground
        best = self.best if self._part is None else self._part.best
        longest = self.best.cost.max()
        temperature, aim = cooling.cool(self._fittest, longest, done, self._manner)
        aim = aim._replace(known=self.known)
        habits = self.habits
        if self._manner.ending is cooling.PACKED:
            habits = habits._replace(strings=STRINGS * habits.strings)
        anneal(costs, near, self._newcomer, best, self._fittest, self.rng, steps, temperature, aim, habits)
        self.improved = self.improved or self.best.cost.max() < longest

    def next_stage(self, now: float, guest: Tours | None = None) -> None:
        """Take the newcomer (and a guest from another population) in and begin the next newcomer."""
        self.stages += 1
        self._fresh += 1
        grown = self._grown()
        self._intensify(grown)
        self._barren = 0 if self._welcome(grown) else self._barren + 1
        if guest is not None:
            self._welcome(guest)
        if self._fresh >= self.founders and self._barren > (BARREN_PACKING if self.packing else BARREN) * self.founders:
            self.members = [self._copy(self.best)]
            self._fresh, self._barren = 1, 0
            self.founder = min(2.0 * self.founder, 1.0 / 3.0)
        self._part = None
        staleness = self._barren / ((ALL_FINE if self.packing else BARREN) * self.founders)
        stirring = cooling.draw_stirring(staleness, self.rng) if self.packing else None
        if stirring is not None:
            self._newcomer, self._manner, length = self._stirred(), stirring, STIR * self._step
        else:
            founding = self._fresh < self.founders or len(self.members) < 2
            self._newcomer, first, length = self._founder() if founding else self._renewed()
            self._manner = cooling.draw_manner(first, staleness, self.packing, self.rng)
        self._fittest = self._copy(self._newcomer)
        self._begin, self.end = now, self._fitting(length, now)

    def _grown(self) -> Tours:
        """Return the newcomer as its stage left it; a part goes back where it is fitter."""
        if self._part is None:
            return self._fittest
        known = self.known
        for found in (self._part.best, self._fittest):
            if fitness(found.cost, known) < fitness(self._part.tours.cost, known):
                put_back(self.ground.costs, self._part.nodes, found, self._whole)
                self._remember(self._whole)
        return self._whole

    def _intensify(self, tours: Tours) -> None:
        """Give every tour a better order."""
        if self.kicks > 0:
            intensify(self.ground.costs, tours, self.rng, self.kicks)
            self._remember(tours)

    @property
    def known(self) -> float:
        """The longest of the best tours [s], by which fitness is measured when packing, else 0."""
        return float(self.best.cost.max()) if self.packing else 0.0

    def _remember(self, tours: Tours) -> None:
        """Keep a copy of tours whose longest is shorter than that of the best."""
        if tours.cost.max() < self.best.cost.max():
            self.improved = True
            copy_tours(tours, self.best)

    def _fitting(self, length: float, now: float) -> float:
        """Return the end of a stage begun now, its length stretched so that a whole number of them fill the limit."""
        left = max(1.0 - now, 0.0)
        return now + left / max(1, round(left / length))

    def _welcome(self, newcomer: Tours) -> bool:
        """Add a copy of `newcomer` unless a member equals it; keep the best members; return whether it is in."""
        known, longest = self.known, float(self.best.cost.max())
        value = fitness(newcomer.cost, known)
        values = [fitness(member.cost, known) for member in self.members]
        if any(abs(value - other) <= SAME * longest for other in values):
            return False
        if len(values) >= max(2, self.founders):
            worst = int(np.argmax(values))
            if value >= values[worst]:
                return False
            del self.members[worst]
        self.members.append(self._copy(newcomer))
        return True

    def _founder(self) -> tuple[Tours, float, float]:
        """Return a newcomer from scratch, its first temperature and the length of its stage."""
        return self._constructed(), cooling.HOT, self.founder

    def _renewed(self) -> tuple[Tours, float, float]:
        """Return a newcomer made from members, its first temperature and the length of its stage."""
        if self.ground.size[1] > 2 and uniform(self.rng) < self.shares.focuses:
            part = self.focused()
            newcomer, length = self._copy(part.tours), self._step * max(BRIEFEST, FOCUS * part.ground.crowding)
            if uniform(self.rng) < RELIEVED:
                relieve(part.ground.costs, part.ground.near, newcomer, self.rng)
                return newcomer, cooling.MILD, CHILD * length
            return newcomer, cooling.HOT, length
        if uniform(self.rng) < self.shares.reliefs:
            return self.relieved(), cooling.MILD, RELIEF * self.founder
        return self.child(), cooling.WARM, CHILD * self.founder

    def focused(self) -> Part:
        """Choose some tours of a random member to be searched alone."""
        self._whole = self._copy(self.members[below(self.rng, len(self.members))])
        wanted = 2 + below(self.rng, min(MOST, self.ground.size[1] - 1) - 1)
        uavs = around_longest(self.ground.near, self._whole, wanted, self.rng)
        self._part = part_of(self.ground, self._whole, uavs)
        return self._part

    def relieved(self) -> Tours:
        """Return a copy of a random member, one of its UAVs sent elsewhere."""
        tours = self._copy(self.members[below(self.rng, len(self.members))])
        relieve(self.ground.costs, self.ground.near, tours, self.rng)
        return tours

    def _stirred(self) -> Tours:
        """Return a copy of the fitter of two random members."""
        i, j = below(self.rng, len(self.members)), below(self.rng, len(self.members))
        a, b = self.members[i], self.members[j]
        return self._copy(a if fitness(a.cost, self.known) <= fitness(b.cost, self.known) else b)

    def child(self) -> Tours:
        """Return the child of two random members."""
        i = below(self.rng, len(self.members))
        j = (i + 1 + below(self.rng, len(self.members) - 1)) % len(self.members)
        child = self._copy(self.members[i])
        crossover(self.ground.costs, self.ground.near, child, self.members[j], self.ground.place, self.rng)
        return child

    def _constructed(self) -> Tours:
        tours = empty_tours(*self.ground.size)
        construct(self.ground.costs, self.ground.near, tours, self.rng)
        return tours

    def _copy(self, tours: Tours) -> Tours:
        copy = empty_tours(tours.after.size - tours.cost.size, tours.cost.size)
        copy_tours(tours, copy)
        return copy
