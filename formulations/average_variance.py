"""Average variance: how little is left unknown at the targets, on average, once a set of readings is known.

    J(X) = Σ_g w_g var(f(g) | readings at X and S) / Σ_g w_g

Weighted, it is the A-criterion of optimal design (Pukelsheim 1993, §6): what a person means by "roads matter more".
Only the places of readings enter, not what was read. With C = K_XX + σ² I over X and the known S together, and
α = C⁻¹ k(X ∪ S, G), the gradient by the place of reading i of X is

    ∂J/∂x_i = −2 Σ_g w_g α_ig ∂_1 k(x_i, g) + 2 Σ_j (α diag(w) αᵀ)_ij ∂_1 k(x_i, x_j),

∂_1 being the derivative by the first argument. S is eliminated once, so that only matrices of the size of X are
factorised anew.

A field that drifts has the covariance k(x, x') e^{−|t − t'|/τ}, and J is of the field as it is when the last reading is
made. The gradient is by places alone: a UAV reads by the clock, whichever way it takes.

Lower bound, for any n readings anywhere, replicates included. With φ(x) the feature of x in the kernel's Hilbert space
(conditioned on S), T = Σ_g w_g φ_g φ_gᵀ has the eigenvalues λ_1 ≥ λ_2 ≥ … of W^½ K_GG W^½; A = Σ_i φ(x_i)φ(x_i)ᵀ/σ²
has rank ≤ n and trace ≤ b = n max k(x, x)/σ²; J = tr T (I + A)⁻¹ and, by von Neumann's trace inequality,

    J ≥ min_{a ≥ 0, Σa ≤ b} Σ_{i≤n} λ_i/(1 + a_i) + Σ_{i>n} λ_i
      ≥ Σ_{i≤n} (2 √(λ_i μ) − μ if λ_i > μ, else λ_i) − μ b + Σ_{i>n} λ_i      for every μ ≥ 0 (weak duality).

The best μ fills water, 1 + a_i = √(λ_i/μ); as any μ gives a bound, rounding of μ does not void it. It holds where the
field drifts, too: readings of ages a_i tell what fresh ones would with noise that has (e^{2 min(a_i, a_j)} − 1) k_ij
more covariance, which is no negative matrix.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_solve, cholesky, eigvalsh, solve_triangular

from formulations.kernel import Kernel
from instances.arrays import Floats
from instances.errors import InputError

ROUNDING = 4.0 * np.finfo(float).eps
"""Times the number of targets and the largest eigenvalue: what eigenvalues are lowered by, more than their error."""


@dataclass(frozen=True, eq=False)
class AverageVariance:
    """The weighted mean over targets of the variance that readings leave.

    kernel : prior covariance of the field.
    noise_sd : σ > 0 of a reading, in the field's unit.
    targets : G, shape (p, 2) [m], where the field is to be known.
    weights : w ≥ 0, shape (p,), not all 0; only their ratios matter. None for 1 each.
    known : S, shape (s, 2) [m], readings that are there already.
    tau : time in which the field's correlation falls to 1/e [s], infinite where it stays.
    known_times : when S was read, shape (s,) [s]; all at 0 where empty.

    Raises InputError naming the offending entry.
    """

    kernel: Kernel
    noise_sd: float
    targets: Floats
    weights: Floats | None = None
    known: Floats = field(default_factory=lambda: np.empty((0, 2)))
    tau: float = math.inf
    known_times: Floats = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        for name, value in (("noise_sd", self.noise_sd), ("tau", self.tau)):
            if not value > 0:
                raise InputError(f"average variance: {name} must be positive, got {value}")
        for name in ("targets", "known"):
            object.__setattr__(self, name, _places(getattr(self, name), name))
        count = len(self.targets)
        if count == 0:
            raise InputError("average variance: there is no target")
        weights = np.ones(count) if self.weights is None else np.asarray(self.weights, dtype=float).reshape(-1)
        if len(weights) != count:
            raise InputError(f"average variance: there are {len(weights)} weights for {count} targets")
        if not (np.isfinite(weights).all() and (weights >= 0).all() and weights.any()):
            raise InputError("average variance: weights must be finite, not negative and not all 0")
        object.__setattr__(self, "weights", weights)
        if self.kernel.relative_sd is not None and not self._at_targets[weights > 0].any():
            raise InputError("prior_sd: 0 at every test point that counts: nothing is left to learn there")
        times = self.known_times if len(self.known_times) else np.zeros(len(self.known))
        object.__setattr__(self, "known_times", _times(times, len(self.known)))

    def value(self, points: ArrayLike, times: ArrayLike | None = None) -> float:
        """Return J, in the field's unit squared, after readings at `points` (n, 2) [m].

        times : when they are made, (n,) [s], 0 unless given; looked at where the field drifts.
        """
        return float(self.shares @ self.variances(points, times))

    def variances(self, points: ArrayLike, times: ArrayLike | None = None) -> Floats:
        """Return the variance left at every target, shape (p,); arguments as of `value`."""
        return self._solved(_places(points, "points"), times).variances

    def __call__(self, points: ArrayLike, times: ArrayLike | None = None) -> tuple[float, Floats]:
        """Return J and ∂J/∂points [1/m], shape (n, 2); arguments as of `value`."""
        x = _places(points, "points")
        left = self._solved(x, times)
        weighted = left.alpha * self.shares
        pairs = weighted @ left.alpha.T
        with_known = (weighted @ self._prior.alpha.T) * left.aged - pairs @ left.from_known
        drift = self._drift(left.times, left.times)
        gradient = slope_sums(self.kernel, x, self.targets, -weighted * left.faded)
        gradient += slope_sums(self.kernel, x, x, pairs * drift)
        gradient += slope_sums(self.kernel, x, self.known, with_known * self._drift(left.times, self.known_times))
        return float(self.shares @ left.variances), 2.0 * gradient

    def lower_bound(self, count: int) -> float:
        """Return a J that no `count` further readings pass from above, wherever they are taken, replicates included.

        They are made when S is read or later.
        """
        spectrum = self._spectrum
        budget = count * self.highest_variance / self.noise_sd**2
        return _filled(spectrum[:count], budget) + float(spectrum[count:].sum())

    @property
    def highest_variance(self) -> float:
        """An upper bound of k(x, x) anywhere."""
        return self.kernel.signal_sd**2

    @cached_property
    def shares(self) -> Floats:
        """w/Σw, shape (p,)."""
        weights = np.asarray(self.weights)
        return np.asarray(weights / weights.sum())

    @cached_property
    def _spectrum(self) -> Floats:
        """Lower bounds of λ_1 ≥ λ_2 ≥ … of W^½ K_GG W^½, conditioned on S, shape (p,)."""
        root = np.sqrt(self.shares)
        prior = self.kernel(self.targets, self.targets) - self._prior.half.T @ self._prior.half
        values = eigvalsh(root[:, None] * prior * root, driver="evd", check_finite=False)[::-1]
        whole = self.kernel.signal_sd**2  # rounding is relative to what was subtracted from
        return np.maximum(values - ROUNDING * len(values) * whole, 0.0)

    @cached_property
    def _prior(self) -> _Known:
        """What the known readings leave when the last of them is made."""
        covariance = self.kernel(self.known, self.known) * self._drift(self.known_times, self.known_times)
        covariance[np.diag_indices_from(covariance)] += self.noise_sd**2
        factor = cholesky(covariance, lower=True, check_finite=False)
        to_targets = self.kernel(self.known, self.targets) * self._drift(self.known_times, self._last_known)
        half = solve_triangular(factor, to_targets, lower=True, check_finite=False)
        alpha = solve_triangular(factor, half, lower=True, trans="T", check_finite=False)
        return _Known(factor, half, alpha, np.einsum("ig,ig->g", half, half))

    @cached_property
    def _at_targets(self) -> Floats:
        """k(g, g), shape (p,)."""
        return self.kernel.variance(self.targets)

    @property
    def _last_known(self) -> Floats:
        """When the last known reading is made, shape (1,) [s]; −∞ where there is none."""
        return np.max(self.known_times, initial=-math.inf, keepdims=True)

    def _drift(self, a: Floats, b: Floats) -> Floats | float:
        """Return e^{−|a_i − b_j|/τ} of times `a` (n,) and `b` (q,) [s], shape (n, q)."""
        return 1.0 if math.isinf(self.tau) else np.asarray(np.exp(-np.abs(np.subtract.outer(a, b)) / self.tau))

    def _solved(self, x: Floats, times: ArrayLike | None) -> _Left:
        """Condition what S leaves on readings at `x` (n, 2), made at `times`."""
        known, t = self._prior, np.zeros(len(x)) if times is None else _times(times, len(x))
        end = np.maximum(np.max(t, initial=-math.inf, keepdims=True), self._last_known)
        faded, aged = self._drift(t, end), 1.0 if not len(self.known) else self._drift(self._last_known, end)
        drift = self._drift(self.known_times, t)
        cross = solve_triangular(known.factor, self.kernel(self.known, x) * drift, lower=True, check_finite=False)
        covariance = self.kernel(x, x) * self._drift(t, t) - cross.T @ cross
        covariance[np.diag_indices_from(covariance)] += self.noise_sd**2
        to_targets = self.kernel(x, self.targets) * faded - (cross.T @ known.half) * aged
        alpha = cho_solve((cholesky(covariance, lower=True, check_finite=False), True), to_targets, check_finite=False)
        before = self._at_targets - known.told * np.ravel(aged) ** 2
        variances = np.maximum(before - np.einsum("ig,ig->g", to_targets, alpha), 0.0)
        from_known = solve_triangular(known.factor, cross, lower=True, trans="T", check_finite=False).T
        return _Left(variances, alpha, from_known, t, faded, aged)


class _Known(NamedTuple):
    """Of S: the factor L of C_S, L⁻¹k(S, G), C_S⁻¹k(S, G), both (s, p), and by how much variances fall, (p,)."""

    factor: Floats
    half: Floats
    alpha: Floats
    told: Floats


class _Left(NamedTuple):
    """Variances at the targets (p,), the rows of α of X (n, p), k(X, S) C_S⁻¹ (n, s), and when X is read, (n,) [s].

    faded, aged : correlation in time of X, (n, 1), and of the last reading of S, (1, 1), with the end; 1 without drift.
    """

    variances: Floats
    alpha: Floats
    from_known: Floats
    times: Floats
    faded: Floats | float
    aged: Floats | float


def slope_sums(kernel: Kernel, a: Floats, b: Floats, factors: Floats) -> Floats:
    """Return Σ_j factors_ij ∂_1 k(a_i, b_j) for `a` (n, 2) and `b` (q, 2) [m], shape (n, 2)."""
    scales = np.asarray(kernel.length_scales)
    centre = a.mean(axis=0) if len(a) else 0.0  # places far from the origin would cancel
    p, q = (a - centre) / scales, (b - centre) / scales
    squares = np.subtract.outer(p[:, 0], q[:, 0]) ** 2
    squares += np.subtract.outer(p[:, 1], q[:, 1]) ** 2
    if (m := kernel.relative_sd) is not None:
        factors = factors * m(b)
    steep = kernel.signal_sd**2 * factors * kernel.steepness(squares)
    sums = np.asarray((steep @ q - p * steep.sum(axis=1, keepdims=True)) / scales)
    if m is None:
        return sums
    plain = kernel.signal_sd**2 * (factors * kernel.correlation(squares)).sum(axis=1)
    return m(a)[:, None] * sums + m.slope(a)[0] * plain[:, None]  # the product rule


def _filled(values: Floats, budget: float) -> float:
    """Return the best dual value, over μ, of min Σ λ_i/(1 + a_i), a ≥ 0, Σa ≤ budget; `values` fall."""
    positive = values[values > 0]
    if budget <= 0 or not len(positive):
        return float(values.sum())
    # with the k largest under water, Σ_{i≤k} (√(λ_i/μ) − 1) = budget; the right k is the last whose λ_k > μ
    levels = (np.cumsum(np.sqrt(positive)) / (budget + np.arange(1, len(positive) + 1))) ** 2
    level = float(levels[np.flatnonzero(positive > levels)[-1]])
    under = np.where(values > level, 2.0 * np.sqrt(values * level) - level, values)
    return float(under.sum()) - level * budget


def _places(points: ArrayLike, name: str) -> Floats:
    places = np.asarray(points, dtype=float).reshape(-1, 2)
    if not np.isfinite(places).all():
        raise InputError(f"average variance: {name} must be finite [m]")
    return places


def _times(times: ArrayLike, count: int) -> Floats:
    given = np.asarray(times, dtype=float).reshape(-1)
    if len(given) != count or not np.isfinite(given).all():
        raise InputError(f"average variance: {count} readings need as many finite times [s]")
    return given
