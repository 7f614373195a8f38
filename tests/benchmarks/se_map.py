"""The map as it was before kernels were chosen: squared exponential, plain maximum likelihood, no nugget."""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.linalg import LinAlgError, cho_solve, cholesky
from scipy.optimize import minimize

from formulations.kernel import SquaredExponential
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.survey import Score, score

SHARES = (0.03, 0.08, 0.2, 0.5)


def fitted(noise_sd: float, X: np.ndarray, y: np.ndarray) -> SquaredExponential:
    """Return the likeliest kernel of readings `y` (N,) at `X` (N, 2) [m], the level by generalised least squares."""
    squares = [np.subtract.outer(x, x) ** 2 for x in X.T]

    def negative(theta: np.ndarray) -> float:
        signal, *scales = np.exp(theta)
        near = sum(square / scale**2 for square, scale in zip(squares, scales, strict=True))
        try:
            L = cholesky(signal**2 * np.exp(-0.5 * near) + noise_sd**2 * np.eye(len(y)), lower=True)
        except LinAlgError:
            return 1e10
        ones, values = cho_solve((L, True), np.column_stack([np.ones_like(y), y])).T
        a = values - (ones @ y) / ones.sum() * ones
        return float(0.5 * y @ a + np.log(np.diagonal(L)).sum())

    extent = float(np.ptp(X, axis=0).max())
    grid = [np.log([y.std(), lx * extent, ly * extent]) for lx, ly in product(SHARES, SHARES)]
    starts = [np.log([30.0, 4000.0, 4000.0]), *sorted(grid, key=negative)[:3]]
    best = min((minimize(negative, start, method="L-BFGS-B") for start in starts), key=lambda found: found.fun)
    signal, lx, ly = np.exp(best.x)
    return SquaredExponential(float(signal), (float(lx), float(ly)))


def judged(noise_sd: float, X: np.ndarray, y: np.ndarray, points: np.ndarray, truth: np.ndarray) -> Score:
    """Return the score of that map at `points`."""
    process = GaussianProcess(fitted(noise_sd, X, y), noise_sd, points)
    process.extend(X, y)
    return score(process.posterior(), truth, noise_sd)
