"""The non-isotropic squared-exponential covariance (paper, eq. cov), shared by planning and mapping.

k(x_p, x_q) = σ_f² exp(−½ (x_p − x_q)ᵀ Σ_l⁻² (x_p − x_q)),   Σ_l = diag(l_x, l_y)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from instances import InputError
from instances.arrays import Floats

SMALLEST, LARGEST = 1e-120, 1e120
"""Beyond these the square of a parameter, or of a distance over it, is 0 or infinite in float64."""


@dataclass(frozen=True)
class SquaredExponential:
    """Covariance of a smooth field over the plane.

    signal_sd : σ_f > 0, in the field's unit.
    length_scales : (l_x, l_y) > 0 [m].
    """

    signal_sd: float = 30.0
    length_scales: tuple[float, float] = (4000.0, 4000.0)

    def __post_init__(self) -> None:
        if not SMALLEST <= self.signal_sd <= LARGEST:
            raise InputError(f"signal_sd must be positive, from {SMALLEST:g} to {LARGEST:g}, got {self.signal_sd}")
        scales = tuple(float(scale) for scale in self.length_scales)
        if len(scales) != 2 or not all(SMALLEST <= scale <= LARGEST for scale in scales):
            raise InputError(
                f"length_scales must be two positive lengths [m], from {SMALLEST:g} to {LARGEST:g}, "
                f"got {self.length_scales}"
            )
        object.__setattr__(self, "length_scales", scales)
        object.__setattr__(self, "signal_sd", float(self.signal_sd))

    def __call__(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return k(a_i, b_j) for points `a` (p, 2) and `b` (q, 2) [m], shape (p, q)."""
        scales = np.asarray(self.length_scales)
        p = np.asarray(a, dtype=float).reshape(-1, 2) / scales
        q = np.asarray(b, dtype=float).reshape(-1, 2) / scales
        # difference by difference, not the expanded square: coincident points give exactly σ_f²
        exponent: Floats = np.subtract.outer(p[:, 0], q[:, 0]) ** 2
        exponent += np.subtract.outer(p[:, 1], q[:, 1]) ** 2
        exponent *= -0.5
        np.exp(exponent, out=exponent)
        exponent *= self.signal_sd**2
        return exponent
