"""What a map believes of its field, and the choice of it by restricted likelihood (`formulations.mapping.likelihood`).

Every kernel and every mean offered is fitted with one length scale in all directions, and the one of greatest
likelihood is taken. Two length scales (paper, eq. cov) are taken instead where they raise the log-likelihood by more
than ½ log N, the price of a parameter under N samples (G. Schwarz, Estimating the Dimension of a Model, Annals of
Statistics 6, 1978). Kernels have as many parameters as one another, and means are told apart without a price: the
likelihood has their coefficients integrated out.

The likelihood of few samples has several peaks, and a search that begins where the last one ended stays on the wrong
one for the rest of a survey. So each search also begins at the best of a grid of length scales.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError
from scipy.optimize import minimize

from formulations.blas import one_thread
from formulations.kernel import KERNELS, Kernel, SquaredExponential
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
"""Bounds of σ_f and of τ, in sensor noises."""
LENGTHS = (0.005, 10.0)
"""Bounds of the length scales, in extents of the samples."""
TIE = 1e-3
"""Likelihoods [nats] that differ by less are a tie, which the order of what is offered decides."""
QUIET = 0.3
"""The nugget at which a search begins, in sensor noises."""


@dataclass(frozen=True)
class MapModel:
    """Covariance of the field, its nugget τ in the field's unit, and its mean."""

    kernel: Kernel = field(default_factory=SquaredExponential)
    nugget_sd: float = 0.0
    trend: Trend = CONSTANT

    def __str__(self) -> str:
        kernel = self.kernel
        lx, ly = (scale / 1e3 for scale in kernel.length_scales)
        nugget = f", nugget {self.nugget_sd:.2g}" if self.nugget_sd else ""
        return (
            f"{kernel.name} with {self.trend.name} mean, σ_f {kernel.signal_sd:.1f}, l {lx:.1f} and {ly:.1f} km{nugget}"
        )


@dataclass(frozen=True)
class Offered:
    """What may be chosen: covariances and means, in the order in which a tie is decided."""

    kernels: tuple[type[Kernel], ...] = tuple(KERNELS.values())
    trends: tuple[Trend, ...] = (CONSTANT,)


EVERY_KERNEL = Offered()


@dataclass(frozen=True)
class Fitted:
    """A model chosen, and log p [nats] of every kernel and mean offered, by their names, as isotropic models."""

    model: MapModel
    evidence: Mapping[tuple[str, str], float] = field(default_factory=dict)


@one_thread()
def choose_model(given: MapModel, offered: Offered, noise_sd: float, positions: ArrayLike, values: ArrayLike) -> Fitted:
    """Return the model of greatest restricted likelihood of `values` (N,) at `positions` (N, 2) [m].

    given : where searches begin beside the grid; it is returned where there are fewer than FEWEST samples, or where
    they lie at one place or are all alike. Its map of the prior sd, where it has one, is kept. noise_sd : σ_n of a
    reading, in the field's unit.
    """
    X = np.asarray(positions, dtype=float).reshape(-1, 2)
    y = np.asarray(values, dtype=float).reshape(-1)
    if len(y) > MOST:
        chosen = np.linspace(0, len(y) - 1, MOST).round().astype(int)
        X, y = X[chosen], y[chosen]
    if len(y) < FEWEST or not np.ptp(X, axis=0).max() > 0.0 or not y.std() > 0.0:
        return Fitted(given)
    found: dict[tuple[str, str], tuple[float, Floats]] = {}
    mapped = given.kernel.relative_sd
    searches = {trend.name: _Search(noise_sd, X, y, trend, mapped) for trend in offered.trends}
    for name, search in searches.items():
        for kernel in offered.kernels:
            found[kernel.name, name] = search.isotropic(kernel, given)
    evidence = {names: value for names, (value, _) in found.items() if np.isfinite(value)}
    if not evidence:
        return Fitted(given)
    best = max(evidence, key=lambda names: round(evidence[names] / TIE))
    trend = next(trend for trend in offered.trends if trend.name == best[1])
    theta = searches[best[1]].anisotropic(KERNELS[best[0]], *found[best])
    return Fitted(_model(KERNELS[best[0]], theta, trend, mapped), evidence)


