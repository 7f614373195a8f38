"""What a map of the prior standard deviation changes in the derivatives of a covariance: the product rule.

With m(x) the relative prior standard deviation, c'(x, y) = m(x) m(y) c(x, y), so that by the first argument, and twice,

    ∂_d c'    = m(y) (∂_d m(x) c + m(x) ∂_d c)
    ∂_d∂'_e c' = ∂_d m(x) ∂_e m(y) c + ∂_d m(x) m(y) ∂'_e c + m(x) ∂_e m(y) ∂_d c + m(x) m(y) ∂_d∂'_e c
    ∂_d∂_e c' = m(y) (∂_d∂_e m(x) c + ∂_d m(x) ∂_e c + ∂_e m(x) ∂_d c + m(x) ∂_d∂_e c),

∂' by the second argument; ∂_d∂_d m = 0 within a cell of a bilinear map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats
from instances.environment.value_map import ValueMap


@dataclass(frozen=True, eq=False)
class PriorSlopes:
    """m and its derivatives at n points, in units of the length scales: shapes (n,), (2, n) and (n,)."""

    m: Floats
    first: Floats
    twist: Floats

    @classmethod
    def at(cls, relative_sd: ValueMap, points: Floats, scales: Floats) -> PriorSlopes:
        """Return those of a map at `points` (n, 2) [m]."""
        slope, twist = relative_sd.slope(points)
        return cls(relative_sd(points), (slope * scales).T, twist * scales.prod())

    def matrix(self, c: Floats) -> Floats:
        """Return c', shape (n, n)."""
        return np.asarray(self.m[:, None] * c * self.m)

    def slopes(self, c: Floats, slopes: list[Floats]) -> list[Floats]:
        """Return ∂_x c' and ∂_y c' from c and its slopes."""
        parts = zip(self.first, slopes, strict=True)
        return [np.asarray((first[:, None] * c + self.m[:, None] * slope) * self.m) for first, slope in parts]

    def mixed(self, d: int, e: int, c: Floats, slopes: list[Floats], mixed: Floats) -> Floats:
        """Return ∂_d∂'_e c' from c, its slopes and ∂_d∂'_e c."""
        by_first = self.first[d][:, None] * c + self.m[:, None] * slopes[d]
        by_second = self.first[d][:, None] * slopes[e].T + self.m[:, None] * mixed
        return np.asarray(by_first * self.first[e] + by_second * self.m)

    def twice(self, d: int, e: int, c: Floats, slopes: list[Floats], twice: Floats) -> Floats:
        """Return ∂_d∂_e c' from c, its slopes and ∂_d∂_e c."""
        bend = (d != e) * self.twist
        inner = bend[:, None] * c + self.first[d][:, None] * slopes[e] + self.first[e][:, None] * slopes[d]
        return np.asarray((inner + self.m[:, None] * twice) * self.m)
