"""What readings at T leave beside those at S, −½ log J(S ∪ T) with the average variance J, and its places T.

It is criterion j of a placement (`task_location.variance_reduction`), but for a constant, for what remains of a flight:
the one to take where targets count unlike. T and the targets are as of the landing, which readings at S are older than.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from formulations.average_variance import AverageVariance
from formulations.kernel import Kernel
from instances.arrays import Floats


@dataclass(frozen=True, eq=False)
class RemainingVariance:
    """−½ log J(S ∪ T) as a function of T.

    judged : J, whose known readings are S. landing : when T is taken to be read [s], not before any of S.
    """

    judged: AverageVariance
    landing: float

    @property
    def kernel(self) -> Kernel:
        """Of the field."""
        return self.judged.kernel

    def __call__(self, points: Floats) -> tuple[float, Floats]:
        """Return the value [nats] and its gradient [nats/m], shape (n, 2), at the tasks `points` (n, 2) [m]."""
        left, gradient = self.judged(points, np.full(len(points), self.landing))
        return -0.5 * math.log(left), -0.5 * gradient / left

    def greedy(self, candidates: Floats, count: int) -> Floats:
        """Return `count` of the `candidates` (c, 2) [m], each chosen where J falls most beside those before it.

        A reading at c lowers J by Σ_g w_g k(c, g | S)²/(k(c, c | S) + σ²).
        """
        judged, kernel, noise = self.judged, self.kernel, self.judged.noise_sd**2
        phi = self._features(candidates)
        to_targets = kernel(candidates, judged.targets) - phi.T @ self._features(judged.targets)
        left = kernel.variance(candidates) - np.einsum("sc,sc->c", phi, phi)
        rows, free, chosen = np.zeros((count, len(candidates))), np.ones(len(candidates), dtype=bool), list[int]()
        for step in range(count):
            gain = to_targets**2 @ judged.shares / (np.maximum(left, 0.0) + noise)
            best = int(np.argmax(np.where(free, gain, -np.inf)))
            chosen.append(best)
            free[best] = False
            row = kernel(candidates[best][None], candidates)[0] - phi[:, best] @ phi - rows[:step, best] @ rows[:step]
            row /= math.sqrt(max(left[best], 0.0) + noise)
            to_targets -= np.outer(row, to_targets[best] / math.sqrt(max(left[best], 0.0) + noise))
            rows[step] = row
            left -= row * row
        return candidates[chosen]

    def _features(self, points: Floats) -> Floats:
        """Return φ(x) as columns, shape (s, p): k(x, y | S) = k(x, y) − φ(x)ᵀφ(y) at the landing."""
        judged = self.judged
        known, times = judged.known, judged.known_times
        covariance = self.kernel(known, known) * np.exp(-np.abs(np.subtract.outer(times, times)) / judged.tau)
        covariance[np.diag_indices_from(covariance)] += judged.noise_sd**2
        faded = np.exp((times - self.landing) / judged.tau)[:, None]
        lower = cholesky(covariance, lower=True, check_finite=False)
        return np.asarray(solve_triangular(lower, faded * self.kernel(known, points), lower=True, check_finite=False))
