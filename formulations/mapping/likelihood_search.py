"""The search for the peak of a restricted likelihood (`formulations.mapping.likelihood`) under one mean.

The likelihood of few samples has several peaks, and a search that begins where the last one ended stays on the wrong
one for the rest of a survey. So each search also begins at the best of a grid of length scales.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import product

import numpy as np
from scipy.linalg import LinAlgError
from scipy.optimize import minimize

from formulations.kernel import Kernel
from formulations.mapping.likelihood import RestrictedLikelihood
from formulations.mapping.trend import Trend
from instances.arrays import Floats
from instances.environment.value_map import ValueMap

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
"""c of the grid, in standard deviations of the loss predicted at the samples."""
WIDEST = (0.01, 100.0)
"""Bounds of c, likewise."""
SIGHT = 0.3
"""a of the grid."""
LEAST_SIGHT = 0.02
"""The least a: a prediction of no error would leave the map nothing to say of its own."""
QUIET = 0.3
"""The nugget at which a search begins, in sensor noises."""
DIRECTIONS = (0.0, 0.25 * math.pi, 0.5 * math.pi, 0.75 * math.pi)
"""Those at which such a search may begin [rad]."""
STRETCH = 0.5
"""log √(l_1/l_2) there."""
ALIKE = 0.3
"""Standard deviation of log l_1/l_2 as it is believed before the samples, about 0."""


class LikelihoodSearch:
    """Searches for the peak of the likelihood of samples under one mean.

    taus : bounds of τ [s], the same twice where it is known; None for fields that stay. lengths : as in `Offered`.
    shadowed : whether the mean predicts shadows, whose two parameters, c and a, are paid for in every log p found.
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
        shadowed: bool = False,
    ) -> None:
        times, relative_sd = None if taus is None else t, None if mapped is None else mapped(X)
        self.likelihood = RestrictedLikelihood(noise_sd, X, y, trend, times, relative_sd, shadowed=shadowed)
        self.mapped = mapped
        self.trend, self.noise_sd, self.spread = trend, noise_sd, float(y.std())
        self.extent, self.lasted = float(np.ptp(X, axis=0).max()), float(np.ptp(t))
        self.lengths = (LENGTHS[0] * self.extent, LENGTHS[1] * self.extent) if lengths is None else lengths
        self.count, self.price = len(y), 0.5 * np.log(len(y))
        self.drift = [] if taus is None else [(np.log(taus[0]), np.log(taus[1]))]
        self.shadows: list[list[float]] = []  # log c and log a of the grid
        self.darkness: list[tuple[float, float]] = []  # their bounds
        self.toll = 0.0
        if self.likelihood.loss is not None:
            varied = float(self.likelihood.loss.std())
            self.shadows = [[np.log(c * varied), np.log(SIGHT)] for c in CONTRASTS]
            self.darkness = [(np.log(WIDEST[0] * varied), np.log(WIDEST[1] * varied)), (np.log(LEAST_SIGHT), 0.0)]
            self.toll = 2 * self.price

    def isotropic(self, kernel: type[Kernel], warm: Kernel, nugget_sd: float, tau: float) -> tuple[float, Floats]:
        """Return the greatest log p found with l_x = l_y, and its θ; −∞ where there is none.

        A search begins at `warm`, `nugget_sd` and `tau` as well, where `warm` is of this kind.
        """
        signal, nugget = np.log(self.spread), np.log(QUIET * self.noise_sd)
        lengths = [np.log(share * self.extent) for share in SHARES]
        grid = [np.array([signal, length, nugget, *more]) for length in lengths for more in self._further()]
        value = partial(self._value, kernel)
        starts = [max(grid, key=lambda theta: value(_both(theta)))]
        if isinstance(warm, kernel):
            scale, least = float(np.mean(np.log(warm.length_scales))), QUIET * self.noise_sd
            last = self._further()[-1]
            if self.drift and tau < math.inf:
                last[0] = np.log(tau)
            starts.append(np.array([np.log(warm.signal_sd), scale, np.log(max(nugget_sd, least)), *last]))

        def evaluate(short: Floats) -> tuple[float, Floats]:
            height, gradient = self.likelihood(kernel, _both(short))
            return height, _fold(gradient)

        found = [self._climb(evaluate, start, self._bounds(1)) for start in starts]
        best, short = max(found, key=lambda each: each[0])
        return best, _both(short)

    def _further(self) -> list[list[float]]:
        """Return what θ ends in on the grid: log τ where the field drifts, log c and log a where it has shadows."""
        return [[*tau, *shadows] for tau in self._taus() for shadows in self.shadows or [[]]]

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
        """Return the greatest log p found with l_1 ≠ l_2 along and across a direction, from an isotropic θ; θ and φ.

        Length scales are believed to be nearly alike: log l_1/l_2 ~ N(0, ALIKE²), whose log-density beside that at 0
        counts in log p.
        """
        stretched = np.array([theta[0], theta[1] + STRETCH, theta[2] - STRETCH, *theta[3:]])
        likeliest = sorted(DIRECTIONS, key=lambda each: -self._value(kernel, stretched, each))
        bounds = [*self._bounds(2), (-2 * math.pi, 2 * math.pi)]

        def evaluate(both: Floats) -> tuple[float, Floats]:
            value, gradient = self.likelihood(kernel, both[:-1], both[-1])
            stretch = (both[1] - both[2]) / ALIKE
            gradient[1] -= stretch / ALIKE
            gradient[2] += stretch / ALIKE
            return value - 0.5 * stretch**2, gradient

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
        return [signal, *[length] * lengths, nugget, *self.drift, *self.darkness]


def _both(short: Floats) -> Floats:
    """Return θ of (log σ_f, log l, log σ₀), or of these and what follows."""
    return np.insert(short, 2, short[1])


def _fold(gradient: Floats) -> Floats:
    return np.array([gradient[0], gradient[1] + gradient[2], *gradient[3:]])
