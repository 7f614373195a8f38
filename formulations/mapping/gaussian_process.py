"""Gaussian-process map of a measured field, updated tick by tick: `extend` by what was measured, then `posterior`.

Paper, §Gaussian Process Regression: constant mean (eq. mean), non-isotropic squared-exponential covariance
(eq. cov) and, with noisy observations y at X, at the map's points X_* (eq. GPR1)

    mean  f̄_*   = μ + K_OI (K_II + σ_n² I)⁻¹ (y − μ)
    cov   (f_*)  = K_OO − K_OI (K_II + σ_n² I)⁻¹ K_IO

With K_II + σ_n² I = L Lᵀ, V = L⁻¹ K_IO, z = L⁻¹ y and e = L⁻¹ 1 these are sums over rows, so that a tick of b new
samples only appends b rows to L, V, z and e (O(N b) per pixel) instead of starting again.

Where μ is not given it is estimated by generalised least squares, μ̂ = eᵀz / eᵀe, and the variance gains the term
(1 − Vᵀe)² / eᵀe of not knowing it (Rasmussen & Williams 2006, §2.7, a vague prior on the mean).

Entropy: ½ log det(2πe K); the information gathered so far is IG = ½ log det(I + K_II / σ_n²) [nats].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cholesky, solve_triangular

from formulations.kernel import SquaredExponential
from instances.arrays import Floats


@dataclass(frozen=True)
class Posterior:
    """The map at its points: `mean` and `sd` in the field's unit, shape (p,), and the mean level μ."""

    mean: Floats
    sd: Floats
    level: float


class GaussianProcess:
    """A Gaussian process over fixed map points, extended by blocks of samples.

    kernel : covariance (eq. cov).
    noise_sd : σ_n > 0, the sensor's, in the field's unit.
    points : map points [m], shape (p, 2).
    level : the constant mean μ, or None to estimate it.
    """

    def __init__(self, kernel: SquaredExponential, noise_sd: float, points: ArrayLike, level: float | None = None):
        if not noise_sd > 0:
            raise ValueError(f"noise_sd must be positive, got {noise_sd}")
        self.kernel = kernel
        self.noise_sd = float(noise_sd)
        self.level = level
        self.points = np.asarray(points, dtype=float).reshape(-1, 2)
        self._count = 0
        self._X = np.empty((0, 2))
        self._y = np.empty(0)
        self._L = np.empty((0, 0))
        self._V = np.empty((0, len(self.points)))
        self._z = np.empty(0)
        self._e = np.empty(0)
        self._squares = np.zeros(len(self.points))  # Σ V²
        self._Vz = np.zeros(len(self.points))
        self._Ve = np.zeros(len(self.points))

    @property
    def samples(self) -> tuple[Floats, Floats]:
        """Positions [m], shape (N, 2), and values, shape (N,), seen so far."""
        return self._X[: self._count], self._y[: self._count]

    def extend(self, positions: ArrayLike, values: ArrayLike) -> None:
        """Add samples at `positions` [m], shape (b, 2), with `values`, shape (b,)."""
        X = np.asarray(positions, dtype=float).reshape(-1, 2)
        y = np.asarray(values, dtype=float).reshape(-1)
        if len(X) != len(y) or not np.isfinite(X).all() or not np.isfinite(y).all():
            raise ValueError("positions (b, 2) and values (b,) must be finite and of the same count")
        if len(X) == 0:
            return
        old, new = self._count, self._count + len(X)
        self._reserve(new)
        # [L 0; M N] [L 0; M N]ᵀ = [K_II K_Ib; K_bI K_bb] + σ_n² I
        L = self._L[:old, :old]
        M = solve_triangular(L, self.kernel(self._X[:old], X), lower=True, check_finite=False).T
        K = self.kernel(X, X)
        K[np.diag_indices_from(K)] += self.noise_sd**2
        N = cholesky(K - M @ M.T, lower=True, check_finite=False)
        self._L[old:new, :old], self._L[old:new, old:new] = M, N
        self._X[old:new], self._y[old:new] = X, y
        rows = self.kernel(X, self.points) - M @ self._V[:old]
        rows = solve_triangular(N, rows, lower=True, check_finite=False, overwrite_b=True)
        z = solve_triangular(N, y - M @ self._z[:old], lower=True, check_finite=False)
        e = solve_triangular(N, 1.0 - M @ self._e[:old], lower=True, check_finite=False)
        self._V[old:new], self._z[old:new], self._e[old:new] = rows, z, e
        self._squares += np.einsum("ij,ij->j", rows, rows)
        self._Vz += z @ rows
        self._Ve += e @ rows
        self._count = new

    def _reserve(self, count: int) -> None:
        """Make room for `count` samples, doubling so that growing costs little."""
        have = len(self._y)
        if count <= have:
            return
        room = max(count, 2 * have, 64)
        old = self._count
        grown_L = np.zeros((room, room))
        grown_L[:old, :old] = self._L[:old, :old]
        self._L = grown_L
        for name in ("_X", "_y", "_V", "_z", "_e"):
            array = getattr(self, name)
            grown = np.empty((room, *array.shape[1:]))
            grown[:old] = array[:old]
            setattr(self, name, grown)

    def posterior(self) -> Posterior:
        """Return mean and standard deviation at the map points (eq. GPR1); variances are never negative."""
        variance = self.kernel.signal_sd**2 - self._squares
        level = 0.0 if self.level is None else self.level
        if self.level is None and self._count:
            e, z = self._e[: self._count], self._z[: self._count]
            weight = float(e @ e)
            level = float(e @ z) / weight
            variance = variance + (1.0 - self._Ve) ** 2 / weight
        mean = level + self._Vz - level * self._Ve
        return Posterior(mean, np.sqrt(np.maximum(variance, 0.0)), level)

    def information(self) -> float:
        """Return IG = ½ log det(I + K_II/σ_n²) [nats]: what the samples say about the field."""
        diagonal = np.diagonal(self._L)[: self._count]
        return float(np.log(diagonal).sum() - self._count * np.log(self.noise_sd))

    def entropy(self) -> float:
        """Return H(y) = ½ log det(2πe (K_II + σ_n² I)) [nats] of the samples, differential in the field's unit."""
        return self.information() + self._count * float(0.5 * np.log(2 * np.pi * np.e) + np.log(self.noise_sd))

    def refitted(self, kernel: SquaredExponential) -> GaussianProcess:
        """Return the same process and samples under another kernel, factorised afresh."""
        again = GaussianProcess(kernel, self.noise_sd, self.points, self.level)
        again.extend(*self.samples)
        return again
