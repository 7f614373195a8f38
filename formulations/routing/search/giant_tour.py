"""Giant tour: all tours as one ring with a copy of the depot where each begins, and moves that cross those copies.

Where UAVs are alike, fly from one site and legs cost the same both ways, any ring through all tasks and depots is a set
of tours, so a move for one tour is a move between tours as well (Christofides & Eilon 1969). A move cuts the ring
A B C D behind A, B and C, then joins the parts as

    A Bʳ C D (2-opt),  A C B D (or-3opt),  A C Bʳ D,  A Cʳ B D,  A Bʳ Cʳ D,

all there is with three legs. Prefix sums give what every tour of the outcome costs without walking along it
(ring_energy.py).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.search.costs import AlikeCosts, leg
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.tours import Tours, empty_tours, fill, sum_costs
from instances.arrays import Floats, Ints
from instances.kernels import njit

SWAPPED, TURNED_B, TURNED_C = 4, 2, 1
"""What a move does to the parts B and C, added up; a 2-opt move has an empty C, q = r."""


class GiantTour(NamedTuple):
    """The ring, from depot n at position 0.

    order (N+1,), N = n+m: nodes, the first again at the end; position (N,): of each node; sums (N+1,): cost from
    position 0 on [s]; starts (m+1,): positions of depots, ascending, and N; rank (N,): number of the tour that each
    position is on, in the ring's order; spare_order, spare_sums (N,): room.
    """

    order: Nodes
    position: Ints
    sums: Floats
    starts: Ints
    rank: NDArray[np.int16]
    spare_order: Nodes
    spare_sums: Floats


class Kept(NamedTuple):
    """A ring to come back to: order and sums (N+1,)."""

    order: Nodes
    sums: Floats


def giant_tour(costs: AlikeCosts, tours: Tours) -> GiantTour:
    """Return the tours one after the other."""
    m, total, after = tours.cost.size, tours.after.size, tours.after.tolist()
    nodes: list[int] = []
    for depot in range(total - m, total):
        nodes.append(depot)
        while after[nodes[-1]] != depot:
            nodes.append(after[nodes[-1]])
    order = np.array([*nodes, nodes[0]], np.int32)
    position = np.empty(total, np.int64)
    position[order[:total]] = np.arange(total)
    starts = np.append(np.sort(position[total - m :]), total)
    room = np.zeros(total, np.int16), np.empty(total, np.int32), np.empty(total)
    ring = GiantTour(order, position, np.zeros(total + 1), starts, *room)
    rank(ring, 0, m - 1)
    add_up(costs, ring)
    return ring


def tours_of(costs: AlikeCosts, order: Nodes, m: int) -> Tours:
    """Return the tours of a ring's `order`."""
    n = order.size - 1 - m
    tours = empty_tours(n, m)
    starts = np.append(np.flatnonzero(order[:-1] >= n), n + m)
    for k in range(m):
        fill(costs, tours, k, order[starts[k] + 1 : starts[k + 1]])
    sum_costs(tours)
    return tours


@njit(cache=True, nogil=True)
def add_up(costs: AlikeCosts, ring: GiantTour) -> None:
    """Recompute the prefix sums, so that rounding of many small changes cannot gather."""
    order, sums = ring.order, ring.sums
    sums[0] = 0.0
    for i in range(order.size - 1):
        sums[i + 1] = sums[i] + leg(costs, 0, order[i], order[i + 1])


@njit(cache=True, nogil=True)
def rank(ring: GiantTour, first: int, last: int) -> None:
    """Write which tour each position of tours first..last is on."""
    for k in range(first, last + 1):
        for i in range(ring.starts[k], ring.starts[k + 1]):
            ring.rank[i] = k


@njit(cache=True, nogil=True)
def is_between(i: int, first: int, last: int) -> bool:
    """Return whether position i is in first..last, across the ring's end where last < first."""
    return first <= i <= last if first <= last else (i >= first or i <= last)


@njit(cache=True, nogil=True)
def part_of(part: int, p: int, q: int, r: int, kind: int) -> tuple[int, int, bool]:
    """Return (first position, last position, whether turned) of the part that comes as number `part` after A."""
    if (part == 1) == (kind & SWAPPED == 0):
        return q + 1, r, kind & TURNED_C != 0
    return p + 1, q, kind & TURNED_B != 0


@njit(cache=True, nogil=True)
def rejoin(costs: AlikeCosts, ring: GiantTour, p: int, q: int, r: int, kind: int) -> None:
    """Make the move that cuts behind positions p ≤ q ≤ r < N."""
    order, position, sums, starts, _, spare, spare_sums = ring
    u, at, so_far = order[p], 0, sums[p]
    for part in range(2):
        i, j, turned = part_of(part, p, q, r, kind)
        if i > j:
            continue
        so_far += leg(costs, 0, u, order[j] if turned else order[i])
        u = order[i] if turned else order[j]
        if turned:
            for x in range(j - i + 1):
                spare[at + x] = order[j - x]
                spare_sums[at + x] = so_far + (sums[j] - sums[j - x])
        else:
            for x in range(j - i + 1):
                spare[at + x] = order[i + x]
                spare_sums[at + x] = so_far + (sums[i + x] - sums[i])
        at += j - i + 1
        so_far += sums[j] - sums[i]
    change = so_far + leg(costs, 0, u, order[r + 1]) - sums[r + 1]
    for x in range(at):
        v = spare[x]
        order[p + 1 + x] = v
        position[v] = p + 1 + x
        sums[p + 1 + x] = spare_sums[x]
    for x in range(r + 1, sums.size):
        sums[x] += change
    first, last = ring.rank[p], ring.rank[r]
    if first < last:
        _find_starts(starts, position)
        rank(ring, first, last)


@njit(cache=True, nogil=True)
def _find_starts(starts: Ints, position: Ints) -> None:
    """Write the depots' positions in ascending order (by insertion: there are few)."""
    m = starts.size - 1
    n = position.size - m
    for k in range(m):
        i = k
        while i > 0 and starts[i - 1] > position[n + k]:
            starts[i] = starts[i - 1]
            i -= 1
        starts[i] = position[n + k]


@njit(cache=True, nogil=True)
def keep(ring: GiantTour, kept: Kept, first: int, last: int) -> None:
    """Follow the ring, which differs at positions first..last and in the prefix sums from there on."""
    for i in range(first, last + 1):
        kept.order[i] = ring.order[i]
    for i in range(first, kept.sums.size):
        kept.sums[i] = ring.sums[i]


@njit(cache=True, nogil=True)
def restore(ring: GiantTour, kept: Kept, first: int, last: int, crossed: bool) -> None:
    """Make the ring as it was kept, which differs there; crossed: whether depots may have moved."""
    for i in range(first, last + 1):
        v = kept.order[i]
        ring.order[i] = v
        ring.position[v] = i
    for i in range(first, kept.sums.size):
        ring.sums[i] = kept.sums[i]
    if crossed:
        a, b = ring.rank[first - 1], ring.rank[last]
        _find_starts(ring.starts, ring.position)
        rank(ring, a, b)
