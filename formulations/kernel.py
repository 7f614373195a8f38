"""Covariances of a field over the plane, all non-isotropic (paper, eq. cov) and functions of one distance r.

    k(x_p, x_q) = σ_f² ρ(r),   r² = (x_p − x_q)ᵀ Σ_l⁻² (x_p − x_q),   Σ_l = diag(l_x, l_y)

ρ is exp(−½ r²) for the squared exponential, the paper's, which planning uses throughout: its derivatives and bounds are
those of a smooth field. Maps of real ground and of radio signals are rougher: Matérn's ρ of smoothness ν = ½, 3/2 and
5/2 (Rasmussen & Williams 2006, eqs. 4.16–4.18). Where ν = ½ only σ_f²/l is told apart by data, not σ_f and l.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from instances import InputError
from instances.arrays import Floats

SMALLEST, LARGEST = 1e-120, 1e120
"""Beyond these the square of a parameter, or of a distance over it, is 0 or infinite in float64."""
_3, _5 = math.sqrt(3.0), math.sqrt(5.0)


@dataclass(frozen=True)
class Kernel(ABC):
    """Covariance of a field over the plane.

    signal_sd : σ_f > 0, in the field's unit.
    length_scales : (l_x, l_y) > 0 [m].
    """

    name: ClassVar[str]
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

    @staticmethod
    @abstractmethod
    def correlation(squares: Floats) -> Floats:
        """Return ρ at the squared distances r², overwriting them where that helps."""

    @staticmethod
    @abstractmethod
    def steepness(squares: Floats) -> Floats:
        """Return −ρ′(r)/r at the squared distances r², so that ∂ρ/∂log l_d = steepness · (Δ_d/l_d)²."""

    def __call__(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return k(a_i, b_j) for points `a` (p, 2) and `b` (q, 2) [m], shape (p, q)."""
        scales = np.asarray(self.length_scales)
        p = np.asarray(a, dtype=float).reshape(-1, 2) / scales
        q = np.asarray(b, dtype=float).reshape(-1, 2) / scales
        # difference by difference, not the expanded square: coincident points give exactly σ_f²
        squares: Floats = np.subtract.outer(p[:, 0], q[:, 0]) ** 2
        squares += np.subtract.outer(p[:, 1], q[:, 1]) ** 2
        covariance = self.correlation(squares)
        covariance *= self.signal_sd**2
        return covariance


class SquaredExponential(Kernel):
    """Covariance of a smooth field: ρ = exp(−½ r²) (paper, eq. cov)."""

    name = "se"

    @staticmethod
    def correlation(squares: Floats) -> Floats:
        """Return exp(−½ r²), in place."""
        squares *= -0.5
        return np.exp(squares, out=squares)

    @staticmethod
    def steepness(squares: Floats) -> Floats:
        """Return exp(−½ r²)."""
        steep: Floats = np.exp(-0.5 * squares)
        return steep


class Matern12(Kernel):
    """Covariance of a continuous field without slopes: ρ = exp(−r)."""

    name = "matern12"

    @staticmethod
    def correlation(squares: Floats) -> Floats:
        """Return exp(−r)."""
        rho: Floats = np.exp(-np.sqrt(squares))
        return rho

    @staticmethod
    def steepness(squares: Floats) -> Floats:
        """Return exp(−r)/r, and 0 at r = 0, where it meets Δ = 0 only."""
        r = np.sqrt(squares)
        return np.divide(np.exp(-r), r, out=np.zeros_like(r), where=r > 0)


class Matern32(Kernel):
    """Covariance of a field with slopes: ρ = (1 + √3 r) exp(−√3 r)."""

    name = "matern32"

    @staticmethod
    def correlation(squares: Floats) -> Floats:
        """Return (1 + √3 r) exp(−√3 r)."""
        r = _3 * np.sqrt(squares)
        rho: Floats = (1.0 + r) * np.exp(-r)
        return rho

    @staticmethod
    def steepness(squares: Floats) -> Floats:
        """Return 3 exp(−√3 r)."""
        steep: Floats = 3.0 * np.exp(-_3 * np.sqrt(squares))
        return steep


class Matern52(Kernel):
    """Covariance of a field with slopes and curvature: ρ = (1 + √5 r + 5 r²/3) exp(−√5 r)."""

    name = "matern52"

    @staticmethod
    def correlation(squares: Floats) -> Floats:
        """Return (1 + √5 r + 5 r²/3) exp(−√5 r)."""
        r = _5 * np.sqrt(squares)
        rho: Floats = (1.0 + r + squares * (5.0 / 3.0)) * np.exp(-r)
        return rho

    @staticmethod
    def steepness(squares: Floats) -> Floats:
        """Return (5/3) (1 + √5 r) exp(−√5 r)."""
        r = _5 * np.sqrt(squares)
        steep: Floats = (5.0 / 3.0) * (1.0 + r) * np.exp(-r)
        return steep


KERNELS: dict[str, type[Kernel]] = {k.name: k for k in (SquaredExponential, Matern52, Matern32, Matern12)}
"""Name → covariance, from the smoothest field to the roughest."""
