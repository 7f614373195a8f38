"""Energy: what an annealing lowers.

    E = ‖C‖_p + ε · mean_k C_k

The longest tour alone is flat: a large norm sees the others near it as well, and a share ε of the mean lets the search
shorten all of them, which makes room for the long ones to give tasks away. p and ε follow the temperature (cooling.py).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from formulations.routing.search.tours import Tours

SHARP = 500
"""p from which the norm is the maximum, to within what matters."""
FIT = 128
"""The p by which tours are compared that are kept: of two with the same longest tour, that with fewer long ones."""
TINY = 1e-300
"""Tours that cost nothing are scaled by this [s]."""


class Stakes(NamedTuple):
    """What the other tours leave to beat.

    total: their sum [s]; scale: the longest of all [s]; powers: their Σ (C_k / scale)^p, their longest [s] from
    p = SHARP; m: the number of all; evenness: the share ε.
    """

    total: float
    scale: float
    powers: float
    m: int
    evenness: float
    p: int


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
def energy(lengths: NDArray[np.float64], evenness: float, p: int) -> float:
    """Return ‖C‖_p + evenness · mean_k C_k [s]; the norm is max_k C_k from p = SHARP."""
    longest = lengths.max()
    if p >= SHARP or longest <= 0.0:
        return longest + evenness * lengths.mean()
    total = 0.0
    for length in lengths:
        total += power(length / longest, p)
    return longest * total ** (1.0 / p) + evenness * lengths.mean()


@njit(cache=True, nogil=True)
def fitness(lengths: NDArray[np.float64]) -> float:
    """Return ‖C‖_FIT [s]: where two crowds of tours are too long, it says that one of them is not any more."""
    return energy(lengths, 0.0, FIT)


@njit(cache=True, nogil=True)
def stakes_without(tours: Tours, k_a: int, k_b: int, evenness: float, p: int) -> Stakes:
    """Return the Stakes left by all tours but k_a and k_b."""
    scale, total, powers = max(tours.cost.max(), TINY), 0.0, 0.0
    for k in range(tours.cost.size):
        if k != k_a and k != k_b:
            total += tours.cost[k]
            powers = max(powers, tours.cost[k]) if p >= SHARP else powers + power(tours.cost[k] / scale, p)
    return Stakes(total, scale, powers, tours.cost.size, evenness, p)


@njit(cache=True, nogil=True)
def energy_with(stakes: Stakes, cost_a: float, cost_b: float) -> float:
    """Return ‖C‖_p + ε · mean C [s] where the two tours at work cost cost_a and cost_b."""
    mean = (stakes.total + cost_a + cost_b) / stakes.m
    if stakes.p >= SHARP:
        return max(stakes.powers, cost_a, cost_b) + stakes.evenness * mean
    p, scale = stakes.p, stakes.scale
    powers = stakes.powers + power(cost_a / scale, p) + power(cost_b / scale, p)
    return scale * powers ** (1.0 / p) + stakes.evenness * mean
