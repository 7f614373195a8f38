"""What is left unknown after noisy readings: the posterior standard deviation of the field (paper, eq. GPR1).

var(x | P) = k(x, x) − k(x, P) (K_P + σ_n² I)⁻¹ k(P, x)
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

from formulations.kernel import SquaredExponential
from formulations.task_location.criterion import log_det
from instances.arrays import Floats


def posterior_sd(kernel: SquaredExponential, noise_sd: float, readings: Floats, places: Floats) -> Floats:
    """Return the posterior sd at `places` (k, 2) [m] after readings at `readings` (n, 2) [m], shape (k,)."""
    variance = np.full(len(places), kernel.signal_sd**2)
    if len(readings):
        factor = np.linalg.cholesky(kernel(readings, readings) + noise_sd**2 * np.eye(len(readings)))
        for part in np.array_split(np.arange(len(places)), max(1, len(places) // 5000)):
            half = solve_triangular(factor, kernel(readings, places[part]), lower=True, check_finite=False)
            variance[part] -= np.einsum("ij,ij->j", half, half)
    return np.sqrt(np.maximum(variance, 0.0))


def information_gain(kernel: SquaredExponential, noise_sd: float, readings: Floats) -> float:
    """Return IG = ½ log det(I + K/σ_n²) [nats] of readings at `readings` (n, 2) [m]."""
    return 0.5 * log_det(np.eye(len(readings)) + kernel(readings, readings) / noise_sd**2)
