"""Means of a field that are known but for their coefficients, as columns of a regression (universal kriging).

Each has a column of ones, the unknown level (paper, eq. mean). Physics may add a column whose coefficient is a number
of its own: the path-loss exponent n of a signal that falls by 10 n log₁₀ d, or what a predicted field is multiplied by.
Of the level nothing is believed; of such a number something is, as a normal distribution N(b, s²). Without it a column
that the samples hardly see would count as a reason for itself.

A mean may predict what obstacles take away, too, and where, therefore, the field varies more about it (shadows.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats


@dataclass(frozen=True)
class Trend:
    """A mean: its name, and its column beside the ones at points (k, 2) [m], shape (k,); None for the level alone.

    believed, spread : b and s of the column's coefficient. loss : o ≥ 0 [dB] at points (k, 2) [m], shape (k,), of what
    the mean predicts to be lost behind obstacles; None where it predicts nothing of the kind.
    """

    name: str
    beside: Callable[[Floats], Floats] | None = None
    believed: float = 1.0
    spread: float = 0.5
    loss: Callable[[Floats], Floats] | None = None

    def columns(self, points: Floats) -> Floats:
        """Return H at `points` (k, 2) [m], shape (k, q)."""
        ones = np.ones(len(points))
        return np.column_stack([ones] if self.beside is None else [ones, self.beside(points)])

    @property
    def prior_mean(self) -> Floats:
        """What is believed of the coefficients, shape (q,); 0 for the level, of which nothing is."""
        return np.array([0.0] if self.beside is None else [0.0, self.believed])

    @property
    def prior_precision(self) -> Floats:
        """1/s² of the coefficients on a diagonal, shape (q, q); 0 for the level."""
        return np.diag([0.0] if self.beside is None else [0.0, self.spread**-2])


CONSTANT = Trend("constant")


def path_loss(x: float, y: float, above: float) -> Trend:
    """Return −10 log₁₀ of the distance from a transmitter at (x, y) [m] and `above` [m] below the points.

    Its coefficient is the path-loss exponent: 2 in free space, 3 to 4 over obstacles.
    """

    def beside(points: Floats) -> Floats:
        away = np.hypot(points[:, 0] - x, points[:, 1] - y)
        loss: Floats = -10.0 * np.log10(np.hypot(away, above))
        return loss

    return Trend("path-loss", beside, believed=3.0, spread=1.0)
