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
∂C/∂log τ = K_II ∘ |t − t′|/τ. Where the mean predicts shadows (shadows.py), it is multiplied by exp(−|o − o′|/c) m m′,
and θ ends in log c and log a: ∂C/∂log c = K_II ∘ |o − o′|/c, ∂C/∂log a = K_II ∘ (∂log m/∂log a + ∂log m′/∂log a).
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import cho_solve, cholesky
from scipy.linalg.lapack import dpotri

from formulations.kernel import Kernel
from formulations.mapping.shadows import Shadows
from formulations.mapping.trend import Trend
from instances.arrays import Floats


class RestrictedLikelihood:
    """log p(y | X) of samples `y` (N,) at `X` (N, 2) [m] with the mean `trend`, as a function of θ.

    times : of the samples [s], shape (N,), where θ is asked with log τ. shadowed : whether it is asked with log c and
    log a. One object serves any kernel: what does not depend on θ is made once.
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
        shadowed: bool = False,
    ) -> None:
        """relative_sd : m at `X`, shape (N,); None for 1."""
        self.noise_sd, self.H, self.precision = noise_sd, trend.columns(X), trend.prior_precision
        self.u = y - self.H @ trend.prior_mean
        believed = np.diagonal(self.precision)[1:]
        self.constant = 0.5 * float(np.log(believed).sum()) - 0.5 * (len(y) - 1) * np.log(2 * np.pi)
        dx, dy = (np.subtract.outer(x, x) for x in X.T)
        self.squares, self.product = [dx**2, dy**2], dx * dy
        self.shares = None if relative_sd is None else np.multiply.outer(relative_sd, relative_sd)
        self.lag = None if times is None else np.abs(np.subtract.outer(times, times))
        self.loss = trend.loss(X) if shadowed and trend.loss is not None else None

    def value(self, kernel: type[Kernel], theta: Floats, direction: float | None = None) -> float:
        """Return log p [nats]; LinAlgError where C or A is not positive in float64."""
        return self._solved(self._covariance(kernel, theta, direction)[0], np.exp(theta[3]))[0]

    def __call__(self, kernel: type[Kernel], theta: Floats, direction: float | None = None) -> tuple[float, Floats]:
        """Return log p [nats] and its gradient; LinAlgError where C or A is not positive in float64.

        direction : φ [rad] of the first length scale; x and y unless given. The gradient is that by θ, in its shape,
        and, where a direction is given, by φ after it.
        """
        nugget = np.exp(theta[3])
        K, decay, near = self._covariance(kernel, theta, direction)
        value, L, CH, a, LA = self._solved(K, nugget)
        inverse, _ = dpotri(L, lower=True)  # its lower triangle, above which L has zeros
        known = np.vstack([a, cho_solve((LA, True), CH.T, check_finite=False)])
        weighted = np.column_stack([a, CH]) @ known
        weighted -= 2.0 * inverse  # each entry for the one above the diagonal, too: all else is symmetric
        weighted[np.diag_indices_from(weighted)] += np.diagonal(inverse)
        quiet = np.trace(weighted) * nugget**2
        along = 0.5 * np.exp(theta[0]) ** 2 * weighted * decay * kernel.steepness(near[0] + near[1])
        by_lengths = [np.vdot(along, square) for square in near]
        weighted *= K
        turn = [] if direction is None else [self._by_direction(along, theta, direction)]
        return value, np.array([weighted.sum(), *by_lengths, quiet, *self._by_further(weighted, theta), *turn])

    def _covariance(
        self, kernel: type[Kernel], theta: Floats, direction: float | None
    ) -> tuple[Floats, Floats | float, list[Floats]]:
        """Return K, by what it is more than σ_f² ρ, and (Δ_1/l_1)² and (Δ_2/l_2)², each (N, N)."""
        signal, lx, ly = np.exp(theta[:3])
        near, shadows = self._near(lx, ly, direction), self._shadows(theta)
        decay: Floats | float = 1.0 if self.shares is None else self.shares
        if self.lag is not None:
            decay = decay * np.exp(-self.lag / np.exp(theta[4]))
        if shadows is not None and self.loss is not None:
            decay = decay * shadows.share(self.loss, self.loss)
        K = kernel.correlation(near[0] + near[1])
        K *= signal**2
        K *= decay
        return K, decay, near

    def _shadows(self, theta: Floats) -> Shadows | None:
        return None if self.loss is None else Shadows(*np.exp(theta[-2:]))

    def _by_further(self, weighted: Floats, theta: Floats) -> list[float]:
        """Return ∂ by log τ, and by log c and log a, where θ has them; weighted : ∂/∂C ∘ K, times 2, (N, N)."""
        found = [] if self.lag is None else [0.5 * np.vdot(weighted, self.lag) / np.exp(theta[4])]
        shadows = self._shadows(theta)
        if shadows is not None and self.loss is not None:
            apart = np.abs(np.subtract.outer(self.loss, self.loss))
            found.append(0.5 * np.vdot(weighted, apart) / shadows.contrast)
            found.append(0.5 * (weighted.sum(axis=0) + weighted.sum(axis=1)) @ shadows.sd_slope(self.loss))
        return found

    def _by_direction(self, along: Floats, theta: Floats, direction: float) -> float:
        """Return ∂ by φ; along : ∂/∂C ∘ K, times −ρ′/(r ρ), (N, N)."""
        across: float = np.vdot(along, self._turn(direction)) * (np.exp(-2 * theta[2]) - np.exp(-2 * theta[1]))
        return across

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

    def _solved(self, K: Floats, nugget: float) -> tuple[float, Floats, Floats, Floats, Floats]:
        """Return log p, the factor L of C, C⁻¹H, C⁻¹r and the factor of A."""
        C = K.copy()
        C[np.diag_indices_from(C)] += self.noise_sd**2 + nugget**2
        L = cholesky(C, lower=True, check_finite=False)
        solved = cho_solve((L, True), np.column_stack([self.H, self.u]), check_finite=False)
        CH, Cu = solved[:, :-1], solved[:, -1]
        LA = cholesky(self.H.T @ CH + self.precision, lower=True, check_finite=False)
        a = Cu - CH @ cho_solve((LA, True), self.H.T @ Cu, check_finite=False)
        half_logs = np.log(np.diagonal(L)).sum() + np.log(np.diagonal(LA)).sum()
        return float(self.constant - 0.5 * self.u @ a - half_logs), L, CH, a, LA
