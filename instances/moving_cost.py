"""What flying a path costs in a wind: the paper's energy at a constant ground speed, or time at a constant airspeed.

**energy** (paper, eq. moving_cost). The energy a UAV needs for a path σ: [0, τ] → ℝ² at constant *ground* speed v0 in a
wind w is, in seconds of flight in calm air,

    C(σ) = τ − (1/v0²) ∫₀^τ w(σ(t))·dσ(t),   τ = length/v0.

It is no time: the UAV arrives after τ whatever the wind. **time** is what passes at constant airspeed va, by the wind
triangle (`wind_triangle`). In calm air both are length/speed.

This is the one place where the equation stands. Planners, closed forms and the independent check of paths (`paths`)
all name it; what they must not share is how τ and the integral are found. It stands in this room because instance
files name costs by it, and files are read without any planner.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TypeVar

import numpy as np

from instances.arrays import Floats, Ints
from instances.environment.wind import WindField
from instances.wind_triangle import TOLERANCE, flight_times

ROUGH = 1e-5
"""Tolerance of times while paths are searched; the paths that are returned are costed anew."""

Number = TypeVar("Number", float, Floats)


class CostKind(StrEnum):
    """What a leg's cost is."""

    ENERGY = "energy"
    TIME = "time"

    @property
    def speed_key(self) -> str:
        """The scenario key of the speed that is held constant."""
        return {CostKind.ENERGY: "ground_speed", CostKind.TIME: "airspeed"}[self]

    @property
    def speed_name(self) -> str:
        """The speed that is held constant, in words."""
        return self.speed_key.replace("_", " ")

    def described(self, speed: float) -> str:
        """Return what a cost in seconds is at `speed` [m/s], in words."""
        match self:
            case CostKind.ENERGY:
                return f"drag energy at a constant ground speed of {speed:g} m/s, in seconds of flight in calm air"
            case CostKind.TIME:
                return f"flight time at a constant airspeed of {speed:g} m/s"


@dataclass(frozen=True, eq=False)
class CostMeasure:
    """The cost of paths in a wind: its kind, and the `speed` [m/s] that is held constant.

    tolerance : to which times are integrated; energies are exact.
    """

    kind: CostKind
    wind: WindField
    speed: float
    tolerance: float = TOLERANCE

    @property
    def rough(self) -> CostMeasure:
        """The same to the tolerance that a search needs."""
        return replace(self, tolerance=ROUGH)

    def segments(self, a: Floats, b: Floats) -> Floats:
        """Return the cost [s] of the straight segments `a` → `b`, each (k, 2) [m], shape (k,).

        Raises InputError, for times, where the wind is as strong as the airspeed.
        """
        if self.kind is CostKind.TIME:
            return flight_times(a, b, self.wind, self.speed, self.tolerance)
        return moving_cost(np.hypot(*(b - a).T) / self.speed, self.wind.line_integral(a, b), self.speed)

    def polylines(self, points: Floats, offsets: Ints) -> Floats:
        """Return the cost [s] of polylines held end to end, shape (len(offsets) − 1,); raises as `segments`.

        Polyline k is ``points[offsets[k]:offsets[k + 1]]`` [m].
        """
        if self.kind is CostKind.ENERGY:
            return moving_costs(points, offsets, self.wind, self.speed)
        a, b, owner = segments(points, offsets)
        return np.bincount(owner, self.segments(a, b), minlength=len(offsets) - 1).astype(np.float64)


def moving_cost(tau: Number, wind_integral: Number, v0: float) -> Number:
    """Return C(σ) [s] from the duration τ [s] of a path, ∫ w·dσ along it [m²/s] and the ground speed v0 [m/s]."""
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
