"""Covariances of a field over the plane, all non-isotropic (paper, eq. cov) and functions of one distance r.

    k(x_p, x_q) = σ_f² ρ(r),   r² = (x_p − x_q)ᵀ Σ_l⁻² (x_p − x_q),   Σ_l = diag(l_x, l_y)

A map's Σ_l may be turned, Rᵀ diag(l_1, l_2) R with R the rotation by −φ, the geometric anisotropy of geostatistics
(Chilès & Delfiner, Geostatistics, 2nd ed. 2012, §2.5): the ridges of real ground lie along no axis.

ρ is exp(−½ r²) for the squared exponential, the paper's, which planning uses throughout: its derivatives and bounds are
those of a smooth field. Maps of real ground and of radio signals are rougher: Matérn's ρ of smoothness ν = ½, 3/2 and
5/2 (Rasmussen & Williams 2006, eqs. 4.16–4.18). Where ν = ½ only σ_f²/l is told apart by data, not σ_f and l.

Where more is known of one place than of another, the prior standard deviation is a map s(x), and

    k(x_p, x_q) = s(x_p) s(x_q) ρ(r),   s(x) = σ_f m(x),   0 ≤ m ≤ 1,

is a covariance too: that of a field of covariance σ_f² ρ, at each place times m. No variance is greater than σ_f².
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from instances import InputError
from instances.arrays import Floats
from instances.environment.value_map import ValueMap

SMALLEST, LARGEST = 1e-120, 1e120
"""Beyond these the square of a parameter, or of a distance over it, is 0 or infinite in float64."""
_3, _5 = math.sqrt(3.0), math.sqrt(5.0)


@dataclass(frozen=True)
class Kernel(ABC):
    """Covariance of a field over the plane.

    signal_sd : σ_f > 0, in the field's unit; the greatest prior standard deviation of the field.
    length_scales : (l_x, l_y) > 0 [m].
    relative_sd : m, the prior standard deviation over σ_f, from 0 to 1; None where it is σ_f everywhere.
    direction : φ [rad], from the x axis to the line along which the first length scale holds, counter-clockwise; 0 in
    planning, whose derivatives and bounds are those of length scales along x and y.
    """

    name: ClassVar[str]
    signal_sd: float = 30.0
    length_scales: tuple[float, float] = (4000.0, 4000.0)
    relative_sd: ValueMap | None = None
    direction: float = 0.0

    def __post_init__(self) -> None:
        if not SMALLEST <= self.signal_sd <= LARGEST:
            raise InputError(f"signal_sd must be positive, from {SMALLEST:g} to {LARGEST:g}, got {self.signal_sd}")
        scales = tuple(float(scale) for scale in self.length_scales)
        if len(scales) != 2 or not all(SMALLEST <= scale <= LARGEST for scale in scales):
            raise InputError(
                f"length_scales must be two positive lengths [m], from {SMALLEST:g} to {LARGEST:g}, "
                f"got {self.length_scales}"
            )
        if self.relative_sd is not None and self.relative_sd.greatest > 1:
            raise InputError(f"relative_sd must be from 0 to 1, got {self.relative_sd.greatest:g}")
        object.__setattr__(self, "length_scales", scales)
        object.__setattr__(self, "signal_sd", float(self.signal_sd))

    @classmethod
    def of_prior(cls, prior_sd: ValueMap, length_scales: tuple[float, float]) -> Self:
        """Return the covariance of a field of prior standard deviation `prior_sd`, in the field's unit."""
        return cls(prior_sd.greatest, length_scales, prior_sd.relative())

    @property
    def stationary(self) -> Self:
        """The covariance of prior standard deviation σ_f everywhere."""
        return replace(self, relative_sd=None)

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
        p, q = self._scaled(a), self._scaled(b)
        # difference by difference, not the expanded square: coincident points give exactly σ_f²
        squares: Floats = np.subtract.outer(p[:, 0], q[:, 0]) ** 2
        squares += np.subtract.outer(p[:, 1], q[:, 1]) ** 2
        covariance = self.correlation(squares)
        covariance *= self.signal_sd**2
        if self.relative_sd is not None:
            covariance *= np.multiply.outer(self.relative_sd(a), self.relative_sd(b))
        return covariance

    def _scaled(self, points: ArrayLike) -> Floats:
        """Return `points` (k, 2) [m] along and across the direction, in length scales."""
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        if self.direction:
            cos, sin = math.cos(self.direction), math.sin(self.direction)
            p = np.column_stack([cos * p[:, 0] + sin * p[:, 1], cos * p[:, 1] - sin * p[:, 0]])
        scaled: Floats = p / np.asarray(self.length_scales)
        return scaled

    def variance(self, points: ArrayLike) -> Floats:
        """Return k(x_i, x_i) for `points` (k, 2) [m], shape (k,)."""
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        variance = np.full(len(p), self.signal_sd**2)
        if self.relative_sd is not None:
            variance *= self.relative_sd(p) ** 2
        return variance


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
