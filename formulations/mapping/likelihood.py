"""Hyperparameters by restricted maximum likelihood (paper, eq. GPR2), the sensor's σ_n held fixed.

The samples y at X are y = Hβ + f + noise: a mean of q known columns with unknown coefficients (`trend`), a field of
covariance k, and of each reading a nugget σ₀, what the field does within less than the distance of two samples. With
β = b + β′, β′ ~ N(0, B), where B is infinite for the level and s² for a coefficient of which something is believed,

    C = K_II + (σ_n² + σ₀²) I,   A = Hᵀ C⁻¹ H + B⁻¹,   u = y − H b,   β̂′ = A⁻¹ Hᵀ C⁻¹ u,   r = u − H β̂′
    log p = −½ uᵀ C⁻¹ r − ½ log det C − ½ log det A − log s − ½ (N − 1) log 2π

This is the likelihood with β integrated out, that of the level under a flat prior of density 1 (Rasmussen & Williams
2006, §2.7); maximum likelihood proper takes β̂ for known and so believes fields to be too smooth and too quiet. With
θ = (log σ_f, log l_x, log l_y, log σ₀) and P = C⁻¹ − C⁻¹H A⁻¹ HᵀC⁻¹ its gradient is

    ∂/∂θ = ½ Σ_ij (C⁻¹r rᵀC⁻¹ − P)_ij (∂C/∂θ)_ij

Where the length scales hold along a direction φ and across it, Δ = (Δ_1, Δ_2) in these, r² = Δ_1²/l_1² + Δ_2²/l_2² and
∂r²/∂φ = 2 Δ_1 Δ_2 (1/l_1² − 1/l_2²).

Where the prior standard deviation is a map σ_f m(x), K_II is that of σ_f with m_i m_j at its entries: σ_f is fitted,
m is not.

Where the field drifts, K_II is multiplied by exp(−|t − t′|/τ), entry by entry, and θ goes on with log τ:
∂C/∂log τ = K_II ∘ |t − t′|/τ. Where the mean divides the field (trend.py), it is multiplied by exp(−|p − p′|/c) of the
predicted p, and θ ends in log c, likewise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_solve, cholesky
from scipy.linalg.lapack import dpotri

from formulations.kernel import Kernel
from formulations.mapping.trend import Trend
from instances.arrays import Floats


class RestrictedLikelihood:
    """log p(y | X) of samples `y` (N,) at `X` (N, 2) [m] with the mean `trend`, as a function of θ.

    times : of the samples [s], shape (N,), where θ is asked with log τ. divided : whether it is asked with log c. One
    object serves any kernel: what does not depend on θ is made once.
    """

    def __init__(
        self,
        noise_sd: float,
        X: Floats,
        y: Floats,
        trend: Trend,
        times: Floats | None = None,
        relative_sd: Floats | None = None,
        *,
        divided: bool = False,
    ) -> None:
        """relative_sd : m at `X`, shape (N,); None for 1."""
        self.noise_sd, self.H, self.precision = noise_sd, trend.columns(X), trend.prior_precision
        self.u = y - self.H @ trend.prior_mean
        believed = np.diagonal(self.precision)[1:]
        self.constant = 0.5 * float(np.log(believed).sum()) - 0.5 * (len(y) - 1) * np.log(2 * np.pi)
        dx, dy = (np.subtract.outer(x, x) for x in X.T)
        self.squares, self.product = [dx**2, dy**2], dx * dy
        self.shares = None if relative_sd is None else np.multiply.outer(relative_sd, relative_sd)
        apart = [] if times is None else [times]
        apart += [self.H[:, 1]] if divided else []
        self.lags = [np.abs(np.subtract.outer(each, each)) for each in apart]  # over τ and over c

    def value(self, kernel: type[Kernel], theta: Floats, direction: float | None = None) -> float:
        """Return log p [nats]; LinAlgError where C or A is not positive in float64."""
        return self._solved(kernel, theta, direction)[0]

    def __call__(self, kernel: type[Kernel], theta: Floats, direction: float | None = None) -> tuple[float, Floats]:
        """Return log p [nats] and its gradient; LinAlgError where C or A is not positive in float64.

        direction : φ [rad] of the first length scale; x and y unless given. The gradient is that by θ, in its shape,
        and, where a direction is given, by φ after it.
        """
        signal, lx, ly, nugget, *over = np.exp(theta)
        value, L, CH, a, LA = self._solved(kernel, theta, direction)
        inverse, _ = dpotri(L, lower=True)  # its lower triangle
        weighted = np.outer(a, a) - np.tril(inverse) - np.tril(inverse, -1).T
        weighted += CH @ cho_solve((LA, True), CH.T, check_finite=False)
        quiet = np.trace(weighted) * nugget**2
        weighted *= self._decay(over)
        near = self._near(lx, ly, direction)
        if self.shares is not None:
            weighted *= self.shares
        along = 0.5 * signal**2 * weighted * kernel.steepness(near[0] + near[1])
        K = signal**2 * kernel.correlation(near[0] + near[1])
        by_lengths = (np.vdot(along, square) for square in near)
        fading = [0.5 * np.vdot(weighted * K, lag / each) for lag, each in zip(self.lags, over, strict=True)]
        turn = [] if direction is None else [np.vdot(along, self._turn(direction)) * (ly**-2 - lx**-2)]
        return value, np.array([np.vdot(weighted, K), *by_lengths, quiet, *fading, *turn])

    def _decay(self, over: Sequence[float]) -> Floats | float:
        """Return exp(−|t − t′|/τ) times exp(−|p − p′|/c), of these what there is; 1 where there is neither."""
        if not self.lags:
            return 1.0
        decay: Floats = np.exp(-sum(lag / each for lag, each in zip(self.lags, over, strict=True)))
        return decay

    def _near(self, lx: float, ly: float, direction: float | None) -> list[Floats]:
        """Return (Δ_1/l_1)² and (Δ_2/l_2)², each (N, N)."""
        squares = self.squares
        if direction is not None:
            cos, sin = math.cos(direction), math.sin(direction)
            both = 2.0 * cos * sin * self.product
            first, second = (c**2 * squares[0] + s**2 * squares[1] for c, s in ((cos, sin), (sin, cos)))
            squares = [np.maximum(first + both, 0.0), np.maximum(second - both, 0.0)]  # rounding may take them below 0
        return [square / scale**2 for square, scale in zip(squares, (lx, ly), strict=True)]

    def _turn(self, direction: float) -> Floats:
        """Return Δ_1 Δ_2, (N, N)."""
        turned: Floats = 0.5 * math.sin(2 * direction) * (self.squares[1] - self.squares[0])
        turned += math.cos(2 * direction) * self.product
        return turned

    def _solved(
        self, kernel: type[Kernel], theta: Floats, direction: float | None
    ) -> tuple[float, Floats, Floats, Floats, Floats]:
        """Return log p, the factor L of C, C⁻¹H, C⁻¹r and the factor of A."""
        signal, lx, ly, nugget, *over = np.exp(theta)
        near = self._near(lx, ly, direction)
        C = kernel.correlation(near[0] + near[1])
        C *= signal**2
        if self.shares is not None:
            C *= self.shares
        C *= self._decay(over)
        C[np.diag_indices_from(C)] += self.noise_sd**2 + nugget**2
        L = cholesky(C, lower=True, check_finite=False)
        solved = cho_solve((L, True), np.column_stack([self.H, self.u]), check_finite=False)
        CH, Cu = solved[:, :-1], solved[:, -1]
        LA = cholesky(self.H.T @ CH + self.precision, lower=True, check_finite=False)
        a = Cu - CH @ cho_solve((LA, True), self.H.T @ Cu, check_finite=False)
        half_logs = np.log(np.diagonal(L)).sum() + np.log(np.diagonal(LA)).sum()
        return float(self.constant - 0.5 * self.u @ a - half_logs), L, CH, a, LA
