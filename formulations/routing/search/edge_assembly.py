"""Edge assembly: a population of rings crossed along AB-cycles, for few UAVs that fly long tours from one site.

Rings are local optima from different first tasks. A ring is crossed with the next of a random order: each child is the
ring with the legs exchanged on one AB-cycle (ab_cycles.py, ring_children.py), and the child that gains most energy for
what diversity it costs replaces it (Nagata & Kobayashi 2013; diversity is the entropy of legs in the population). That
finds which task is on which tour; energies are those of the giant tour with an s so large that what counts is the
total, for a cycle that makes tours unequal may be worth it. Chained search then makes the tours equal.
pcb1173_3 and pr2392_3, 40 s, one run of a prototype: 0.30 and -0.38 % to the best known; by chained search alone, 60 s,
three runs, 0.65 and 0.48 %. With an s of 3 mean legs in the end the same prototype ended at 0.48 and 0.40 %.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search.ab_cycles import AbCycles, ab_room, find_cycles
from formulations.routing.search.candidate_legs import CandidateLegs
from formulations.routing.search.chained_search import ChainedSearch, ChainParameters, chain_legs
from formulations.routing.search.costs import AlikeCosts
from formulations.routing.search.giant_tour import GiantTour, Pressure, energy_of, tours_of
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
from formulations.routing.search.tours import Tours
from instances.kernels import njit

_ROUNDING = 1e-9
"""Share of an energy below which a gain counts as rounding."""


class AssemblyParameters(NamedTuple):
    """How many rings, and for how long.

    size: of the population at most; fewest: without which none is crossed; made, mated: shares of the stage after
    which no more rings are made, and after which they are crossed no more; kids: children of a pair at most;
    barren: orders in a row without a better ring after which crossing ends; first, last: s of the energy in mean
    legs, falling geometrically; chosen: s by which the ring is chosen that chained search goes on from; most: legs
    that a child exchanges at most.
    """

    size: int = 100
    fewest: int = 6
    made: float = 0.12
    mated: float = 0.8
    kids: int = 30
    barren: int = 3
    first: float = 400.0
    last: float = 100.0
    chosen: float = 30.0
    most: int = 4000


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
    """Make the child that exchanges the legs of AB-cycle c; return whether it is one ring."""
    cycles, child = mating.cycles, mating.child
    begin, end = cycles.begins[c], cycles.begins[c + 1]
    child.counts[:] = 0
    if end - begin > child.cuts.size:
        return False
    for x in range(begin, end, 2):
        v = cycles.nodes[x + 1]
        child.cuts[child.counts[0]] = leg_behind(tour, cycles.nodes[x], v)
        child.counts[0] += 1
        put_in(child, v, cycles.nodes[x + 2 if x + 2 < end else begin])
    rings = join_parts(tour, child)
    while rings > 1:
        if child.counts[0] + 2 > child.cuts.size or not join_rings(mating.costs, mating.near, tour, child, rings):
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
    before, top = energy_of(tour, 0, m - 1, pressure), 0.0
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
        self._barren, self._better = 0, True
        self._chained: ChainedSearch | None = None
        self._from = 0.0
        self._best = self._made()
        self._rings.append(self._best)
        self.longest = _longest(self._best)
        self._best = _copied(self._best)

    def advance(self, done: float, steps: int) -> bool:
        """Make a ring, cross some or kick, about `steps` kicks' work, at `done` in 0..1; return whether it gained.

        What counts is the longest tour of any ring.
        """
        how, before = self._how, self.longest
        if self._chained is not None:
            share = (done - self._from) / max(1.0 - self._from, 1e-9)
            self._chained.advance(share, steps)
            self.longest = min(self.longest, self._chained.longest)
        elif self.making and len(self._rings) < how.size and done < how.made:
            self._rings.append(self._made())
            self._remember(self._rings[-1])
        elif len(self._rings) >= how.fewest and done < how.mated and self._barren <= how.barren:
            self._cross(done, max(1, steps // how.kids))
        else:
            self._chained, self._from = self._chain(), done
        return self.longest < before

    @property
    def making(self) -> bool:
        """Whether it still makes rings, each of which takes as long as very many steps."""
        return self._mating is None and self._chained is None

    def best(self) -> Tours:
        """Return the tours whose longest was shortest so far."""
        if self._chained is not None and self._chained.longest <= self.longest:
            return self._chained.best()
        return tours_of(self._costs, self._best.order, self._data.size[1])

    def _made(self) -> GiantTour:
        """Return a local optimum, from the nearest tasks in turn."""
        first = int(self._firsts[len(self._rings) % self._firsts.size])
        start = nearest_in_turn(self._costs, self._data.size[0], first)
        chain = ChainedSearch(self._data, start, self._chain_parameters, self._rng, self._near)
        for scale in (1e3, self._how.first):
            chain.settle(scale)
        return chain.ring

    def _cross(self, done: float, pairs: int) -> None:
        """Cross so many rings with the next of a random order."""
        how, rings = self._how, self._rings
        if self._mating is None:
            self._mating = self._prepared()
        for _ in range(pairs):
            if len(self._order) < 2:
                self._barren = 0 if self._better else self._barren + 1
                self._order, self._better = _shuffled(len(rings), self._rng), False
            i, other = self._order.pop(), self._order[-1]
            leg = float(rings[i].sums[-1]) / self._best.position.size
            scale = leg * how.first * (how.last / how.first) ** min(1.0, done / how.mated)
            if cross(self._mating, rings[i], rings[other], len(rings), how.kids, scale, self._rng):
                self._better = True
                self._remember(rings[i])

    def _prepared(self) -> Mating:
        total = self._best.position.size
        legs = np.zeros((total, total), np.int16)
        for ring in self._rings:
            np.add.at(legs, (ring.order[:-1], ring.order[1:]), 1)
            np.add.at(legs, (ring.order[1:], ring.order[:-1]), 1)
        room = child_room(self._how.most), child_room(self._how.most)
        return Mating(self._costs, self._near, ab_room(total), *room, legs)

    def _chain(self) -> ChainedSearch:
        """Return a chained search from the ring whose energy is least."""
        total, m = self._best.position.size, self._data.size[1]
        shortest = min(float(ring.sums[-1]) for ring in self._rings)
        pressure = Pressure(shortest / m, self._how.chosen * shortest / total)
        ring = min([*self._rings, self._best], key=lambda ring: energy_of(ring, 0, m - 1, pressure))
        chain = self._chain_parameters
        tours = tours_of(self._costs, ring.order, m)
        return ChainedSearch(self._data, tours, chain._replace(first=chain.reheated), self._rng, self._near)

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
    parts = ring.order.copy(), ring.position.copy(), ring.sums.copy(), ring.starts.copy()
    return GiantTour(*parts, ring.spare_order.copy(), ring.spare_sums.copy())


def _shuffled(count: int, rng: Rng) -> list[int]:
    """Return a random order in which the first comes again at the end."""
    order = list(range(count))
    for i in range(count - 1, 0, -1):
        j = below(rng, i + 1)
        order[i], order[j] = order[j], order[i]
    return [*order, order[0]]
