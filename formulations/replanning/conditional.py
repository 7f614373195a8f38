"""What readings at T tell of the test points o when the readings at S are known: I(y_T; y_o | y_S), and its places T.

By the chain rule it is I(T ∪ S) − I(S) of the planning criterion (`task_location.criterion`). Written with what
readings leave open, k(x, y | Q) = k(x, y) − k(x, Q) (K_Q + σ² I)⁻¹ k(Q, y),

    I(y_T; y_o | y_S) = ½ log det(k(T, T | S) + σ² I) − ½ log det(k(T, T | S ∪ o) + σ² I)

needs matrices of the size of T only, once S ∪ o are factorised. With M = (k(T, T | Q) + σ² I)⁻¹ and
b(y) = (K_Q + σ² I)⁻¹ k(Q, y), of which no derivative is needed,

    ∂/∂x_i ½ log det(k(T, T | Q) + σ² I) = Σ_j M_ij (∂₁k(x_i, x_j) − ∂₁k(x_i, Q) b(x_j))

Under the noise convention (b): test points are read with noise σ, too, one of weight w with σ²/w. Where the field
drifts, what is to be read and the test points are taken as of one time, which the readings at S are older than, each by
its age.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.optimize import minimize

from formulations.average_variance import slope_sums
from formulations.kernel import Kernel
from formulations.task_location.boundary import box
from instances.arrays import Floats
from instances.environment.region import Region

ITERATIONS = 30
"""Steps of L-BFGS-B, at most: further ones move tasks by less than a re-plan a minute later does."""


class _Open:
    """½ log det(k(T, T | Q) + σ² I) of the readings at T that are still to be made, where Q (q, 2) [m] are read.

    weights : of Q, (q,): one of weight w has noise σ²/w.
    """

    def __init__(self, kernel: Kernel, noise_sd: float, read: Floats, ages: Floats, weights: Floats) -> None:
        self.kernel, self.noise, self.read = kernel, noise_sd**2, read
        self.faded = np.exp(-ages)[:, None]
        covariance = kernel(read, read)
        covariance *= np.exp(-np.abs(np.subtract.outer(ages, ages)))
        covariance[np.diag_indices_from(covariance)] += self.noise / weights
        self._lower = cholesky(covariance, lower=True, check_finite=False)

    def features(self, points: Floats) -> Floats:
        """Return φ(x) as columns, shape (q, p): k(x, y | Q) = k(x, y) − φ(x)ᵀφ(y)."""
        far = self.faded * self.kernel(self.read, points)
        told: Floats = solve_triangular(self._lower, far, lower=True, check_finite=False)
        return told

    def at(self, points: Floats) -> tuple[float, Floats]:
        """Return the value [nats] and its gradient [nats/m], shape (n, 2), at the readings `points` (n, 2) [m]."""
        own, far = self.kernel(points, points), self.faded * self.kernel(self.read, points)
        weights = cho_solve((self._lower, True), far, check_finite=False)
        left = own - far.T @ weights
        left[np.diag_indices_from(left)] += self.noise
        factor = cho_factor(left, lower=True, check_finite=False)
        inverse = cho_solve(factor, np.eye(len(points)), check_finite=False)
        gradient = slope_sums(self.kernel, points, points, inverse)
        gradient -= slope_sums(self.kernel, points, self.read, (weights @ inverse).T * self.faded.T)
        return float(np.log(np.diagonal(factor[0])).sum()), gradient


@dataclass(frozen=True, eq=False)
class ConditionalInformation:
    """I(y_T; y_o | y_S) as a function of T.

    kernel : of the field. tests : o, shape (m, 2) [m]; known : S, shape (s, 2) [m]. noise_sd : σ > 0 of every reading,
    in the field's unit. ages : of the readings at S where the field drifts, in τ, shape (s,); 0 unless given.
    weights : w ≥ 0 of the tests, shape (m,); 1 each unless given.
    """

    kernel: Kernel
    tests: Floats
    known: Floats
    noise_sd: float
    ages: Floats | None = None
    weights: Floats | None = None
    _before: _Open = field(init=False, repr=False)
    _after: _Open = field(init=False, repr=False)

    def __post_init__(self) -> None:
        known, weights = np.ones(len(self.known)), np.ones(len(self.tests)) if self.weights is None else self.weights
        counts = weights > 0
        tests, weights = self.tests[counts], weights[counts]
        ages = np.zeros(len(self.known)) if self.ages is None else self.ages
        before = _Open(self.kernel, self.noise_sd, self.known, ages, known)
        told = [(tests, self.known), (np.zeros(len(tests)), ages), (weights, known)]
        both = _Open(self.kernel, self.noise_sd, *(np.concatenate(each) for each in told))
        object.__setattr__(self, "_before", before)
        object.__setattr__(self, "_after", both)

    def __call__(self, points: Floats) -> tuple[float, Floats]:
        """Return I [nats] and its gradient [nats/m], shape (n, 2), at the tasks `points` (n, 2) [m]."""
        before, after = self._before.at(points), self._after.at(points)
        return before[0] - after[0], before[1] - after[1]

    def greedy(self, candidates: Floats, count: int) -> Floats:
        """Return `count` of the `candidates` (c, 2) [m], each chosen where it tells most beside those before it."""
        phis = [self._before.features(candidates), self._after.features(candidates)]
        left = [self.kernel.variance(candidates) - np.einsum("qc,qc->c", phi, phi) for phi in phis]
        rows = [np.zeros((count, len(candidates))) for _ in phis]
        noise, free, chosen = self.noise_sd**2, np.ones(len(candidates), dtype=bool), list[int]()
        for step in range(count):
            gain = np.log((left[0] + noise) / (np.maximum(left[1], 0.0) + noise))
            best = int(np.argmax(np.where(free, gain, -np.inf)))
            chosen.append(best)
            free[best] = False
            prior = self.kernel(candidates[best][None], candidates)[0]
            for phi, open_, row in zip(phis, left, rows, strict=True):
                new = prior - phi[:, best] @ phi - row[:step, best] @ row[:step]
                new /= np.sqrt(max(open_[best], 0.0) + noise)
                row[step] = new
                open_ -= new * new
        return candidates[chosen]


class Worth(Protocol):
    """What tasks are placed by: a value to be great, with its gradient."""

    @property
    def kernel(self) -> Kernel:
        """Of the field."""
        ...

    def __call__(self, points: Floats) -> tuple[float, Floats]:
        """Return the value and its gradient [1/m], shape (n, 2), at the tasks `points` (n, 2) [m]."""
        ...

    def greedy(self, candidates: Floats, count: int) -> Floats:
        """Return `count` of the `candidates` (c, 2) [m], each chosen where it adds most beside those before it."""
        ...


def place_remaining(worth: Worth, sites: Region, start: Floats) -> Floats:
    """Return tasks in `sites` that are worth more beside what is known than `start` (n, 2) [m], by L-BFGS-B."""
    scales = np.asarray(worth.kernel.length_scales)

    def negative(z: Floats) -> tuple[float, Floats]:
        value, gradient = worth(z.reshape(-1, 2) * scales)
        return -value, -(gradient * scales).ravel()

    bounds = box(sites, scales, len(start))
    found = minimize(
        negative, (start / scales).ravel(), jac=True, bounds=bounds, method="L-BFGS-B", options={"maxiter": ITERATIONS}
    )
    return sites.snap(found.x.reshape(-1, 2) * scales)
