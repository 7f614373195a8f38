"""Hyperparameters by maximum likelihood (paper, eq. GPR2), the sensor's σ_n held fixed.

    (σ_f, Σ_l) = argmax log p(y | X),   log p = −½ rᵀ C⁻¹ r − ½ log det C − ½ N log 2π,   C = K_II + σ_n² I

with r = y − μ̂ 1 and μ̂ the generalised-least-squares mean: data near −90 dBm under a zero mean would push σ_f up to
explain the level. By the envelope theorem ∂/∂θ = ½ rᵀC⁻¹ (∂C/∂θ) C⁻¹r − ½ tr(C⁻¹ ∂C/∂θ) also with μ̂ in r.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_solve, cholesky
from scipy.optimize import minimize

from formulations.kernel import SquaredExponential
from instances.arrays import Floats


def log_likelihood(kernel: SquaredExponential, noise_sd: float, X: Floats, y: Floats) -> tuple[float, Floats]:
    """Return log p(y | X) [nats] and its gradient by log σ_f, log l_x, log l_y, shape (3,)."""
    K = kernel(X, X)
    C = K.copy()
    C[np.diag_indices_from(C)] += noise_sd**2
    L = cholesky(C, lower=True, check_finite=False)
    inverse = cho_solve((L, True), np.eye(len(y)), check_finite=False)
    ones = inverse.sum(axis=1)
    residual = y - (ones @ y) / ones.sum()
    a = inverse @ residual
    value = -0.5 * residual @ a - np.log(np.diagonal(L)).sum() - 0.5 * len(y) * np.log(2 * np.pi)
    outer = np.outer(a, a) - inverse
    weighted = outer * K
    gradient = [weighted.sum()]  # ∂C/∂log σ_f = 2K, halved
    for axis, scale in enumerate(kernel.length_scales):
        square = np.subtract.outer(X[:, axis], X[:, axis]) ** 2 / scale**2
        gradient.append(0.5 * (weighted * square).sum())
    return float(value), np.array(gradient)


def fit_hyperparameters(
    kernel: SquaredExponential, noise_sd: float, positions: ArrayLike, values: ArrayLike, most: int = 300
) -> SquaredExponential:
    """Return the kernel of greatest likelihood, searched by L-BFGS-B from `kernel`.

    At most `most` samples, evenly chosen over the record, are used: the cost grows with their cube. Each parameter
    stays within a factor of 50 of where the search begins; with fewer than 8 samples `kernel` is returned.
    """
    X = np.asarray(positions, dtype=float).reshape(-1, 2)
    y = np.asarray(values, dtype=float).reshape(-1)
    if len(y) < 8:
        return kernel
    if len(y) > most:
        chosen = np.linspace(0, len(y) - 1, most).round().astype(int)
        X, y = X[chosen], y[chosen]
    start = np.log([kernel.signal_sd, *kernel.length_scales])

    def negative(theta: Floats) -> tuple[float, Floats]:
        value, gradient = log_likelihood(_kernel(theta), noise_sd, X, y)
        return -value, -gradient

    reach = np.log(50.0)
    found = minimize(negative, start, jac=True, method="L-BFGS-B", bounds=[(s - reach, s + reach) for s in start])
    return _kernel(found.x) if np.isfinite(found.fun) else kernel


def _kernel(theta: Floats) -> SquaredExponential:
    signal, lx, ly = np.exp(theta)
    return SquaredExponential(float(signal), (float(lx), float(ly)))
