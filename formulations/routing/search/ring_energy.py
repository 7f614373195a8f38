"""Energy of tours from one site, and what a move that cuts several of them takes off it.

    E = Σ_k s · exp((C_k − μ) / s),

which near the mean tour μ is the total, and rises the faster the more a tour exceeds it: s [s] is how much is a lot.
A move cuts two or three tours and joins their ends. All between them cost the same both ways, so that prefix sums and
the energies of single tours say what it is worth without a walk; most moves make a tour that alone costs more than all
that it cuts, and no more is asked.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from formulations.routing.search.giant_tour import GiantTour
from formulations.routing.search.tour_blocks import TourBlocks, part_of
from instances.arrays import Floats
from instances.kernels import njit

_STEEPEST = 30.0
"""Exponents above it are continued by the tangent, so that no energy overflows."""
_MANY = math.log(3.0)
"""So many s longer a tour costs as much as three: as many as a move cuts, at most."""
_ROUNDING = 1e-9
"""Share of the energy of the tours cut, below which a gain counts as rounding: descents end, however steep it is."""

ThreeLegs = tuple[float, float, float]
"""What three legs cost [s]."""


class Pressure(NamedTuple):
    """The energy's μ and s [s]."""

    mean: float
    scale: float


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


@njit(cache=True, nogil=True, inline="always")  # its arguments are some hundred words: handing them over took as long
def gain_across(
    blocks: TourBlocks,
    energies: Floats,
    p: int,
    q: int,
    r: int,
    kind: int,
    legs: ThreeLegs,
    least: float,
    pressure: Pressure,
) -> float:
    """Return what a move that cuts several tours takes off the energy [s], or `least` where that is no more.

    energies (m,): of the tours [s]; legs: what the legs put in cost, in their order [s]; a 2-opt move has two.
    """
    sums, ends, bits = blocks.sums, blocks.ends, blocks.bits
    a, b, c = p >> bits, q >> bits, r >> bits
    before, longest = energies[a] + energies[c], max(sums[ends[a]], sums[ends[c]])
    if b != a and b != c:
        before += energies[b]
        longest = max(longest, sums[ends[b]])
    if longest < pressure.mean + _STEEPEST * pressure.scale:
        longest += _MANY * pressure.scale
    else:
        longest = math.inf
    one = two = -1.0
    so_far = sums[p] + legs[0]
    for part in range(2):
        i, j, turned, first, last = part_of(blocks, part, p, q, r, kind)
        if i > j:
            continue
        if first == last:
            so_far += sums[j] - sums[i]
        else:
            head, tail = sums[ends[first]] - sums[i], sums[j]
            if turned:
                head, tail = tail, head
            if so_far + head > longest:
                return least
            one, two = so_far + head, one
            so_far = tail
        so_far += legs[1 + part]
    so_far += sums[ends[c]] - sums[r + 1]
    if so_far > longest:
        return least
    top = max(one, two, so_far)
    left = before - tour_energy(top, pressure)
    if left <= least:
        return least
    if two < 0.0:
        left -= tour_energy(one + so_far - top, pressure)
    else:
        low = min(one, two, so_far)
        left -= tour_energy(low, pressure) + tour_energy(one + two + so_far - top - low, pressure)
    return left if left > max(least, _ROUNDING * before) else least


@njit(cache=True, nogil=True)
def gain_between(
    blocks: TourBlocks, energies: Floats, a: int, b: int, less: float, saved: float, pressure: Pressure
) -> float:
    """Return what it takes off the energy [s] that tour a costs `less` [s], and both tours together `saved` [s] less.

    0 where rounding could be all of it.
    """
    before = energies[a] + energies[b]
    one, two = blocks.sums[blocks.ends[a]] - less, blocks.sums[blocks.ends[b]] + less - saved
    gain = before - tour_energy(one, pressure) - tour_energy(two, pressure)
    return gain if gain > _ROUNDING * before else 0.0
