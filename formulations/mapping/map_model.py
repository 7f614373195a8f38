"""What a map believes of its field, and the choice of it by restricted likelihood (`formulations.mapping.likelihood`).

Every kernel and every mean offered is fitted with one length scale in all directions, and the one of greatest
likelihood is taken. Two length scales (paper, eq. cov) are taken instead where they raise the log-likelihood by more
than ½ log N, the price of a parameter under N samples (G. Schwarz, Estimating the Dimension of a Model, Annals of
Statistics 6, 1978). They hold along x and y where planning goes on from the model; a map's hold along any direction and
across it, two parameters more at the price of one (½ log N is 2.7 nats of 213 samples; for prediction, which is a map's
aim, Akaike asks 2), and are tried with the likeliest kernels, not with the first alone. Kernels have as many
parameters as one another, and means are told apart without a price: the likelihood has their coefficients integrated
out. A field that drifts has one parameter more, τ, and is believed where the likeliest drifting model is ahead of the
likeliest that stays by more than that price.

Where the likeliest kernel is a Matérn one, that of smoothness ½ is taken before it unless it is behind by more than
`JUMPS` nats a sample. Signals behind ridges jump where no sample lies, and between the jumps they are smooth: samples a
step apart on a track speak for what is smooth, while the map's error lies at the jumps between two tracks, where only
Matérn ½ does not swing beyond its samples. A likelihood whose model is not that of the field is to weigh less
(P. Grünwald & T. van Ommen, Bayesian Analysis 12, 2017). Draws of smoother kernels are told from ½ by more than that.
A mean that may divide the field (trend.py) does so where that raises the log-likelihood by the price of its parameter.

The likelihood of few samples has several peaks, and a search that begins where the last one ended stays on the wrong
one for the rest of a survey. So each search also begins at the best of a grid of length scales.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError
from scipy.optimize import minimize

from formulations.blas import one_thread
from formulations.kernel import KERNELS, Kernel, Matern12, SquaredExponential
from formulations.mapping.likelihood import RestrictedLikelihood
from formulations.mapping.trend import CONSTANT, Trend
from instances.arrays import Floats
from instances.environment.value_map import ValueMap

FEWEST = 8
"""With fewer samples nothing is fitted."""
MOST = 300
"""So many samples at most, evenly chosen over the record, are fitted to: the cost grows with their cube."""
SHARES = (0.03, 0.08, 0.2, 0.5)
"""Length scales of the grid, in extents of the samples."""
SIGNALS, NUGGETS = (1e-2, 1e4), (1e-3, 50.0)
"""Bounds of σ_f and of the nugget σ₀, in sensor noises."""
LENGTHS = (0.005, 10.0)
"""Bounds of the length scales, in extents of the samples."""
TAU_SHARES = (0.1, 0.5, 2.0)
"""τ of the grid, in durations of the record."""
TAUS = (0.01, 100.0)
"""Bounds of τ, in durations of the record."""
CONTRASTS = (0.3, 2.0)
"""c of the grid, in standard deviations of what is predicted at the samples."""
WIDEST = (0.01, 100.0)
"""Bounds of c, likewise."""
TIE = 1e-3
"""Likelihoods [nats] that differ by less are a tie, which the order of what is offered decides."""
QUIET = 0.3
"""The nugget at which a search begins, in sensor noises."""
JUMPS = 0.1
"""So far [nats a sample] Matérn ½ may be behind a smoother Matérn kernel; draws of 3/2 are 0.2 ahead."""
TURNED = 2
"""So many of the likeliest kernels are tried with length scales along a direction and across it."""
DIRECTIONS = (0.0, 0.25 * math.pi, 0.5 * math.pi, 0.75 * math.pi)
"""Those at which such a search may begin [rad]."""
STRETCH = 0.5
"""log √(l_1/l_2) there."""


@dataclass(frozen=True)
class MapModel:
    """Covariance of the field, its nugget σ₀ in the field's unit, its mean, and how it drifts and is divided.

    tau : τ > 0 [s], the field's correlation over time being exp(−|t − t′|/τ); infinite where the field stays.
    contrast : c > 0 in the mean's unit, the correlation being exp(−|p − p′|/c) beside that over space, of what the mean
    predicts; infinite where that does not divide the field.
    """

    kernel: Kernel = field(default_factory=SquaredExponential)
    nugget_sd: float = 0.0
    trend: Trend = CONSTANT
    tau: float = math.inf
    contrast: float = math.inf

    def __post_init__(self) -> None:
        for name, value in (("tau", self.tau), ("contrast", self.contrast)):
            if not value > 0:
                raise ValueError(f"{name} must be positive, got {value}")

    def covariance(self, X: Floats, t: Floats, Z: Floats, u: Floats) -> Floats:
        """Return k of the field at `X` (p, 2) [m], `t` (p,) [s], and at `Z` (q, 2), `u` (q,), shape (p, q)."""
        K = self.at_once(X, Z)
        if self.tau < math.inf:
            K *= np.exp(-np.abs(np.subtract.outer(t, u)) / self.tau)
        return K

    def at_once(self, X: Floats, Z: Floats) -> Floats:
        """Return k of the field at `X` (p, 2) and at `Z` (q, 2) [m] at one time, shape (p, q)."""
        K = self.kernel(X, Z)
        if self.contrast < math.inf:
            predicted, other = (self.trend.columns(points)[:, 1] for points in (X, Z))
            K *= np.exp(-np.abs(np.subtract.outer(predicted, other)) / self.contrast)
        return K

    def __str__(self) -> str:
        kernel = self.kernel
        lx, ly = (scale / 1e3 for scale in kernel.length_scales)
        nugget = f", nugget {self.nugget_sd:.2g}" if self.nugget_sd else ""
        drift = f", τ {self.tau:.0f} s" if self.tau < math.inf else ""
        divided = f", divided at {self.contrast:.2g}" if self.contrast < math.inf else ""
        along = f" along {math.degrees(kernel.direction):.0f}° and across" if kernel.direction else ""
        scales = f"σ_f {kernel.signal_sd:.1f}, l {lx:.1f} and {ly:.1f} km{along}"
        return f"{kernel.name} with {self.trend.name} mean, {scales}{nugget}{drift}{divided}"


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

    search: _Search
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
    mapped = given.kernel.relative_sd
    prior = (mapped, offered.lengths)
    searches = {trend.name: _Search(noise_sd, *samples, trend, taus, *prior) for trend in offered.trends}
    for name, search in searches.items():
        for kernel in offered.kernels:
            found[kernel.name, name] = search.isotropic(kernel, given)
    evidence = {names: value for names, (value, _) in found.items() if np.isfinite(value)}
    if not evidence:
        return None
    ranked = sorted(evidence, key=lambda names: -round(evidence[names] / TIE))
    _, mean = ranked[0]
    likely = {KERNELS[kernel]: found[kernel, of] for kernel, of in ranked if of == mean}
    if not searches[mean].trend.divides:
        return _Likeliest(searches[mean], likely, evidence, offered.turned)
    search = _Search(noise_sd, *samples, searches[mean].trend, taus, *prior, divided=True)
    divided = {kernel: search.isotropic(kernel, given) for kernel in likely}
    if not max(value for value, _ in divided.values()) > max(value for value, _ in likely.values()):
        return _Likeliest(searches[mean], likely, evidence, offered.turned)
    evidence |= {(kernel.name, mean): float(value) for kernel, (value, _) in divided.items() if np.isfinite(value)}
    likely = dict(sorted(divided.items(), key=lambda each: -round(each[1][0] / TIE)))
    return _Likeliest(search, likely, evidence, offered.turned)


class _Search:
    """Searches for the peak of the likelihood of samples under one mean.

    taus : bounds of τ [s], the same twice where it is known; None for fields that stay. lengths : as in `Offered`.
    divided : whether the mean divides the field, whose one parameter more, c, is paid for in every log p found.
    """

    def __init__(
        self,
        noise_sd: float,
        X: Floats,
        y: Floats,
        t: Floats,
        trend: Trend,
        taus: tuple[float, float] | None,
        mapped: ValueMap | None,
        lengths: tuple[float, float] | None = None,
        *,
        divided: bool = False,
    ) -> None:
        times, relative_sd = None if taus is None else t, None if mapped is None else mapped(X)
        self.likelihood = RestrictedLikelihood(noise_sd, X, y, trend, times, relative_sd, divided=divided)
        self.mapped = mapped
        self.trend, self.noise_sd, self.spread = trend, noise_sd, float(y.std())
        self.extent, self.lasted = float(np.ptp(X, axis=0).max()), float(np.ptp(t))
        self.lengths = (LENGTHS[0] * self.extent, LENGTHS[1] * self.extent) if lengths is None else lengths
        self.count, self.price = len(y), 0.5 * np.log(len(y))
        self.drift = [] if taus is None else [(np.log(taus[0]), np.log(taus[1]))]
        predicted = self.likelihood.H[:, 1].std() if divided else 0.0
        self.contrasts = np.log(predicted * np.array(CONTRASTS)) if divided else np.empty(0)
        self.division = [(np.log(WIDEST[0] * predicted), np.log(WIDEST[1] * predicted))] if divided else []
        self.toll = self.price if divided else 0.0

    def isotropic(self, kernel: type[Kernel], given: MapModel) -> tuple[float, Floats]:
        """Return the greatest log p found with l_x = l_y, and its θ; −∞ where there is none."""
        signal, nugget = np.log(self.spread), np.log(QUIET * self.noise_sd)
        lengths = [np.log(share * self.extent) for share in SHARES]
        grid = [np.array([signal, length, nugget, *more]) for length in lengths for more in self._further()]
        own, scale = given.kernel, float(np.mean(np.log(given.kernel.length_scales)))
        known = np.array([np.log(own.signal_sd), scale, np.log(max(given.nugget_sd, QUIET * self.noise_sd))])
        last = self._further()[-1]
        if self.drift and given.tau < math.inf:
            last[0] = np.log(given.tau)
        warm = np.append(known, last)
        value = partial(self._value, kernel)
        starts = [max(grid, key=lambda theta: value(_both(theta))), *([warm] if isinstance(own, kernel) else [])]

        def evaluate(short: Floats) -> tuple[float, Floats]:
            height, gradient = self.likelihood(kernel, _both(short))
            return height, _fold(gradient)

        found = [self._climb(evaluate, start, self._bounds(1)) for start in starts]
        best, short = max(found, key=lambda each: each[0])
        return best, _both(short)

    def _further(self) -> list[list[float]]:
        """Return what θ ends in on the grid: log τ where the field drifts, then log c where the mean divides it."""
        taus = self._taus()
        return [[*tau, c] for tau in taus for c in self.contrasts] if self.division else taus

    def _taus(self) -> list[list[float]]:
        """Return log τ of each share, nothing where the field stays."""
        if not self.drift:
            return [[]]
        low, high = self.drift[0]
        if not low < high:
            return [[low]]
        return [[float(np.clip(np.log(share * self.lasted), low, high))] for share in TAU_SHARES]

    def anisotropic(self, kernel: type[Kernel], value: float, theta: Floats) -> Floats:
        """Return θ with two length scales where they are worth their price, else the isotropic `theta`."""
        scales = np.log(np.array(SHARES) * self.extent)
        grid = [np.array([theta[0], lx, ly, *theta[3:]]) for lx, ly in product(scales, scales) if lx != ly]
        starts = (theta, max(grid, key=partial(self._value, kernel)))
        found = [self._climb(partial(self.likelihood, kernel), start, self._bounds(2)) for start in starts]
        higher, better = max(found, key=lambda each: each[0])
        return better if higher > value + self.price else theta

    def turned(self, kernel: type[Kernel], theta: Floats) -> tuple[float, Floats, float]:
        """Return the greatest log p found with l_1 ≠ l_2 along and across a direction, from an isotropic θ; θ and φ."""
        stretched = np.array([theta[0], theta[1] + STRETCH, theta[2] - STRETCH, *theta[3:]])
        likeliest = sorted(DIRECTIONS, key=lambda each: -self._value(kernel, stretched, each))
        bounds = [*self._bounds(2), (-2 * math.pi, 2 * math.pi)]

        def evaluate(both: Floats) -> tuple[float, Floats]:
            return self.likelihood(kernel, both[:-1], both[-1])

        found = [self._climb(evaluate, np.append(stretched, each), bounds) for each in likeliest[:2]]
        value, best = max(found, key=lambda each: each[0])
        return value, best[:-1], float((best[-1] + 0.5 * math.pi) % math.pi - 0.5 * math.pi)

    def _value(self, kernel: type[Kernel], theta: Floats, direction: float | None = None) -> float:
        try:
            return self.likelihood.value(kernel, theta, direction)
        except LinAlgError:
            return -np.inf

    def _climb(
        self,
        evaluate: Callable[[Floats], tuple[float, Floats]],
        start: Floats,
        bounds: Sequence[tuple[float, float]],
    ) -> tuple[float, Floats]:
        """Return the peak above `start` within `bounds`; `evaluate` returns log p and its gradient."""

        def negative(parameters: Floats) -> tuple[float, Floats]:
            try:
                value, gradient = evaluate(parameters)
            except LinAlgError:
                return np.inf, np.zeros_like(parameters)
            return -value, -gradient

        begin = np.clip(start, *np.transpose(bounds))
        found = minimize(negative, begin, jac=True, method="L-BFGS-B", bounds=bounds)
        return -float(found.fun) - self.toll, found.x

    def _bounds(self, lengths: int) -> list[tuple[float, float]]:
        length = (np.log(self.lengths[0]), np.log(self.lengths[1]))
        signal, nugget = (
            (np.log(low * self.noise_sd), np.log(high * self.noise_sd)) for low, high in (SIGNALS, NUGGETS)
        )
        return [signal, *[length] * lengths, nugget, *self.drift, *self.division]


def _both(short: Floats) -> Floats:
    """Return θ of (log σ_f, log l, log σ₀), or of these and what follows."""
    return np.insert(short, 2, short[1])


def _fold(gradient: Floats) -> Floats:
    return np.array([gradient[0], gradient[1] + gradient[2], *gradient[3:]])


def _model(kernel: type[Kernel], theta: Sequence[float] | Floats, direction: float, search: _Search) -> MapModel:
    signal, lx, ly, nugget, *more = (float(value) for value in np.exp(theta))
    tau = more.pop(0) if search.drift else math.inf
    contrast = more.pop(0) if search.division else math.inf
    return MapModel(kernel(signal, (lx, ly), search.mapped, direction), nugget, search.trend, tau, contrast)
