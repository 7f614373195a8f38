"""Edge assembly: a population of rings crossed along AB-cycles, for few UAVs that fly long tours from one site.

Rings are local optima from different first tasks. A ring is crossed with the next of a random order: each child is the
ring with the legs exchanged on one AB-cycle (ab_cycles.py, ring_children.py), and the child that gains most energy for
what diversity it costs replaces it (Nagata & Kobayashi 2013; diversity is the entropy of legs in the population). That
finds which task is on which tour. Energies are those of the giant tour; their s is so large that the total counts most,
for a cycle that makes tours unequal may be worth it: crossed down to an s of 25 mean legs pr2392_5 and pcb1173_5 came
out 0.7 % longer than crossed down to 100. No cycle alone makes tours equal again that all rings have unequal, so that
rings descend anew when s falls; d1655_5, whose shortest total has one tour 40 % longer than the mean, needs it most.
In the end chained search makes the tours of the best ring equal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search.ab_cycles import AbCycles, ab_room, find_cycles
from formulations.routing.search.candidate_legs import CandidateLegs
from formulations.routing.search.chained_search import ChainedSearch, ChainParameters, chain_legs
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


class AssemblyParameters(NamedTuple):
    """How many rings, and for how long.

    size: of the population at most; fewest: without which none is crossed; made: share of the stage after which no more
    rings are made; enough, late: number of rings up to which they are made until then, where one takes long; loose: s
    of the energy in mean legs, of their first descent; scales: s of the second, and of crossing, one after the other;
    under the last they only descend; mated: share of the stage after which they are crossed no more, the same for each
    s; barren: orders in a row without a better ring after which s falls too; kept: share of the rings, those of least
    energy, that go on each time; kids: children of a pair at most; most: legs that a child exchanges at most; chosen: s
    by which the ring is chosen that chained search goes on from; reheated: its first temperature then, in mean legs.
    60 s, single runs, begun at 0.2, 0.5 and 1: pr2392_5 0.68, 0.28 and 0.14 %, pcb3038_5 0.45, 0.06 and 0.27 %.
    """

    size: int = 300
    fewest: int = 6
    made: float = 0.06
    enough: int = 60
    late: float = 0.15
    loose: float = 1000.0
    scales: tuple[float, ...] = (200.0, 100.0, 50.0)
    mated: float = 0.47
    barren: int = 2
    kept: float = 0.5
    kids: int = 30
    most: int = 4000
    chosen: float = 30.0
    reheated: float = 0.8


class Mating(NamedTuple):
    """What crossing works with; legs (N, N) counts how many rings of the population have each leg."""

    costs: AlikeCosts
    near: CandidateLegs
    cycles: AbCycles
    child: RingChild
    best: RingChild
    legs: NDArray[np.int16]


@njit(cache=True, nogil=True)
def _entropy(count: int, size: int) -> float:
    """Return the entropy of a leg that `count` of `size` rings have."""
    return 0.0 if count <= 0 else -count / size * math.log(count / size)


@njit(cache=True, nogil=True)
def _diversity_lost(tour: GiantTour, child: RingChild, legs: NDArray[np.int16], size: int) -> float:
    """Return by how much the entropy of legs falls if the child replaces the tour."""
    lost = 0.0
    for i in child.cuts[: child.counts[0]]:
        count = legs[tour.order[i], tour.order[i + 1]]
        lost += _entropy(count, size) - _entropy(count - 1, size)
    for j in range(child.counts[1]):
        count = legs[child.added[j, 0], child.added[j, 1]]
        lost += _entropy(count, size) - _entropy(count + 1, size)
    return lost


@njit(cache=True, nogil=True)
def _copy(child: RingChild, other: RingChild) -> None:
    """Make `other` exchange the same legs."""
    other.counts[:] = child.counts
    other.cuts[: child.counts[0]] = child.cuts[: child.counts[0]]
    other.added[: child.counts[1]] = child.added[: child.counts[1]]


@njit(cache=True, nogil=True)
def _assemble(mating: Mating, tour: GiantTour, c: int) -> bool:
    """Make the child that exchanges the legs of AB-cycle c; return whether it is one ring.

    Several rings that cost no less than the tour are not joined: that would cost more still.
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
def _replace(mating: Mating, tour: GiantTour) -> None:
    """Make the tour its best child, and count its legs."""
    best, legs = mating.best, mating.legs
    for i in best.cuts[: best.counts[0]]:
        v, w = tour.order[i], tour.order[i + 1]
        legs[v, w] -= 1
        legs[w, v] -= 1
    for j in range(best.counts[1]):
        v, w = best.added[j]
        legs[v, w] += 1
        legs[w, v] += 1
    join_parts(tour, best)
    become(mating.costs, tour, best)


@njit(cache=True, nogil=True)
def cross(mating: Mating, tour: GiantTour, other: GiantTour, size: int, kids: int, scale: float, rng: Rng) -> bool:
    """Make the tour the best of its children with another; return whether one is better.

    scale: s of the energy [s], whose μ is the mean of the tour itself.
    """
    m = tour.starts.size - 1
    pressure = Pressure(tour.sums[-1] / m, scale)
    left = find_cycles(tour, other, mating.cycles, rng)
    before, top = energy_of(tour, pressure), 0.0
    for _ in range(min(kids, left)):
        at = below(rng, left)
        left -= 1
        c = mating.cycles.pick[at]
        mating.cycles.pick[at] = mating.cycles.pick[left]
        if not _assemble(mating, tour, c):
            continue
        gain = before - child_energy(mating.costs, tour, mating.child, pressure)
        if gain <= _ROUNDING * before:
            continue
        worth = gain / max(_diversity_lost(tour, mating.child, mating.legs, size), 1e-9)
        if worth > top:
            top = worth
            _copy(mating.child, mating.best)
    if top > 0.0:
        _replace(mating, tour)
    return top > 0.0


