"""C(σ), the paper's moving cost of a path (eq. moving_cost).

The energy a UAV needs for a path σ: [0, τ] → ℝ² at constant speed v0 in a wind w is, in seconds of flight in calm air,

    C(σ) = τ − (1/v0²) ∫₀^τ w(σ(t))·dσ(t),   τ = length/v0.

This is the one place where the equation stands. Planners, closed forms and the independent check of paths (`paths`)
all name it; what they must not share is how τ and the integral are found. It stands in this room because instance
files name costs by it, and files are read without any planner.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from instances.arrays import Floats, Ints
from instances.environment.wind import WindField

Number = TypeVar("Number", float, Floats)


def moving_cost(tau: Number, wind_integral: Number, v0: float) -> Number:
    """Return C(σ) [s] from the duration τ [s] of a path, ∫ w·dσ along it [m²/s] and the speed v0 [m/s]."""
    return tau - wind_integral / v0**2


def moving_costs(points: Floats, offsets: Ints, wind: WindField, v0: float) -> Floats:
    """Return C(σ) [s] of polylines held end to end, shape (len(offsets) − 1,), by the wind's exact line integrals.

    Polyline k is ``points[offsets[k]:offsets[k + 1]]`` [m].
    """
    a, b, owner = segments(points, offsets)
    lengths, integrals = (
        np.bincount(owner, part, minlength=len(offsets) - 1).astype(np.float64)
        for part in (np.hypot(*(b - a).T), wind.line_integral(a, b))
    )
    return moving_cost(lengths / v0, integrals, v0)


def segments(points: Floats, offsets: Ints) -> tuple[Floats, Floats, Ints]:
    """Return the starts and ends of all segments (k, 2) [m] of polylines held end to end, and whose each is (k,)."""
    owner = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    inner = np.flatnonzero(owner[:-1] == owner[1:])
    return points[inner], points[inner + 1], owner[inner]
