"""Gaussian-process map of a measured field, updated tick by tick: `extend` by what was measured, then `posterior`.

Paper, §Gaussian Process Regression: constant mean (eq. mean), non-isotropic covariance (eq. cov; others: kernel.py)
and, with noisy observations y at X, at the map's points X_* (eq. GPR1)

    mean  f̄_*   = μ + K_OI (K_II + σ_n² I)⁻¹ (y − μ)
    cov   (f_*)  = K_OO − K_OI (K_II + σ_n² I)⁻¹ K_IO

With K_II + σ_n² I = L Lᵀ, V = L⁻¹ K_IO and z = L⁻¹ y these are sums over rows, so that a tick of b new samples only
appends b rows to L, V and z (O(N b) per pixel) instead of starting again.

Where μ is not given, the mean is Hβ of q known columns (`formulations.mapping.trend`; H = 1 is the unknown level), and
β, believed to be b with a precision B⁻¹ (0 for the level), is estimated by generalised least squares: with E = L⁻¹H,
A = EᵀE + B⁻¹, β̂ = b + A⁻¹Eᵀ(z − Eb) and R = H_*ᵀ − EᵀV the mean is H_*β̂ + Vᵀ(z − Eβ̂), and the variance gains the
term diag(Rᵀ A⁻¹ R) of not knowing β (universal kriging; Rasmussen & Williams 2006, §2.7).

A nugget τ is what the field does within less than the distance of two samples: readings carry it as if it were noise,
and the field at a map point has it too, so the map's variance holds it.

Entropy: ½ log det(2πe K); the information gathered so far is IG = ½ log det(I + K_II / σ_n²) [nats].
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

from formulations.kernel import Kernel
from formulations.mapping.map_model import MapModel
from instances.arrays import Floats


@dataclass(frozen=True)
class Posterior:
    """The map at its points: `mean` and `sd` in the field's unit, shape (p,); β̂ (or μ) of its mean, shape (q,)."""

    mean: Floats
    sd: Floats
    coefficients: Floats


class GaussianProcess:
    """A Gaussian process over fixed map points, extended by blocks of samples.

    model : covariance (eq. cov), nugget and mean; a covariance alone is one without nugget and of constant mean.
    noise_sd : σ_n > 0, the sensor's, in the field's unit.
    points : map points [m], shape (p, 2).
    level : the constant mean μ, or None to estimate the mean of `model`.
    """

    def __init__(self, model: MapModel | Kernel, noise_sd: float, points: ArrayLike, level: float | None = None):
        if not noise_sd > 0:
            raise ValueError(f"noise_sd must be positive, got {noise_sd}")
        self.model = model if isinstance(model, MapModel) else MapModel(model)
        self.kernel = self.model.kernel
        self.noise_sd = float(noise_sd)
        self.level = level
        self.points = np.asarray(points, dtype=float).reshape(-1, 2)
        self._count = 0
        self._X = np.empty((0, 2))
        self._y = np.empty(0)
        self._L = np.empty((0, 0))
        self._V = np.empty((0, len(self.points)))
        self._z = np.empty(0)
        self._H = self.model.trend.columns(self.points)
        self._E = np.empty((0, self._H.shape[1]))
        self._own = self.kernel.variance(self.points) + self.model.nugget_sd**2
        self._squares = np.zeros(len(self.points))  # Σ V²
        self._Vz = np.zeros(len(self.points))
        self._EV = np.zeros_like(self._H.T)

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
        # [L 0; M N] [L 0; M N]ᵀ = [K_II K_Ib; K_bI K_bb] + (σ_n² + τ²) I
        L = self._L[:old, :old]
        M = solve_triangular(L, self.kernel(self._X[:old], X), lower=True, check_finite=False).T
        K = self.kernel(X, X)
        K[np.diag_indices_from(K)] += self.noise_sd**2 + self.model.nugget_sd**2
        N = cholesky(K - M @ M.T, lower=True, check_finite=False)
        self._L[old:new, :old], self._L[old:new, old:new] = M, N
        self._X[old:new], self._y[old:new] = X, y
        rows = self.kernel(X, self.points) - M @ self._V[:old]
        rows = solve_triangular(N, rows, lower=True, check_finite=False, overwrite_b=True)
        z = solve_triangular(N, y - M @ self._z[:old], lower=True, check_finite=False)
        E = solve_triangular(N, self.model.trend.columns(X) - M @ self._E[:old], lower=True, check_finite=False)
        self._V[old:new], self._z[old:new], self._E[old:new] = rows, z, E
        self._squares += np.einsum("ij,ij->j", rows, rows)
        self._Vz += z @ rows
        self._EV += E.T @ rows
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
        for name in ("_X", "_y", "_V", "_z", "_E"):
            array = getattr(self, name)
            grown = np.empty((room, *array.shape[1:]))
            grown[:old] = array[:old]
            setattr(self, name, grown)

    def posterior(self) -> Posterior:
        """Return mean and standard deviation at the map points (eq. GPR1); variances are never negative."""
        variance = self._own - self._squares
        coefficients = np.zeros(self._H.shape[1])
        if self.level is not None:
            coefficients[0] = self.level
        elif self._count:
            E, z = self._E[: self._count], self._z[: self._count]
            believed = self.model.trend.prior_mean
            A = cho_factor(E.T @ E + self.model.trend.prior_precision, lower=True)
            coefficients = believed + cho_solve(A, E.T @ (z - E @ believed))
            R = self._H.T - self._EV
            variance = variance + np.einsum("ij,ij->j", R, cho_solve(A, R))
        mean = self._H @ coefficients + self._Vz - coefficients @ self._EV
        return Posterior(mean, np.sqrt(np.maximum(variance, 0.0)), coefficients)

    def information(self) -> float:
        """Return IG = ½ log det(I + K_II/(σ_n² + τ²)) [nats]: what the samples say about the field."""
        diagonal = np.diagonal(self._L)[: self._count]
        return float(np.log(diagonal).sum() - self._count * np.log(self._reading_sd))

    def entropy(self) -> float:
        """Return H(y) = ½ log det(2πe (K_II + (σ_n² + τ²) I)) [nats] of the samples, differential in their unit."""
        return self.information() + self._count * float(0.5 * np.log(2 * math.pi * math.e) + np.log(self._reading_sd))

    @property
    def _reading_sd(self) -> float:
        return math.hypot(self.noise_sd, self.model.nugget_sd)

    def refitted(self, model: MapModel) -> GaussianProcess:
        """Return the same process and samples under another model, factorised afresh."""
        again = GaussianProcess(model, self.noise_sd, self.points, self.level)
        again.extend(*self.samples)
        return again
