"""What is left unknown after noisy readings: the posterior standard deviation of the field (paper, eq. GPR1).

var(x | P) = k(x, x) − k(x, P) (K_P + σ_n² I)⁻¹ k(P, x)
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

from formulations.kernel import SquaredExponential
from formulations.task_location.criterion import log_det
from formulations.task_location.variance_reduction import Goal
from instances.arrays import Floats
from instances.environment.region import Region

PIXELS = 161
"""Places of a map along the longer side."""


def posterior_sd(kernel: SquaredExponential, noise_sd: float, readings: Floats, places: Floats) -> Floats:
    """Return the posterior sd at `places` (k, 2) [m] after readings at `readings` (n, 2) [m], shape (k,)."""
    variance = kernel.variance(places)
    if len(readings):
        factor = np.linalg.cholesky(kernel(readings, readings) + noise_sd**2 * np.eye(len(readings)))
        for part in np.array_split(np.arange(len(places)), max(1, len(places) // 5000)):
            half = solve_triangular(factor, kernel(readings, places[part]), lower=True, check_finite=False)
            variance[part] -= np.einsum("ij,ij->j", half, half)
    return np.sqrt(np.maximum(variance, 0.0))


def information_gain(kernel: SquaredExponential, noise_sd: float, readings: Floats) -> float:
    """Return IG = ½ log det(I + K/σ_n²) [nats] of readings at `readings` (n, 2) [m]."""
    return 0.5 * log_det(np.eye(len(readings)) + kernel(readings, readings) / noise_sd**2)


def sd_map(region: Region, criterion: Goal, readings: Floats) -> tuple[Floats, Floats, Floats]:
    """Return x (p,), y (q,) [m] and the posterior sd (q, p) over the region's bounding box, NaN outside the region."""
    x0, y0, x1, y1 = region.bounds
    pixel = max(x1 - x0, y1 - y0) / (PIXELS - 1)
    xs = np.linspace(x0, x1, max(2, round((x1 - x0) / pixel) + 1))
    ys = np.linspace(y0, y1, max(2, round((y1 - y0) / pixel) + 1))
    places = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    sd = np.full(len(places), np.nan)
    inside = region.contains(places)
    sd[inside] = posterior_sd(criterion.kernel, criterion.noise_sd, readings, places[inside])
    return xs, ys, sd.reshape(len(ys), len(xs))
