"""Energy: what an annealing lowers.

    E = measure(C) + ε · mean_k C_k,   measure(C) = ‖C‖_p, in the end Σ_k max(0, C_k − cap)

The longest tour alone is flat: a large norm sees the others near it as well, and a share ε of the mean lets the search
shorten all of them, which makes room for the long ones to give tasks away. In the end it is a matter of packing: the
tasks must fit into tours below a cap, and what exceeds it in any of them counts alike. The measure and ε follow the
temperature (schedule.py). The same measures tell the fitness of individuals and guide recreations (recreate.py).
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from formulations.routing.search.tours import Tours, longest
from instances.arrays import Floats
from instances.kernels import njit

TINY = 1e-300
"""Tours that cost nothing are scaled by this [s]."""
TIE = 1e-7
"""Share of the mean tour in fitness: small, it only tells ties apart."""


class MeasureKind(IntEnum):
    """How tours count together: by ‖C‖_p, or by what exceeds a cap, Σ_k max(0, C_k − cap)."""

    P_NORM = 0
    EXCESS = 1


class Measure(NamedTuple):
    """Made by p_norm and excess.

    kind: a MeasureKind's value, as numba is slow to tell the type of an enum at each call; p: of a norm; cap: of an
    excess [s], 0 for a norm.
    """

    kind: int
    p: int
    cap: float


def p_norm(p: int) -> Measure:
    """Return the measure ‖C‖_p, p ≥ 1."""
    return Measure(MeasureKind.P_NORM.value, p, 0.0)


def excess(cap: float) -> Measure:
    """Return the measure Σ_k max(0, C_k − cap)."""
    return Measure(MeasureKind.EXCESS.value, 1, cap)


class Objective(NamedTuple):
    """The energy's measure and mean_weight, the share ε of the mean tour."""

    measure: Measure
    mean_weight: float


class PartialEnergy(NamedTuple):
    """The energy's sums over all tours but the two that a move changes.

    total: their Σ C_k [s]; scale: the longest of all [s]; measured: their Σ (C_k / scale)^p of a norm, their
    Σ max(0, C_k − cap) [s] of an excess; m: the number of all.
    """

    total: float
    scale: float
    measured: float
    m: int
    objective: Objective


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
    scale = longest(lengths)
    if scale <= 0.0:
        return 0.0
    total = 0.0
    for length in lengths:
        total += power(length / scale, p)
    return scale * total ** (1.0 / p)


@njit(cache=True, nogil=True)
def energy(lengths: Floats, objective: Objective) -> float:
    """Return the energy [s] of lengths (m,) [s]."""
    measure, total = objective.measure, 0.0
    for length in lengths:
        total += length
    total = objective.mean_weight * (total / lengths.size)
    if measure.kind == MeasureKind.P_NORM:
        return total + norm(lengths, measure.p)
    for length in lengths:
        total += max(0.0, length - measure.cap)
    return total


@njit(cache=True, nogil=True)
def fitness(lengths: Floats, measure: Measure) -> float:
    """Return the measure of lengths (m,) [s], never below max_k C_k − cap; an excess of 0 is replaced by that.

    Of two with the same longest tour that with fewer long ones is fitter. By the excess over the longest tour of the
    incumbent many tours nearly as long are no fault, as they are in the norm: tight packings consist of them.
    Of equals that with the smaller total is fitter: there is room in it.
    """
    total, excess = 0.0, 0.0
    for length in lengths:
        total += length
        excess += max(0.0, length - measure.cap)
    tie = TIE * total / lengths.size
    if measure.kind == MeasureKind.P_NORM:
        return norm(lengths, measure.p) + tie
    return (excess if excess > 0.0 else longest(lengths) - measure.cap) + tie


@njit(cache=True, nogil=True)
def energy_without(tours: Tours, k_a: int, k_b: int, objective: Objective) -> PartialEnergy:
    """Return the PartialEnergy of all tours but k_a and k_b."""
    measure = objective.measure
    scale, total, measured = max(longest(tours.cost), TINY), 0.0, 0.0
    for k in range(tours.cost.size):
        if k != k_a and k != k_b:
            total += tours.cost[k]
            if measure.kind == MeasureKind.EXCESS:
                measured += max(0.0, tours.cost[k] - measure.cap)
            else:
                measured += power(tours.cost[k] / scale, measure.p)
    return PartialEnergy(total, scale, measured, tours.cost.size, objective)


@njit(cache=True, nogil=True)
def energy_with(partial: PartialEnergy, cost_a: float, cost_b: float) -> float:
    """Return the energy [s] where the two tours that a move changes cost cost_a and cost_b."""
    measure, scale = partial.objective.measure, partial.scale
    even = partial.objective.mean_weight * (partial.total + cost_a + cost_b) / partial.m
    if measure.kind == MeasureKind.EXCESS:
        return partial.measured + max(0.0, cost_a - measure.cap) + max(0.0, cost_b - measure.cap) + even
    powers = partial.measured + power(cost_a / scale, measure.p) + power(cost_b / scale, measure.p)
    return scale * powers ** (1.0 / measure.p) + even
