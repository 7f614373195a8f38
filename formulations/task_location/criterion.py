"""Mutual information between the readings at the tasks T and the test points o (paper, eqs. MI, obj_tasklocation).

The paper writes I(X_T; X_o) = ½ log[det K_T det K_o / det K] of *noiseless* variables. Read literally that is
ill-posed: at a task that meets a test point the supremum is +∞, and det K_o underflows to 0 in float64. Who carries
noise must be said. With σ_n the noise of a task reading and K_T|o = K_T − K_To (K_o + σ_o² W⁻¹)⁻¹ K_oT,

    I(P_T) = ½ [log det(K_T + σ_n² I) − log det(K_T|o + σ_n² I)],            an n × n form in which K_o enters once
             (Choi & How 2010, the backward form);

* "b", both noisy: σ_o = σ_n unless given. Finite, well conditioned, the planning default.
* "a", latent tests: σ_o = 0, the paper's before/after picture H(X_o) − H(X_o | y_T). K_o has condition 1e16, so
  eigenvalues under 1e-13 of the largest are cut off, which can only lower I.
* "ig", information gain: I(y_T; x everywhere) = ½ log det(I + K_T/σ_n²), the limit of both for dense tests and an
  upper bound of both (data processing).

Weights: a test point of weight w counts as w independent noisy readings at its place, W = diag(w); 0 leaves it out.
The larger σ_o, the more weights tell.

With the features φ(x) = (Λ + σ_o²)^(−½) Uᵀ W^½ k(P_o, x), where U Λ Uᵀ = W^½ K_o W^½, the posterior kernel is
c(x, y) = k(x, y) − φ(x)ᵀφ(y): both matrices are kernel matrices (see derivatives.py).
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from formulations.kernel import LARGEST, SMALLEST, SquaredExponential
from instances.arrays import Floats
from instances.errors import InputError, suggestion


class Convention(StrEnum):
    """Which variables carry noise; see the top of this file."""

    BOTH_NOISY = "b"
    """I(y_T; y_o): tasks and test points are both read with noise."""
    LATENT_TESTS = "a"
    """I(y_T; x_o): only the tasks are."""
    INFORMATION_GAIN = "ig"
    """I(y_T; x): about the whole field; test points drop out."""


LEAST_NOISE = 1e-5
"""Of the signal sd: with less noise the covariance of some hundred readings is singular in float64."""

MOST_TESTS = 5000
"""With more test points their covariance (m × m) and its eigenvectors take minutes and gigabytes."""

LITERAL_REFUSED = (
    "criterion 'literal' (the paper's eq. MI without noise) is ill-posed: its supremum is +∞ wherever a task meets a "
    "test point, and det(K_o) is 0 in float64; choose b (both noisy), a (noiseless test variables) or ig"
)


def convention(name: str, *others: str) -> Convention:
    """Return the convention called `name`; InputError for an unknown one and, with the reason, for ``literal``.

    others : names that the sentence of the error tells beside the conventions'.
    """
    if name == "literal":
        raise InputError(LITERAL_REFUSED)
    try:
        return Convention(name)
    except ValueError:
        known = [*map(str, Convention), *others]
        raise InputError(f"unknown criterion '{name}'{suggestion(name, known)} (known: {', '.join(known)})") from None


@dataclass(frozen=True, eq=False)
class Criterion:
    """Mutual information as a function of the task locations.

    kernel : prior covariance of the field.
    tests : P_o, shape (m, 2) [m].
    weights : shape (m,), ≥ 0 and not all 0, or None for 1 each.
    noise_sd : σ_n of a task reading, in the unit of the signal, > 0.
    test_noise_sd : σ_o under convention (b); None for σ_n.
    convention : which variables are noisy.

    Raises InputError naming the offending entry.
    """

    kernel: SquaredExponential
    tests: Floats
    weights: Floats | None = None
    noise_sd: float = 1.0
    test_noise_sd: float | None = None
    convention: Convention = Convention.BOTH_NOISY
    _eigenpairs: tuple[Floats, Floats] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for label in ("noise_sd", "test_noise_sd"):
            value = getattr(self, label)
            if value is not None and not SMALLEST <= value <= LARGEST:
                raise InputError(f"criterion: {label} must be positive and finite, to {LARGEST:g}, got {value}")
            if value is not None and value < LEAST_NOISE * self.kernel.signal_sd:
                raise InputError(
                    f"criterion: {label} must be at least {LEAST_NOISE:g} times the signal sd, got {value} for "
                    f"{self.kernel.signal_sd:g}: below, determinants drown in rounding"
                )
        tests = _checked_tests(self.tests)
        weights = np.ones(len(tests)) if self.weights is None else _checked_weights(self.weights, len(tests))
        object.__setattr__(self, "tests", tests[weights > 0])
        object.__setattr__(self, "weights", weights[weights > 0])

    def under(self, convention: Convention) -> Criterion:
        """Return the same criterion under another noise convention; the eigenvectors are shared."""
        return dataclasses.replace(self, convention=Convention(convention), _eigenpairs=self._spectrum)

    @property
    def scales(self) -> Floats:
        """(l_x, l_y) [m], shape (2,)."""
        return np.asarray(self.kernel.length_scales)

    @property
    def noise(self) -> float:
        """Variance σ_n² of a task reading."""
        return self.noise_sd**2

    @property
    def test_noise(self) -> float:
        """Variance σ_o² of a test reading of weight 1: 0 under (a)."""
        if self.convention is Convention.LATENT_TESTS:
            return 0.0
        return (self.noise_sd if self.test_noise_sd is None else self.test_noise_sd) ** 2

    @cached_property
    def _spectrum(self) -> tuple[Floats, Floats]:
        """Eigenvalues λ (r,) and vectors U (m, r) of W^½ K_o W^½, those above 1e-13 of the largest.

        Leaving out λ_j costs I at most what reading the projection u_jᵀ x_o would add: the value stays a lower bound.
        """
        if self._eigenpairs is not None:
            return self._eigenpairs
        values, vectors = scipy.linalg.eigh(self._weighted(), driver="evd", check_finite=False)
        kept = values > 1e-13 * values[-1]
        return values[kept], np.ascontiguousarray(vectors[:, kept])

    def _weighted(self) -> Floats:
        """Return W^½ K_o W^½, shape (m, m)."""
        assert self.weights is not None
        root = np.sqrt(self.weights)
        return np.asarray(root[:, None] * self.kernel(self.tests, self.tests) * root)

    @cached_property
    def whitening(self) -> Floats:
        """The matrix (Λ + σ_o²)^(−½) Uᵀ W^½, shape (r, m): φ(x) = whitening · k(P_o, x); r = 0 for IG."""
        if self.convention is Convention.INFORMATION_GAIN:
            return np.zeros((0, len(self.tests)))
        assert self.weights is not None
        values, vectors = self._spectrum
        return np.asarray(vectors.T * np.sqrt(self.weights) / np.sqrt(values + self.test_noise)[:, None])

    def features(self, points: Floats) -> Floats:
        """Return φ(x_i) as columns, shape (r, n)."""
        return np.asarray(self.whitening @ self.kernel(self.tests, points))

    def value(self, points: ArrayLike) -> float:
        """Return I [nats] for `points` (n, 2) [m]."""
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        prior = self.kernel(p, p)
        phi = self.features(p)
        noise = self.noise * np.eye(len(p))
        return 0.5 * (log_det(prior + noise) - log_det(self.posterior(prior, phi, phi) + noise))

    def posterior(self, prior: Floats, left: Floats, right: Floats) -> Floats:
        """Return c from k and the features of its arguments, shape of `prior`; 0 for IG, which leaves nothing open."""
        if self.convention is Convention.INFORMATION_GAIN:
            return np.zeros_like(prior)
        return np.asarray(prior - left.T @ right)

    def ceiling(self) -> float:
        """Return a bound on I [nats] that no number of tasks passes: what noisy tests hold; inf under (a) and IG."""
        if self.convention is not Convention.BOTH_NOISY:
            return math.inf
        prior = self._weighted()
        return 0.5 * log_det(np.eye(len(prior)) + prior / self.test_noise)


def log_det(matrix: Floats) -> float:
    """Return log det of a symmetric positive definite matrix."""
    return 2.0 * float(np.log(np.diagonal(np.linalg.cholesky(matrix))).sum())


def _checked_tests(tests: ArrayLike) -> Floats:
    try:
        p = np.array(tests, dtype=float)
    except (TypeError, ValueError):
        raise InputError("test points: must be pairs of numbers [m]") from None
    if p.ndim != 2 or p.shape[1] != 2:
        raise InputError(f"test points: must have shape (m, 2), got {p.shape}")
    if len(p) == 0:
        raise InputError("test points: there is none inside the region")
    if len(p) > MOST_TESTS:
        raise InputError(f"test points: there are {len(p)} inside the region, at most {MOST_TESTS} can be used")
    if not np.isfinite(p).all():
        i = int(np.argwhere(~np.isfinite(p))[0][0])
        raise InputError(f"test points: point {i} is not finite ({p[i].tolist()})")
    return p


def _checked_weights(weights: ArrayLike, count: int) -> Floats:
    w = np.array(weights, dtype=float).reshape(-1)
    if len(w) != count:
        raise InputError(f"weights: there are {len(w)} for {count} test points")
    for bad, what in ((~np.isfinite(w), "not a finite number"), (w < 0, "negative")):
        if bad.any():
            i = int(np.flatnonzero(bad)[0])
            raise InputError(f"weights: the weight of test point {i} is {what} ({w[i]})")
    if not w.any():
        raise InputError("weights: all are 0, so no test point is left")
    return w
