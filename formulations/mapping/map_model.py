"""What a map believes of its field, and the choice of it by restricted likelihood (`formulations.mapping.likelihood`).

Every kernel and every mean offered is fitted with one length scale in all directions, and the one of greatest
likelihood is taken. Two length scales (paper, eq. cov) are taken instead where they raise the log-likelihood by more
than ½ log N, the price of a parameter under N samples (G. Schwarz, Estimating the Dimension of a Model, Annals of
Statistics 6, 1978). They hold along x and y where planning goes on from the model; a map's hold along any direction and
across it, two parameters more at the price of one, and are tried with the likeliest kernels, not with the first alone;
there they are believed to be nearly alike, log l_1/l_2 ~ N(0, 0.3²), since 150 samples of a field without a direction
are not seldom three nats likelier with length scales of 3 : 1 along some direction, and the map is worse for it.
Kernels have as many parameters as one another, and means are told apart without a price: the likelihood has their
coefficients integrated out. A field that drifts has one parameter more, τ, and is believed where the likeliest drifting
model is ahead of the likeliest that stays by more than that price.

Where the likeliest kernel is a Matérn one, that of smoothness ½ is taken before it unless it is behind by more than
`JUMPS` nats a sample. Signals behind ridges jump where no sample lies, and between the jumps they are smooth: samples a
step apart on a track speak for what is smooth, while the map's error lies at the jumps between two tracks, where only
Matérn ½ does not swing beyond its samples. A likelihood whose model is not that of the field is to weigh less
(P. Grünwald & T. van Ommen, Bayesian Analysis 12, 2017). Draws of smoother kernels are told from ½ by more than that.
A mean that predicts shadows has the field vary with them (shadows.py) where that raises the log-likelihood by the price
of its two parameters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from formulations.blas import one_thread
from formulations.kernel import KERNELS, Kernel, Matern12, SquaredExponential
from formulations.mapping.likelihood_search import TAUS, LikelihoodSearch
from formulations.mapping.shadows import Shadows
from formulations.mapping.trend import CONSTANT, Trend
from instances.arrays import Floats

FEWEST = 8
"""With fewer samples nothing is fitted."""
MOST = 300
"""So many samples at most, evenly chosen over the record, are fitted to: the cost grows with their cube."""
TIE = 1e-3
"""Likelihoods [nats] that differ by less are a tie, which the order of what is offered decides."""
JUMPS = 0.1
"""So far [nats a sample] Matérn ½ may be behind a smoother Matérn kernel; draws of 3/2 are 0.2 ahead."""
TURNED = 2
"""So many of the likeliest kernels are tried with length scales along a direction and across it."""


@dataclass(frozen=True)
class MapModel:
    """Covariance of the field, its nugget σ₀ in the field's unit, its mean, and how it drifts.

    tau : τ > 0 [s], the field's correlation over time being exp(−|t − t′|/τ); infinite where the field stays.
    shadows : how the field varies behind obstacles, of a mean that predicts their loss; None where it varies alike.
    """

    kernel: Kernel = field(default_factory=SquaredExponential)
    nugget_sd: float = 0.0
    trend: Trend = CONSTANT
    tau: float = math.inf
    shadows: Shadows | None = None

    def __post_init__(self) -> None:
        if not self.tau > 0:
            raise ValueError(f"tau must be positive, got {self.tau}")
        if self.shadows is not None and self.trend.loss is None:
            raise ValueError(f"shadows need a mean that predicts them, and {self.trend.name} does not")

    def covariance(self, X: Floats, t: Floats, Z: Floats, u: Floats) -> Floats:
        """Return k of the field at `X` (p, 2) [m], `t` (p,) [s], and at `Z` (q, 2), `u` (q,), shape (p, q)."""
        K = self.at_once(X, Z)
        if self.tau < math.inf:
            K *= np.exp(-np.abs(np.subtract.outer(t, u)) / self.tau)
        return K

    def at_once(self, X: Floats, Z: Floats) -> Floats:
        """Return k of the field at `X` (p, 2) and at `Z` (q, 2) [m] at one time, shape (p, q)."""
        K = self.kernel(X, Z)
        if self.shadows is not None and self.trend.loss is not None:
            K *= self.shadows.share(self.trend.loss(X), self.trend.loss(Z))
        return K

    def variance(self, X: Floats) -> Floats:
        """Return k of the field at `X` (p, 2) [m] with itself, shape (p,)."""
        variance = self.kernel.variance(X)
        if self.shadows is not None and self.trend.loss is not None:
            variance *= self.shadows.relative_sd(self.trend.loss(X)) ** 2
        return variance

    def __str__(self) -> str:
        kernel = self.kernel
        lx, ly = (scale / 1e3 for scale in kernel.length_scales)
        nugget = f", nugget {self.nugget_sd:.2g}" if self.nugget_sd else ""
        drift = f", τ {self.tau:.0f} s" if self.tau < math.inf else ""
        shadows = self.shadows
        dark = f", shadows {shadows.contrast:.2g} apart, {shadows.in_sight:.2g} in sight" if shadows else ""
        along = f" along {math.degrees(kernel.direction):.0f}° and across" if kernel.direction else ""
        scales = f"σ_f {kernel.signal_sd:.1f}, l {lx:.1f} and {ly:.1f} km{along}"
        return f"{kernel.name} with {self.trend.name} mean, {scales}{nugget}{drift}{dark}"


@dataclass(frozen=True)
class Offered:
    """What may be chosen: covariances and means, in the order in which a tie is decided.

    tau : that of every model [s], infinite for fields that stay; None where it is to be told by likelihood, too.
    turned : whether two length scales may hold along any direction and across it; else they are those along x and y.
    lengths : bounds of the length scales [m]; LENGTHS unless given.
    """

    kernels: tuple[type[Kernel], ...] = tuple(KERNELS.values())
    trends: tuple[Trend, ...] = (CONSTANT,)
    tau: float | None = math.inf
    turned: bool = False
    lengths: tuple[float, float] | None = None


EVERY_KERNEL = Offered(turned=True)


@dataclass(frozen=True)
class Fitted:
    """A model chosen, and log p [nats] of every kernel and mean offered, by their names, as isotropic models.

    evidence : of drifting models where such a one was chosen, else of those that stay. drift : by how much the
    likeliest drifting model was ahead of the likeliest that stays, where both were tried.
    """

    model: MapModel
    evidence: Mapping[tuple[str, str], float] = field(default_factory=dict)
    drift: float | None = None


@one_thread()
def choose_model(
    given: MapModel,
    offered: Offered,
    noise_sd: float,
    positions: ArrayLike,
    values: ArrayLike,
    times: ArrayLike = 0.0,
) -> Fitted:
    """Return the model of greatest restricted likelihood of `values` (N,) at `positions` (N, 2) [m], `times` (N,) [s].

    given : where searches begin beside the grid; it is returned where there are fewer than FEWEST samples, or where
    they lie at one place or are all alike. Its map of the prior sd, where it has one, is kept. noise_sd : σ_n of a
    reading, in the field's unit.
    """
    X = np.asarray(positions, dtype=float).reshape(-1, 2)
    y = np.asarray(values, dtype=float).reshape(-1)
    t = np.broadcast_to(np.asarray(times, dtype=float), len(y))
    if len(y) > MOST:
        chosen = np.linspace(0, len(y) - 1, MOST).round().astype(int)
        X, y, t = X[chosen], y[chosen], t[chosen]
    if len(y) < FEWEST or not np.ptp(X, axis=0).max() > 0.0 or not y.std() > 0.0:
        return Fitted(given)
    lasted = float(np.ptp(t))
    if offered.tau is not None or not lasted > 0.0:
        bounds = None if offered.tau in (None, math.inf) else (offered.tau, offered.tau)
        best = _likeliest(given, offered, noise_sd, (X, y, t), bounds)
        return Fitted(given) if best is None else best.fitted()
    stays = _likeliest(given, offered, noise_sd, (X, y, t), None)
    drifts = _likeliest(given, offered, noise_sd, (X, y, t), (TAUS[0] * lasted, TAUS[1] * lasted))
    if stays is None or drifts is None:
        return Fitted(given)
    ahead = drifts.value - stays.value
    return (drifts if ahead > 0.5 * np.log(len(y)) else stays).fitted(ahead)


@dataclass(frozen=True)
class _Likeliest:
    """The likeliest isotropic models of those offered, of one mean: its search, and log p and θ by kernel, best first.

    evidence : log p of all. turned : whether length scales may hold along any direction.
    """

    search: LikelihoodSearch
    found: Mapping[type[Kernel], tuple[float, Floats]]
    evidence: Mapping[tuple[str, str], float]
    turned: bool

    @property
    def value(self) -> float:
        """The greatest log p [nats]."""
        return max(value for value, _ in self.found.values())

    def fitted(self, drift: float | None = None) -> Fitted:
        """Return the model, with two length scales where they are worth it."""
        search, credit = self.search, self._credit()
        ranked = sorted(self.found, key=lambda each: -round((self.found[each][0] + credit.get(each, 0.0)) / TIE))
        kernel, direction = ranked[0], 0.0
        value, theta = self.found[kernel]
        if not self.turned:
            theta = search.anisotropic(kernel, value, theta)
        else:
            worth = value + credit.get(kernel, 0.0)
            for each in ranked[:TURNED]:
                higher, better, along = search.turned(each, self.found[each][1])
                higher += credit.get(each, 0.0) - search.price
                if higher > worth:
                    kernel, worth, theta, direction = each, higher, better, along
        return Fitted(_model(kernel, theta, direction, search), self.evidence, drift)

    def _credit(self) -> dict[type[Kernel], float]:
        """Return how far a kernel may be behind [nats] and be taken all the same."""
        likeliest = next(iter(self.found))
        return {} if likeliest is SquaredExponential else {Matern12: JUMPS * self.search.count}


def _likeliest(
    given: MapModel,
    offered: Offered,
    noise_sd: float,
    samples: tuple[Floats, Floats, Floats],
    taus: tuple[float, float] | None,
) -> _Likeliest | None:
    """Return the likeliest of the kernels and means offered, None where none can be fitted. taus : bounds of τ [s]."""
    found: dict[tuple[str, str], tuple[float, Floats]] = {}
    mapped, warm = given.kernel.relative_sd, (given.kernel, given.nugget_sd, given.tau)
    prior = (mapped, offered.lengths)
    searches = {trend.name: LikelihoodSearch(noise_sd, *samples, trend, taus, *prior) for trend in offered.trends}
    for name, search in searches.items():
        for kernel in offered.kernels:
            found[kernel.name, name] = search.isotropic(kernel, *warm)
    evidence = {names: value for names, (value, _) in found.items() if np.isfinite(value)}
    if not evidence:
        return None
    ranked = sorted(evidence, key=lambda names: -round(evidence[names] / TIE))
    _, mean = ranked[0]
    likely = {KERNELS[kernel]: found[kernel, of] for kernel, of in ranked if of == mean}
    trend = searches[mean].trend
    if trend.loss is None or not np.ptp(trend.loss(samples[0])) > 0.0:
        return _Likeliest(searches[mean], likely, evidence, offered.turned)
    search = LikelihoodSearch(noise_sd, *samples, trend, taus, *prior, shadowed=True)
    shadowed = {kernel: search.isotropic(kernel, *warm) for kernel in likely}
    if not max(value for value, _ in shadowed.values()) > max(value for value, _ in likely.values()):
        return _Likeliest(searches[mean], likely, evidence, offered.turned)
    evidence |= {(kernel.name, mean): float(value) for kernel, (value, _) in shadowed.items() if np.isfinite(value)}
    likely = {kernel: each for kernel, each in shadowed.items() if np.isfinite(each[0])}
    likely = dict(sorted(likely.items(), key=lambda each: -round(each[1][0] / TIE)))
    return _Likeliest(search, likely, evidence, offered.turned)


def _model(kernel: type[Kernel], theta: Floats, direction: float, search: LikelihoodSearch) -> MapModel:
    signal, lx, ly, nugget, *more = (float(value) for value in np.exp(theta))
    tau = more.pop(0) if search.drift else math.inf
    shadows = Shadows(*more) if more else None
    return MapModel(kernel(signal, (lx, ly), search.mapped, direction), nugget, search.trend, tau, shadows)