class EdgeAssembly:
    """A population of rings under way, then a chained search from the best of them."""

    def __init__(self, data: ProblemData, parameters: ChainParameters, how: AssemblyParameters, rng: Rng) -> None:
        costs = data.costs
        assert isinstance(costs, AlikeCosts)
        self._data, self._costs, self._chain_parameters, self._how, self._rng = data, costs, parameters, how, rng
        self._near = chain_legs(costs, data.size[0], parameters)
        self._firsts = np.argsort([below(rng, 1 << 30) for _ in range(data.size[0])], kind="stable")
        self._rings: list[GiantTour] = []
        self._mating: Mating | None = None
        self._order: list[int] = []
        self._level = self._barren = 0
        self._better = True
        self._chained: ChainedSearch | None = None
        self._from = 0.0
        self._rings.append(self._made())
        self._best, self.longest = _copied(self._rings[0]), _longest(self._rings[0])

    def advance(self, done: float, steps: int) -> bool:
        """Make a ring, cross some or kick, about `steps` kicks' work, at `done` in 0..1; return whether it gained.

        What counts is the longest tour of any ring.
        """
        how, before, rings = self._how, self.longest, len(self._rings)
        if self._chained is not None:
            share = (done - self._from) / max(1.0 - self._from, 1e-9)
            self._chained.advance(share, steps)
            self.longest = min(self.longest, self._chained.longest)
        elif self.making and rings < how.size and done < (how.made if rings >= how.enough else how.late):
            self._rings.append(self._made())
            self._remember(self._rings[-1])
        elif rings >= how.fewest and self._level < len(how.scales) - 1:
            self._cross(done, max(1, steps // how.kids))
        else:
            self._chained, self._from = self._chain(), done
        return self.longest < before

    @property
    def making(self) -> bool:
        """Whether it still makes rings, each of which takes as long as very many steps."""
        return self._level == 0 and self._mating is None and self._chained is None

    def best(self) -> Tours:
        """Return the tours whose longest was shortest so far."""
        if self._chained is not None and self._chained.longest <= self.longest:
            return self._chained.best()
        return tours_of(self._costs, self._best.order, self._data.size[1])

    def _made(self) -> GiantTour:
        """Return a local optimum, from the nearest tasks in turn."""
        first = int(self._firsts[len(self._rings) % self._firsts.size])
        start = nearest_in_turn(self._data, first)
        return self._settled(start, self._how.loose, self._how.scales[0])

    def _settled(self, tours: Tours, *scales: float) -> GiantTour:
        """Return the ring that tours become by descents, each with an s of so many mean legs."""
        chain = ChainedSearch(self._data, tours, self._chain_parameters, self._rng, self._near)
        for scale in scales:
            chain.settle(scale)
        return giant_tour(self._costs, chain.ring(), self._data.size[1])

    def _cross(self, done: float, pairs: int) -> None:
        """Cross so many rings with the next of a random order, or let s fall in the end of one."""
        how, rings = self._how, self._rings
        if self._mating is None:
            self._mating = self._prepared()
        for _ in range(pairs):
            if len(self._order) < 2:
                self._barren = 0 if self._better else self._barren + 1
                if self._barren >= how.barren or done > how.mated * (self._level + 1) / (len(how.scales) - 1):
                    self._fall()
                    return
                self._order, self._better = _shuffled(len(rings), self._rng), False
            i, other = self._order.pop(), self._order[-1]
            scale = how.scales[self._level] * float(rings[i].sums[-1]) / self._best.position.size
            if cross(self._mating, rings[i], rings[other], len(rings), how.kids, scale, self._rng):
                self._better = True
                self._remember(rings[i])

    def _fall(self) -> None:
        """Let s fall, and the rings of least energy descend anew."""
        self._level, self._barren, self._better, self._order = self._level + 1, 0, True, []
        m, scale = self._data.size[1], self._how.scales[self._level]
        count = max(self._how.fewest, int(self._how.kept * len(self._rings)))
        kept = sorted(self._rings, key=self._energy(scale))[:count]
        self._rings = [self._settled(tours_of(self._costs, ring.order, m), scale) for ring in kept]
        for ring in self._rings:
            self._remember(ring)
        self._mating = None

    def _prepared(self) -> Mating:
        """Return what crossing works with, legs counted."""
        total = self._best.position.size
        legs = np.zeros((total, total), np.int16)
        for ring in self._rings:
            np.add.at(legs, (ring.order[:-1], ring.order[1:]), 1)
            np.add.at(legs, (ring.order[1:], ring.order[:-1]), 1)
        room = child_room(self._how.most), child_room(self._how.most)
        return Mating(self._costs, self._near, ab_room(total), *room, legs)

    def _chain(self) -> ChainedSearch:
        """Return a chained search from the ring whose energy is least; where none was crossed it begins hot."""
        ring, m = min([*self._rings, self._best], key=self._energy(self._how.chosen)), self._data.size[1]
        chain = self._chain_parameters
        if not self.making:
            chain = chain._replace(first=self._how.reheated)
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
