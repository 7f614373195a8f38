"""Energy of the tours on a giant tour, and what a move that cuts several of them takes off it.

    E = Σ_k s · exp((C_k − μ) / s),

which near the mean tour μ is the total, and rises the faster the more a tour exceeds it: s [s] is how much is a lot.
A move cuts two or three tours and joins their ends. All between them cost the same both ways, so that prefix sums and
the energies of single tours say what it is worth without a walk; most moves make a tour so long that no more is asked.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from formulations.routing.search.costs import AlikeCosts, leg
from formulations.routing.search.giant_tour import GiantTour, part_of
from instances.arrays import Floats
from instances.kernels import njit

_STEEPEST = 30.0
"""Exponents above it are continued by the tangent, so that no energy overflows."""
_CUT = 3
"""Tours that a move cuts, at most."""
_ROUNDING = 1e-9
"""Share of the energy of the tours cut, below which a gain counts as rounding: descents end, however steep it is."""


class Pressure(NamedTuple):
    """The energy's μ and s [s]."""

    mean: float
    scale: float


class TourEnergies(NamedTuple):
    """of (m,): energy of each tour, in the ring's order [s]; longest (1,): a tour [s] longer than any move may make."""

    of: Floats
    longest: Floats


@njit(cache=True, nogil=True)
def tour_energy(length: float, pressure: Pressure) -> float:
    """Return s · exp((C − μ) / s) [s] of a tour of cost C."""
    x = (length - pressure.mean) / pressure.scale
    if x > _STEEPEST:
        return pressure.scale * math.exp(_STEEPEST) * (x - _STEEPEST + 1.0)
    return pressure.scale * math.exp(x)


@njit(cache=True, nogil=True)
def energy_of(ring: GiantTour, pressure: Pressure) -> float:
    """Return the energy of the ring's tours [s]."""
    sums, starts = ring.sums, ring.starts
    total = 0.0
    for k in range(starts.size - 1):
        total += tour_energy(sums[starts[k + 1]] - sums[starts[k]], pressure)
    return total


@njit(cache=True, nogil=True)
def price(ring: GiantTour, energies: TourEnergies, first: int, last: int, pressure: Pressure) -> None:
    """Write the energies of tours first..last, and how long none may become: as costly as three of the costliest."""
    sums, starts, of = ring.sums, ring.starts, energies.of
    for k in range(first, last + 1):
        of[k] = tour_energy(sums[starts[k + 1]] - sums[starts[k]], pressure)
    top = of[0]
    for k in range(1, of.size):
        top = max(top, of[k])
    x = math.log(_CUT * top / pressure.scale)
    energies.longest[0] = pressure.mean + pressure.scale * x if x < _STEEPEST else math.inf


@njit(cache=True, nogil=True)
def gain_across(
    costs: AlikeCosts,
    ring: GiantTour,
    energies: TourEnergies,
    p: int,
    q: int,
    r: int,
    kind: int,
    least: float,
    pressure: Pressure,
) -> float:
    """Return what a move that cuts several tours takes off the energy [s], or `least` where that is no more."""
    order, sums, starts, of, longest = ring.order, ring.sums, ring.starts, energies.of, energies.longest[0]
    a, b, c = ring.rank[p], ring.rank[q], ring.rank[r]
    before = of[a] + of[c]
    if b != a and b != c:
        before += of[b]
    left = before
    u, so_far = order[p], sums[p] - sums[starts[a]]
    for part in range(2):
        i, j, turned = part_of(part, p, q, r, kind)
        if i > j:
            continue
        so_far += leg(costs, 0, u, order[j] if turned else order[i])
        u = order[i] if turned else order[j]
        first, last = (a, b) if i == p + 1 else (b, c)
        if first == last:
            so_far += sums[j] - sums[i]
            continue
        head, tail = sums[starts[first + 1]] - sums[i], sums[j] - sums[starts[last]]
        if turned:
            head, tail = tail, head
        if so_far + head > longest:
            return least
        left -= tour_energy(so_far + head, pressure)
        so_far = tail
    so_far += leg(costs, 0, u, order[r + 1]) + sums[starts[c + 1]] - sums[r + 1]
    if left <= least or so_far > longest:
        return least
    left -= tour_energy(so_far, pressure)
    return left if left > max(least, _ROUNDING * before) else least
