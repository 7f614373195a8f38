"""An upper bound under convention (b) on every choice of n out of N candidate sites.

    2 I(S) = f(S) − g(S),   f(S) = log det(I + K_S/σ²),   g(S) = log det(I + C_S/σ²)

f is bounded by the factorisation relaxation of certificate.py, inequality (1) with the sum Σ_{i∈S} h(x_i) in place of
n times the maximum. g is submodular with g(∅) = 0, so every point b of its base polytope gives b(S) ≤ g(S) (Edmonds
1970). With a_i = h(x_i) + σ²/r and log's tangent at any m > 0,

    2 I(S) ≤ n log m − n + Σ of the n largest (a_i/m − b_i) − Σ_{i≤n} log θ_i − n log σ²                          (2)

Θ and b come from maximising the concave φ(w) − ĝ(w) over 0 ≤ w ≤ 1, Σw = n: φ the relaxation of f, whose gradient is
a, and ĝ the Lovász extension of g, whose subgradient is the greedy base vector in descending order of w. The averages
of the last b and w are used. Valid for the sites given only, each used once: continuous designs may do better.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from formulations.task_location.blas import one_thread
from formulations.task_location.certificate import ROUNDING, Certificate, Theta
from formulations.task_location.criterion import Criterion
from instances.arrays import Floats
from instances.errors import InputError


@one_thread()
def discrete_certificate(criterion: Criterion, sites: Floats, n: int, *, rounds: int = 60) -> Certificate:
    """Return an upper bound on I of every n distinct `sites` (N, 2) [m], under the criterion's convention.

    rounds : steps of the ascent; more make the bound tighter, never wrong.
    """
    if not 1 <= n <= len(sites):
        raise InputError(f"certificate: {n} tasks do not fit on {len(sites)} sites")
    noise, variance = criterion.noise, criterion.kernel.signal_sd**2
    prior = criterion.kernel(sites, sites)
    phi = criterion.features(sites)
    posterior = criterion.posterior(prior, phi, phi)
    design = np.full(len(sites), n / len(sites))
    mean_design, mean_base = design.copy(), np.zeros(len(sites))
    best = math.inf
    for k in range(rounds):
        base = base_vector(posterior, noise, np.argsort(-design, kind="stable"))
        theta = Theta.of_design(prior, design, n, noise)
        slope = theta.heights(prior, variance) + noise * theta.floor - base
        share = 2.0 / (k + 2)
        mean_base += share * (base - mean_base)
        mean_design += share * (design - mean_design)
        design = _capped(design * np.exp(0.5 * (slope - slope.mean())), n)
        if k % 10 == 9 or k == rounds - 1:
            for w in (mean_design, design):
                best = min(best, _bound(Theta.of_design(prior, w, n, noise), prior, mean_base, n, noise, variance))
    return Certificate(best + ROUNDING * abs(best), "criterion b, the candidate sites only", rounds)


def base_vector(covariance: Floats, noise: float, order: NDArray[np.intp]) -> Floats:
    """Return the greedy base vector of g(S) = log det(I + C_S/σ²): b_i = g(up to i) − g(before i), in `order`.

    One Cholesky factor of the reordered matrix gives all increments: log of its squared diagonal.
    """
    permuted = covariance[np.ix_(order, order)] / noise
    permuted[np.diag_indices_from(permuted)] += 1.0
    base = np.empty(len(order))
    base[order] = 2 * np.log(np.diagonal(np.linalg.cholesky(permuted)))
    return base


def _capped(weights: Floats, n: int) -> Floats:
    """Return `weights` scaled to the sum n with none above 1."""
    capped = np.zeros(len(weights), dtype=bool)
    for _ in range(len(weights)):
        scaled = np.where(capped, 1.0, weights * (n - capped.sum()) / max(weights[~capped].sum(), 1e-300))
        over = scaled > 1.0
        if not (over & ~capped).any():
            return np.asarray(np.maximum(scaled, 1e-12))
        capped |= over
    return np.ones(len(weights))


def _bound(theta: Theta, prior: Floats, base: Floats, n: int, noise: float, variance: float) -> float:
    """Return half of the right side of (2), with the best m."""
    gain = theta.heights(prior, variance) + noise * theta.floor

    def right(log_m: float) -> float:
        slack = np.sort(gain * math.exp(-log_m) - base)[-n:].sum()
        return n * log_m - n + float(slack)

    level = math.log(float(gain.mean()))
    best = minimize_scalar(right, bounds=(level - 3, level + 3), method="bounded").fun
    return 0.5 * (float(best) - theta.log_smallest - n * math.log(noise))
