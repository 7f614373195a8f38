"""How large and how fine the numbers of a mission may be, so that what is computed from them stays finite.

Anything beyond is a damaged file or another unit: the bounds are far outside of what flies. Sums, products and
squares of numbers within them are far from the ends of float64, and positions within them are told apart by it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.errors import InputError, shown

FARTHEST = 1e9
"""Greatest coordinate [m] of a place."""
FINEST = 1e-6
"""Least distance [m] that counts: between the nodes of a grid, the size of an eddy."""
LARGEST = 1e12
"""Greatest quantity of any other unit: wind speeds, circulations, elevations, signals."""
LEAST = 1e-9
"""Least quantity where it must be positive: airspeeds, lengths."""


def positive(value: Any, label: str) -> float:
    """Return `value` as a float from LEAST to LARGEST; InputError names `label`."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value > 0:
        raise InputError(f"{label} must be a positive number, got {shown(value)}")
    if not LEAST <= value <= LARGEST:
        raise InputError(f"{label} must be a positive number from {LEAST:g} to {LARGEST:g}, got {shown(value)}")
    return float(value)


def check_positions(points: ArrayLike, label: str) -> None:
    """Raise InputError where a coordinate of `points` is not finite or beyond FARTHEST [m]."""
    p: Floats = np.asarray(points, dtype=np.float64)
    bad = p[~(np.abs(p) <= FARTHEST)]  # NaN too
    if len(bad):
        raise InputError(f"{label} must be finite and at most {FARTHEST:g} m from the origin, got {bad[0]:g}")
