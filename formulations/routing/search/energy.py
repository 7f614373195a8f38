"""Energy: what an annealing lowers.

    E = ‖C‖_p + ε · mean_k C_k, in the end E = Σ_k max(0, C_k − cap) + ε · mean_k C_k

The longest tour alone is flat: a large norm sees the others near it as well, and a share ε of the mean lets the search
shorten all of them, which makes room for the long ones to give tasks away. In the end it is a matter of packing: the
tasks must fit into tours below a cap, and what exceeds it in any of them counts alike. p, ε and the cap follow the
temperature (cooling.py).
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from formulations.routing.search.tours import Tours
from instances.arrays import Floats

SHARP = 500
"""p from which the norm would be the maximum, to within what matters: then the excess over the cap counts."""
FIT = 128
"""The p by which tours are compared that are kept, where it is not by what exceeds the best known longest tour."""
TINY = 1e-300
"""Tours that cost nothing are scaled by this [s]."""


class Aim(NamedTuple):
    """What counts at present.

    evenness: the share ε of the mean; p: of the norm; cap [s]: counts from p = SHARP; known [s]: by which fitness is
    measured, the longest of the best tours known or 0.
    """

    evenness: float
    p: int
    cap: float
    known: float = 0.0


class Stakes(NamedTuple):
    """What the other tours leave to beat.

    total: their sum [s]; scale: the longest of all [s]; powers: their Σ (C_k / scale)^p, from p = SHARP their
    Σ max(0, C_k − cap) [s]; m: the number of all.
    """

    total: float
    scale: float
    powers: float
    m: int
    aim: Aim


@njit(cache=True, nogil=True)
def power(x: float, p: int) -> float:
    """Return x^p for a whole p ≥ 1 by repeated squaring."""
    result = 1.0
    while p:
        if p & 1:
            result *= x
        x *= x
        p >>= 1
    return result


@njit(cache=True, nogil=True)
def norm(lengths: Floats, p: int) -> float:
    """Return ‖C‖_p [s] of lengths (m,) [s]."""
    longest = lengths.max()
    if longest <= 0.0:
        return 0.0
    total = 0.0
    for length in lengths:
        total += power(length / longest, p)
    return longest * total ** (1.0 / p)


@njit(cache=True, nogil=True)
def energy(lengths: Floats, aim: Aim) -> float:
    """Return ‖C‖_p + ε · mean_k C_k [s], from p = SHARP Σ_k max(0, C_k − cap) + ε · mean_k C_k; lengths (m,) [s]."""
    total = aim.evenness * lengths.mean()
    if aim.p < SHARP:
        return total + norm(lengths, aim.p)
    for length in lengths:
        total += max(0.0, length - aim.cap)
    return total


@njit(cache=True, nogil=True)
def fitness(lengths: Floats, known: float) -> float:
    """Return Σ_k max(0, C_k − known) [s], below 0 by how much all beat known [s], the longest of the best tours known.

    Of two with the same longest tour that with fewer long ones is fitter. Many tours nearly as long as the best known
    are no fault, as they are in the norm: tight packings consist of them. Without `known`, 0, return ‖C‖_FIT [s].
    """
    if known <= 0.0:
        return norm(lengths, FIT)
    total = 0.0
    for length in lengths:
        total += max(0.0, length - known)
    return total if total > 0.0 else lengths.max() - known


@njit(cache=True, nogil=True)
def stakes_without(tours: Tours, k_a: int, k_b: int, aim: Aim) -> Stakes:
    """Return the Stakes left by all tours but k_a and k_b."""
    scale, total, powers = max(tours.cost.max(), TINY), 0.0, 0.0
    for k in range(tours.cost.size):
        if k != k_a and k != k_b:
            total += tours.cost[k]
            powers += max(0.0, tours.cost[k] - aim.cap) if aim.p >= SHARP else power(tours.cost[k] / scale, aim.p)
    return Stakes(total, scale, powers, tours.cost.size, aim)


@njit(cache=True, nogil=True)
def energy_with(stakes: Stakes, cost_a: float, cost_b: float) -> float:
    """Return the energy [s] where the two tours at work cost cost_a and cost_b."""
    p, scale, cap = stakes.aim.p, stakes.scale, stakes.aim.cap
    even = stakes.aim.evenness * (stakes.total + cost_a + cost_b) / stakes.m
    if p >= SHARP:
        return stakes.powers + max(0.0, cost_a - cap) + max(0.0, cost_b - cap) + even
    powers = stakes.powers + power(cost_a / scale, p) + power(cost_b / scale, p)
    return scale * powers ** (1.0 / p) + even