class _Search:
    """Searches for the peak of the likelihood of samples under one mean."""

    def __init__(self, noise_sd: float, X: Floats, y: Floats, trend: Trend, mapped: ValueMap | None) -> None:
        self.likelihood = RestrictedLikelihood(noise_sd, X, y, trend, None if mapped is None else mapped(X))
        self.noise_sd, self.spread = noise_sd, float(y.std())
        self.extent = float(np.ptp(X, axis=0).max())
        self.price = 0.5 * np.log(len(y))

    def isotropic(self, kernel: type[Kernel], given: MapModel) -> tuple[float, Floats]:
        """Return the greatest log p found with l_x = l_y, and its θ; −∞ where there is none."""
        signal, nugget = np.log(self.spread), np.log(QUIET * self.noise_sd)
        grid = [np.array([signal, np.log(share * self.extent), nugget]) for share in SHARES]
        own, scale = given.kernel, float(np.mean(np.log(given.kernel.length_scales)))
        warm = np.array([np.log(own.signal_sd), scale, np.log(max(given.nugget_sd, QUIET * self.noise_sd))])
        value = partial(self._value, kernel)
        starts = [max(grid, key=lambda theta: value(_both(theta))), *([warm] if isinstance(own, kernel) else [])]
        return max((self._climb(kernel, start, _both, _fold) for start in starts), key=lambda found: found[0])

    def anisotropic(self, kernel: type[Kernel], value: float, theta: Floats) -> Floats:
        """Return θ with two length scales where they are worth their price, else the isotropic `theta`."""
        scales = np.log(np.array(SHARES) * self.extent)
        grid = [np.array([theta[0], lx, ly, theta[3]]) for lx, ly in product(scales, scales) if lx != ly]
        starts = (theta, max(grid, key=partial(self._value, kernel)))
        found = [self._climb(kernel, start, np.asarray, np.asarray) for start in starts]
        higher, better = max(found, key=lambda each: each[0])
        return better if higher > value + self.price else theta

    def _value(self, kernel: type[Kernel], theta: Floats) -> float:
        try:
            return self.likelihood.value(kernel, theta)
        except LinAlgError:
            return -np.inf

    def _climb(
        self, kernel: type[Kernel], start: Floats, spread: Callable[[Floats], Floats], fold: Callable[[Floats], Floats]
    ) -> tuple[float, Floats]:
        """Return the peak above `start`; `spread` makes θ of the search's parameters, `fold` their gradient of θ's."""

        def negative(short: Floats) -> tuple[float, Floats]:
            try:
                value, gradient = self.likelihood(kernel, spread(short))
            except LinAlgError:
                return np.inf, np.zeros_like(short)
            return -value, -fold(gradient)

        bounds = self._bounds(len(start) - 2)
        begin = np.clip(start, *np.transpose(bounds))
        found = minimize(negative, begin, jac=True, method="L-BFGS-B", bounds=bounds)
        return -float(found.fun), spread(found.x)

    def _bounds(self, lengths: int) -> list[tuple[float, float]]:
        length = (np.log(LENGTHS[0] * self.extent), np.log(LENGTHS[1] * self.extent))
        signal, nugget = (
            (np.log(low * self.noise_sd), np.log(high * self.noise_sd)) for low, high in (SIGNALS, NUGGETS)
        )
        return [signal, *[length] * lengths, nugget]


def _both(short: Floats) -> Floats:
    """Return θ of (log σ_f, log l, log τ)."""
    return short[[0, 1, 1, 2]]


def _fold(gradient: Floats) -> Floats:
    return np.array([gradient[0], gradient[1] + gradient[2], gradient[3]])


def _model(kernel: type[Kernel], theta: Sequence[float] | Floats, trend: Trend, mapped: ValueMap | None) -> MapModel:
    signal, lx, ly, nugget = (float(value) for value in np.exp(theta))
    return MapModel(kernel(signal, (lx, ly), mapped), nugget, trend)
