"""How a field about a predicted signal varies where the prediction has obstacles in the way.

A prediction errs little where the line of sight is clear, and more the more the obstacles take away; what lies behind
one edge tells little of what lies behind another, or of open ground, however near. With o(x) ≥ 0 [dB] the predicted
loss behind obstacles, the field about its mean has the covariance

    k(x, x′) = m(x) m(x′) exp(−|o − o′|/c) k_s(x, x′),   m = a + (1 − a) w,   w = 1 − exp(−o/6),

a product of covariances, k_s being that over space (Rasmussen & Williams 2006, §4.2.4). w is the weight by which
ITU-R P.526 goes from a single edge over to what is behind it (`instances.environment.propagation`). The two parameters
are c > 0 [dB] and 0 < a ≤ 1, the standard deviation in sight over that deep in shadow: where the field varies in sight
as much, as with shadowing that no terrain explains, a is 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats

FULL = 6.0
"""Loss [dB] over which m goes from a to 1, but for 1/e of the way."""


def weight(loss: Floats) -> Floats:
    """Return w of losses o [dB]."""
    seen: Floats = -np.expm1(-loss / FULL)
    return seen


@dataclass(frozen=True)
class Shadows:
    """The parameters. contrast : c [dB]. in_sight : a."""

    contrast: float
    in_sight: float

    def __post_init__(self) -> None:
        if not (self.contrast > 0 and 0 < self.in_sight <= 1):
            raise ValueError(f"contrast must be positive and in_sight from 0 to 1, got {self}")

    def relative_sd(self, loss: Floats) -> Floats:
        """Return m of losses o [dB]."""
        return self.in_sight + (1.0 - self.in_sight) * weight(loss)

    def share(self, loss: Floats, other: Floats) -> Floats:
        """Return what k_s is multiplied by between losses (p,) and (q,) [dB], shape (p, q)."""
        both: Floats = np.exp(-np.abs(np.subtract.outer(loss, other)) / self.contrast)
        both *= np.multiply.outer(self.relative_sd(loss), self.relative_sd(other))
        return both

    def sd_slope(self, loss: Floats) -> Floats:
        """Return ∂ log m/∂ log a of losses o [dB]."""
        slope: Floats = self.in_sight * (1.0 - weight(loss)) / self.relative_sd(loss)
        return slope
