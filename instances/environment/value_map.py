"""ValueMap: a number of at least 0 for every place of a region: how much it counts, or how unsure of it one is.

Bilinear between the nodes of a grid and constant outside, so that its slope is known where planning climbs along it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.radio import RadioMap
from instances.errors import InputError


@dataclass(frozen=True, eq=False)
class ValueMap(RadioMap):
    """Values of at least 0, not all 0, at the nodes of a rectangular grid; x, y and values as a RadioMap's.

    Raises
    ------
    InputError
        Where shapes do not fit, a number is not finite or negative, or all are 0.
    """

    unit: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.values < 0).any():
            j, i = np.argwhere(self.values < 0)[0]
            raise InputError(f"value at ({self.x[i]:g}, {self.y[j]:g}) m is negative: {self.values[j, i]:g}")
        if not self.values.any():
            raise InputError("all values are 0")

    @property
    def greatest(self) -> float:
        """The greatest value, which no place passes."""
        return float(self.values.max())

    def relative(self) -> ValueMap:
        """Return the map of values over `greatest`, from 0 to 1."""
        return replace(self, values=self.values / self.greatest, unit="")

    def slope(self, points: ArrayLike) -> tuple[Floats, Floats]:
        """Return the derivatives along x and y at `points` (k, 2) [m], shape (k, 2), and ∂²/∂x∂y, shape (k,).

        On the line between two cells they are those of the cell beyond it; outside the grid 0 across its border.
        """
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        low, steps = np.array([self.x[0], self.y[0]]), np.array([self.x[1] - self.x[0], self.y[1] - self.y[0]])
        most = np.array(self.values.shape[::-1]) - 1
        at = np.clip((p - low) / steps, 0, most)
        i, j = cell = np.minimum(at.astype(int), most - 1).T
        s, t = at.T - cell
        south_west, south_east = self.values[j, i], self.values[j, i + 1]
        north_west, north_east = self.values[j + 1, i], self.values[j + 1, i + 1]
        along_x = (1 - t) * (south_east - south_west) + t * (north_east - north_west)
        along_y = (1 - s) * (north_west - south_west) + s * (north_east - south_east)
        inside = (p >= low) & (p <= low + most * steps)
        twist = (north_east - north_west - south_east + south_west) / steps.prod() * inside.all(axis=1)
        return np.column_stack([along_x, along_y]) / steps * inside, twist
