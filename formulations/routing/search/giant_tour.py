"""Giant tour: all tours as one ring with a copy of the depot where each begins, and moves that cross those copies.

Where UAVs are alike, fly from one site and legs cost the same both ways, any ring through all tasks and depots is a set
of tours, so a move for one tour is a move between tours as well (Christofides & Eilon 1969). A move cuts the ring
A B C D behind A, B and C, then joins the parts as

    A Bʳ C D (2-opt),  A C B D (or-3opt),  A C Bʳ D,  A Cʳ B D,  A Bʳ Cʳ D,

all there is with three legs. Prefix sums give what every tour of the outcome costs without walking along it, so that
moves are judged by the energy of tours,

    E = Σ_k s · exp((C_k − μ) / s),

which near the mean tour μ is the total, and rises the faster the more a tour exceeds it: s [s] is how much is a lot.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from formulations.routing.search.costs import AlikeCosts, leg
from formulations.routing.search.problem_data import Nodes
from formulations.routing.search.tours import Tours, empty_tours, fill, sum_costs
from instances.arrays import Floats, Ints
from instances.kernels import njit

SWAPPED, TURNED_B, TURNED_C = 4, 2, 1
"""What a move does to the parts B and C, added up; a 2-opt move has an empty C, q = r."""
_STEEPEST = 30.0
"""Exponents above it are continued by the tangent, so that no energy overflows."""


class GiantTour(NamedTuple):
    """The ring, from depot n at position 0.

    order (N+1,), N = n+m: nodes, the first again at the end; position (N,): of each node; sums (N+1,): cost from
    position 0 on [s]; starts (m+1,): positions of depots, ascending, and N; spare_order, spare_sums (N,): room.
    """

    order: Nodes
    position: Ints
    sums: Floats
    starts: Ints
    spare_order: Nodes
    spare_sums: Floats


class Pressure(NamedTuple):
    """The energy's μ and s [s]."""

    mean: float
    scale: float


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
    ring = GiantTour(order, position, np.zeros(total + 1), starts, np.empty(total, np.int32), np.empty(total))
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
def is_between(i: int, first: int, last: int) -> bool:
    """Return whether position i is in first..last, across the ring's end where last < first."""
    return first <= i <= last if first <= last else (i >= first or i <= last)


@njit(cache=True, nogil=True)
def tour_at(starts: Ints, i: int) -> int:
    """Return which tour of the ring, in its order, position i < N belongs to."""
    k = 0
    while starts[k + 1] <= i:
        k += 1
    return k


@njit(cache=True, nogil=True)
def tour_energy(length: float, pressure: Pressure) -> float:
    """Return s · exp((C − μ) / s) [s] of a tour of cost C."""
    x = (length - pressure.mean) / pressure.scale
    if x > _STEEPEST:
        return pressure.scale * math.exp(_STEEPEST) * (x - _STEEPEST + 1.0)
    return pressure.scale * math.exp(x)


@njit(cache=True, nogil=True)
def energy_of(ring: GiantTour, first: int, last: int, pressure: Pressure) -> float:
    """Return the energy of tours first..last of the ring [s]."""
    sums, starts = ring.sums, ring.starts
    total = 0.0
    for k in range(first, last + 1):
        total += tour_energy(sums[starts[k + 1]] - sums[starts[k]], pressure)
    return total


@njit(cache=True, nogil=True)
def _part(part: int, p: int, q: int, r: int, kind: int) -> tuple[int, int, bool]:
    """Return (first position, last position, whether turned) of the part that comes as number `part` after A."""
    if (part == 1) == (kind & SWAPPED == 0):
        return q + 1, r, kind & TURNED_C != 0
    return p + 1, q, kind & TURNED_B != 0


@njit(cache=True, nogil=True)
def _fly(ring: GiantTour, i: int, j: int, turned: bool, so_far: float, pressure: Pressure) -> tuple[float, float]:
    """Fly positions i..j on a tour that costs `so_far` to there; return (cost of the tour then, energy of those ended).

    All in s.
    """
    sums, starts = ring.sums, ring.starts
    first = tour_at(starts, i)
    if starts[first] < i:
        first += 1
    if starts[first] > j:
        return so_far + sums[j] - sums[i], 0.0
    last = tour_at(starts, j)
    head, tail = sums[starts[first]] - sums[i], sums[j] - sums[starts[last]]
    if turned:
        head, tail = tail, head
    return tail, energy_of(ring, first, last - 1, pressure) + tour_energy(so_far + head, pressure)


@njit(cache=True, nogil=True)
def energy_after(costs: AlikeCosts, ring: GiantTour, p: int, q: int, r: int, kind: int, pressure: Pressure) -> float:
    """Return the energy [s] of the tours that the ring's tours at p to r become by a move."""
    order, sums, starts = ring.order, ring.sums, ring.starts
    u, energy = order[p], 0.0
    so_far = sums[p] - sums[starts[tour_at(starts, p)]]
    for part in range(2):
        i, j, turned = _part(part, p, q, r, kind)
        if i > j:
            continue
        so_far += leg(costs, 0, u, order[j] if turned else order[i])
        u = order[i] if turned else order[j]
        so_far, ended = _fly(ring, i, j, turned, so_far, pressure)
        energy += ended
    end = starts[tour_at(starts, r) + 1]
    so_far += leg(costs, 0, u, order[r + 1]) + sums[end] - sums[r + 1]
    return energy + tour_energy(so_far, pressure)


@njit(cache=True, nogil=True)
def rejoin(costs: AlikeCosts, ring: GiantTour, p: int, q: int, r: int, kind: int) -> None:
    """Make the move that cuts behind positions p ≤ q ≤ r < N."""
    order, position, sums, starts, spare, spare_sums = ring
    u, at, so_far = order[p], 0, sums[p]
    for part in range(2):
        i, j, turned = _part(part, p, q, r, kind)
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
    if starts[tour_at(starts, p) + 1] <= r:
        _find_starts(starts, position)


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
def take_back(costs: AlikeCosts, ring: GiantTour, p: int, q: int, r: int, kind: int) -> None:
    """Undo the move last made: the inverse of one is one of them."""
    if kind & SWAPPED:
        q = p + r - q
        kind = SWAPPED + (TURNED_C if kind & TURNED_B else 0) + (TURNED_B if kind & TURNED_C else 0)
    rejoin(costs, ring, p, q, r, kind)
