"""Edge assembly: rings of little work each, crossed along AB-cycles, for few UAVs that fly long tours from one site.

Rings are descents from different first tasks, kicked some times for each task (chained_search.py): a kick is worth most
while a ring is poor, and rings made apart are poor in different places. Bridges (bridges.py) take part in both: 30 s,
two seeds, rl5915_3, rl5915_5, pr2392_5 in the mean 0.04 % above the best known, without them 0.47 %.
A ring is crossed with the next of a random order: of all AB-cycles (ab_cycles.py, ring_children.py; Nagata & Kobayashi
2013) the legs are exchanged on one after the other that makes it better, which is where the other is better than it.
That finds which task is on which tour.
Energies are those of the giant tour; their s is so large that the total counts most, for a cycle that makes tours
unequal may be worth it: crossed down to an s of 25 mean legs pr2392_5 and pcb1173_5 came out 0.7 % longer than crossed
down to 100. No cycle alone makes tours equal again that all rings have unequal, so that rings descend anew when s
falls; d1655_5, whose shortest total has one tour 40 % longer than the mean, needs it most.
In the end chained search makes the tours of the best ring equal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from formulations.routing.search.ab_cycles import AbCycles, ab_room, find_cycles
from formulations.routing.search.candidate_legs import CandidateLegs
from formulations.routing.search.chain_moves import ChainParameters
from formulations.routing.search.chained_search import ChainedSearch, chain_legs
from formulations.routing.search.costs import AlikeCosts, leg
from formulations.routing.search.giant_tour import GiantTour, giant_tour, tours_of
from formulations.routing.search.nearest_in_turn import nearest_in_turn
from formulations.routing.search.problem_data import ProblemData
from formulations.routing.search.randomness import Rng, below
from formulations.routing.search.ring_children import (
    RingChild,
    become,
    child_energy,
    child_room,
    join_parts,
    join_rings,
    leg_behind,
    put_in,
)
from formulations.routing.search.ring_energy import Pressure, energy_of
from formulations.routing.search.tours import Tours
from instances.kernels import njit

_ROUNDING = 1e-9
"""Share of an energy below which a gain counts as rounding."""
_PAIR = 30
"""Kicks that take about as long as to cross a pair of rings."""


class AssemblyParameters(NamedTuple):
    """How many rings, and for how long.

    size: of the population at most; fewest: without which none is crossed; made: share of the stage after which no more
    rings are made; kicks: of a new ring, for each task; cold: their temperature, in mean legs; loose: s of the energy
    in mean legs, of a ring's first descent; scales: s of the second and of its kicks, and of crossing, one after the
    other; under the last they only descend; mated: share of the stage after which they are crossed no more, of what is
    left for it the same for each s; barren: orders in a row without a better ring after which s falls too; kept: share
    of the rings, those of least energy, that go on each time; most: legs that a child exchanges at most; chosen: s by
    which the ring is chosen that chained search goes on from; reheated, last: its temperatures then, in mean legs;
    walk, bridged: legs of the walks to where kicks are, and tasks of a bridge at most, of rings and then.
    """

    size: int = 300
    fewest: int = 6
    made: float = 0.5
    kicks: float = 2.0
    cold: float = 0.1
    loose: float = 1000.0
    scales: tuple[float, ...] = (200.0, 100.0, 50.0)
    mated: float = 0.75
    barren: int = 2
    kept: float = 0.5
    most: int = 4000
    chosen: float = 30.0
    reheated: float = 0.8
    last: float = 0.1
    walk: int = 8
    bridged: int = 1000


class Mating(NamedTuple):
    """What crossing works with."""

    costs: AlikeCosts
    near: CandidateLegs
    cycles: AbCycles
    child: RingChild


@njit(cache=True, nogil=True)
def _assemble(mating: Mating, tour: GiantTour, c: int) -> bool:
    """Make the child that exchanges the legs of AB-cycle c; return whether it is one ring.

    Several rings that cost no less than the tour are not joined: that would cost more still. Nor is there a child where
    the tour has lost legs of the cycle.
    """
    cycles, child = mating.cycles, mating.child
    begin, end = cycles.begins[c], cycles.begins[c + 1]
    child.counts[:] = 0
    if end - begin > child.cuts.size:
        return False
    saved = 0.0
    for x in range(begin, end, 2):
        u, v, w = cycles.nodes[x], cycles.nodes[x + 1], cycles.nodes[x + 2 if x + 2 < end else begin]
        child.cuts[child.counts[0]] = leg_behind(tour, u, v)
        if child.cuts[child.counts[0]] < 0:
            return False
        child.counts[0] += 1
        put_in(child, v, w)
        saved += leg(mating.costs, 0, u, v) - leg(mating.costs, 0, v, w)
    rings = join_parts(tour, child)
    while rings > 1:
        if saved <= 0.0 or child.counts[0] + 2 > child.cuts.size:
            return False
        if not join_rings(mating.costs, mating.near, tour, child, rings):
            return False
        rings = join_parts(tour, child)
    return True


@njit(cache=True, nogil=True)
def cross(mating: Mating, tour: GiantTour, other: GiantTour, scale: float, rng: Rng) -> bool:
    """Exchange the tour's legs for another's on each AB-cycle where that is better; return whether any was.

    scale: s of the energy [s], whose μ is the mean of the tour itself.
    """
    pressure = Pressure(tour.sums[-1] / (tour.starts.size - 1), scale)
    energy, better = energy_of(tour, pressure), False
    for c in range(find_cycles(tour, other, mating.cycles, rng)):
        if not _assemble(mating, tour, c):
            continue
        then = child_energy(mating.costs, tour, mating.child, pressure)
        if energy - then > _ROUNDING * energy:
            become(mating.costs, tour, mating.child)
            energy, better = then, True
    return better


class EdgeAssembly:
    """A population of rings under way, then a chained search from the best of them."""

    def __init__(self, data: ProblemData, parameters: ChainParameters, how: AssemblyParameters, rng: Rng) -> None:
        costs, total = data.costs, sum(data.size)
        assert isinstance(costs, AlikeCosts)
        self._data, self._costs, self._how, self._rng = data, costs, how, rng
        self._chain_parameters = parameters._replace(walk=how.walk, bridged=how.bridged)
        self._near = chain_legs(costs, data.size[0], parameters)
        self._firsts = np.argsort([below(rng, 1 << 30) for _ in range(data.size[0])], kind="stable")
        self._rings: list[GiantTour] = []
        self._mating = Mating(costs, self._near, ab_room(total), child_room(how.most))
        self._order: list[int] = []
        self._level = self._barren = self._kicks = 0
        self._better = True
        self._chained: ChainedSearch | None = None
        self._crossed: float | None = None
        """From which part of the stage on rings are crossed."""
        self._from = 0.0
        self._young = self._begun()
        self._best, self.longest = _copied(self._rings[0]), _longest(self._rings[0])

    def advance(self, done: float, steps: int) -> bool:
        """Kick a ring or begin one, cross some or kick, about `steps` kicks' work, at `done` in 0..1.

        Return whether that gained: what counts is the longest tour of any ring.
        """
        how, before, rings = self._how, self.longest, len(self._rings)
        if self._chained is not None:
            share = (done - self._from) / max(1.0 - self._from, 1e-9)
            self._chained.advance(share, steps)
            self.longest = min(self.longest, self._chained.longest)
        elif self._kicks > 0:
            self._kick(steps if done < how.made else 0)
        elif self.making and rings < how.size and done < how.made:
            self._young = self._begun()
            self._remember(self._rings[-1])
        elif rings >= how.fewest and self._level < len(how.scales) - 1:
            self._cross(done, max(1, steps // _PAIR))
        else:
            self._chained, self._from = self._chain(), done
        return self.longest < before

    @property
    def making(self) -> bool:
        """Whether it may begin a ring, which takes as long as very many steps."""
        return self._crossed is None and self._chained is None and self._kicks == 0

    def best(self) -> Tours:
        """Return the tours whose longest was shortest so far."""
        if self._chained is not None and self._chained.longest <= self.longest:
            return self._chained.best()
        return tours_of(self._costs, self._best.order, self._data.size[1])

    def _begun(self) -> ChainedSearch:
        """Add a local optimum, from the nearest tasks in turn, to the rings; return the search that is to kick it."""
        how = self._how
        first = int(self._firsts[len(self._rings) % self._firsts.size])
        cold = self._chain_parameters._replace(first=how.cold, last=how.cold, scale=how.scales[0] / how.cold)
        chain = self._settled(nearest_in_turn(self._data, first), cold, how.loose, how.scales[0])
        self._rings.append(self._ring_of(chain))
        self._kicks = math.ceil(how.kicks * self._data.size[0])
        return chain

    def _kick(self, steps: int) -> None:
        """Kick the newest ring so often, or enough; with no steps left it is as it is."""
        kicks = min(steps, self._kicks)
        self._young.advance(0.0, kicks)
        self._kicks -= kicks
        if self._kicks == 0 or kicks == 0:
            self._kicks = 0
            self._rings[-1] = self._ring_of(self._young)
            self._remember(self._rings[-1])

    def _settled(self, tours: Tours, parameters: ChainParameters, *scales: float) -> ChainedSearch:
        """Return the search that has tours descend, each time with an s of so many mean legs."""
        chain = ChainedSearch(self._data, tours, parameters, self._rng, self._near)
        for scale in scales:
            chain.settle(scale)
        return chain

    def _ring_of(self, chain: ChainedSearch) -> GiantTour:
        """Return the ring that a search is at."""
        return giant_tour(self._costs, chain.ring(), self._data.size[1])

    def _cross(self, done: float, pairs: int) -> None:
        """Cross so many rings with the next of a random order, or let s fall in the end of one."""
        how, rings = self._how, self._rings
        self._crossed = done if self._crossed is None else self._crossed
        for _ in range(pairs):
            if len(self._order) < 2:
                self._barren = 0 if self._better else self._barren + 1
                share = (self._level + 1) / (len(how.scales) - 1)
                if self._barren >= how.barren or done > self._crossed + (how.mated - self._crossed) * share:
                    self._fall()
                    return
                self._order, self._better = _shuffled(len(rings), self._rng), False
            i, other = self._order.pop(), self._order[-1]
            scale = how.scales[self._level] * float(rings[i].sums[-1]) / self._best.position.size
            if cross(self._mating, rings[i], rings[other], scale, self._rng):
                self._better = True
                self._remember(rings[i])

    def _fall(self) -> None:
        """Let s fall, and the rings of least energy descend anew."""
        self._level, self._barren, self._better, self._order = self._level + 1, 0, True, []
        m, scale, parameters = self._data.size[1], self._how.scales[self._level], self._chain_parameters
        count = max(self._how.fewest, int(self._how.kept * len(self._rings)))
        kept = [tours_of(self._costs, ring.order, m) for ring in sorted(self._rings, key=self._energy(scale))[:count]]
        self._rings = [self._ring_of(self._settled(tours, parameters, scale)) for tours in kept]
        for ring in self._rings:
            self._remember(ring)

    def _chain(self) -> ChainedSearch:
        """Return a chained search from the ring whose energy is least."""
        how, m = self._how, self._data.size[1]
        ring = min([*self._rings, self._best], key=self._energy(how.chosen))
        chain = self._chain_parameters._replace(first=how.reheated, last=how.last)
        return ChainedSearch(self._data, tours_of(self._costs, ring.order, m), chain, self._rng, self._near)

    def _energy(self, scale: float) -> Callable[[GiantTour], float]:
        """Return the energy of rings, with an s of so many mean legs and the shortest total's mean tour [s]."""
        m, shortest = self._data.size[1], min(float(ring.sums[-1]) for ring in self._rings)
        pressure = Pressure(shortest / m, scale * shortest / self._best.position.size)
        return lambda ring: float(energy_of(ring, pressure))

    def _remember(self, ring: GiantTour) -> None:
        """Keep a copy of a ring whose longest tour is shortest."""
        longest = _longest(ring)
        if longest < self.longest:
            self.longest, self._best = longest, _copied(ring)


def _longest(ring: GiantTour) -> float:
    """Return the cost of a ring's longest tour [s]."""
    return float(np.diff(ring.sums[ring.starts]).max())


def _copied(ring: GiantTour) -> GiantTour:
    """Return a copy."""
    return GiantTour._make(part.copy() for part in ring)


def _shuffled(count: int, rng: Rng) -> list[int]:
    """Return a random order in which the first comes again at the end."""
    order = list(range(count))
    for i in range(count - 1, 0, -1):
        j = below(rng, i + 1)
        order[i], order[j] = order[j], order[i]
    return [*order, order[0]]
