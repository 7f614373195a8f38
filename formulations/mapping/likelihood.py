"""Hyperparameters by maximum likelihood (paper, eq. GPR2), the sensor's σ_n held fixed.

    (σ_f, Σ_l) = argmax log p(y | X),   log p = −½ rᵀ C⁻¹ r − ½ log det C − ½ N log 2π,   C = K_II + σ_n² I

with r = y − μ̂ 1 and μ̂ the generalised-least-squares mean: data near −90 dBm under a zero mean would push σ_f up to
explain the level. By the envelope theorem ∂/∂θ = ½ rᵀC⁻¹ (∂C/∂θ) C⁻¹r − ½ tr(C⁻¹ ∂C/∂θ) also with μ̂ in r.

The likelihood of few samples has several peaks, and a search that begins where the last one ended stays on the wrong
one for the rest of a survey. So it begins there and also at the best places of a coarse grid of length scales.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError, cho_solve, cholesky
from scipy.linalg.lapack import dpotri
from scipy.optimize import minimize

from formulations.kernel import SquaredExponential
from instances.arrays import Floats

FEWEST = 8
"""With fewer samples nothing is fitted."""
REACH = 50.0
"""Each parameter stays within this factor of where the search begins."""
SHARES = (0.03, 0.08, 0.2, 0.5)
"""Length scales of the grid, in extents of the samples."""
STARTS = 3
"""Places of the grid from which the search begins, beside the kernel given."""
TIE = 1e-6
"""A peak must be higher by so much [nats] to be taken instead of an earlier one."""


class Likelihood:
    """log p(y | X) of samples `y` (N,) at `X` (N, 2) [m] as a function of θ = (log σ_f, log l_x, log l_y)."""

    def __init__(self, noise_sd: float, X: Floats, y: Floats) -> None:
        self.noise_sd, self.y = noise_sd, y
        self.squares = [np.subtract.outer(x, x) ** 2 for x in X.T]

    def __call__(self, theta: Floats) -> tuple[float, Floats]:
        """Return log p [nats] and its gradient, shape (3,); LinAlgError where C is not positive in float64."""
        signal, *scales = np.exp(theta)
        near = [square / scale**2 for square, scale in zip(self.squares, scales, strict=True)]
        K = signal**2 * np.exp(-0.5 * (near[0] + near[1]))
        C = K.copy()
        C[np.diag_indices_from(C)] += self.noise_sd**2
        L = cholesky(C, lower=True, check_finite=False)
        ones, values = cho_solve((L, True), np.column_stack([np.ones_like(self.y), self.y]), check_finite=False).T
        a = values - (ones @ self.y) / ones.sum() * ones  # C⁻¹ r
        value = -0.5 * self.y @ a - np.log(np.diagonal(L)).sum() - 0.5 * len(a) * np.log(2 * np.pi)
        inverse, _ = dpotri(L, lower=True)  # its lower triangle
        inverse += np.tril(inverse, -1).T
        weighted = (np.outer(a, a) - inverse) * K
        gradient = [weighted.sum(), *(0.5 * np.vdot(weighted, square) for square in near)]
        return float(value), np.array(gradient)


def log_likelihood(kernel: SquaredExponential, noise_sd: float, X: Floats, y: Floats) -> tuple[float, Floats]:
    """Return log p(y | X) [nats] and its gradient by log σ_f, log l_x, log l_y, shape (3,)."""
    return Likelihood(noise_sd, X, y)(_theta(kernel))


def fit_hyperparameters(
    kernel: SquaredExponential, noise_sd: float, positions: ArrayLike, values: ArrayLike, most: int = 300
) -> SquaredExponential:
    """Return the kernel of greatest likelihood found by L-BFGS-B from `kernel` and from the best places of a grid.

    At most `most` samples, evenly chosen over the record, are used: the cost grows with their cube. Each parameter
    stays within REACH of `kernel`'s; with fewer than FEWEST samples `kernel` is returned.
    """
    X = np.asarray(positions, dtype=float).reshape(-1, 2)
    y = np.asarray(values, dtype=float).reshape(-1)
    if len(y) < FEWEST:
        return kernel
    if len(y) > most:
        chosen = np.linspace(0, len(y) - 1, most).round().astype(int)
        X, y = X[chosen], y[chosen]
    likelihood, given = Likelihood(noise_sd, X, y), _theta(kernel)
    low, high = given - np.log(REACH), given + np.log(REACH)

    def negative(theta: Floats) -> tuple[float, Floats]:
        try:
            value, gradient = likelihood(theta)
        except LinAlgError:
            return np.inf, np.zeros(3)
        return -value, -gradient

    grid = [np.clip(theta, low, high) for theta in _grid(X, y)]
    promising = sorted(grid, key=lambda theta: negative(theta)[0])[:STARTS]
    best, least = given, np.inf
    for start in (given, *promising):
        found = minimize(negative, start, jac=True, method="L-BFGS-B", bounds=list(zip(low, high, strict=True)))
        if found.fun < least - TIE:
            best, least = found.x, found.fun
    return _kernel(best)


def _grid(X: Floats, y: Floats) -> list[Floats]:
    """Return θ at which a search may begin: scales of SHARES of the samples' extent along x and y, σ_f their sd."""
    extent = float(np.ptp(X, axis=0).max())
    signal = float(y.std())
    if extent == 0.0 or signal == 0.0:
        return []
    scales = np.log(extent * np.array(SHARES))
    return [np.array([np.log(signal), lx, ly]) for lx, ly in product(scales, scales)]


def _theta(kernel: SquaredExponential) -> Floats:
    return np.log([kernel.signal_sd, *kernel.length_scales])


def _kernel(theta: Floats) -> SquaredExponential:
    signal, lx, ly = np.exp(theta)
    return SquaredExponential(float(signal), (float(lx), float(ly)))
