"""Straight legs in a wind: what they cost, how long they are flown, and how both change as their ends move.

With d = b − a and n Gauss points x_q = a + t_q d of weight c_q, a leg a → b costs (instances.moving_cost)

    energy   C = |d|/v0 − Σ_q c_q w(x_q)·d / v0²                 ∂C/∂b = d/(|d| v0) − Σ_q c_q (w_q + t_q ∇w_qᵀ d)/v0²
    time     C = Σ_q c_q T(w(x_q), d)                            ∂C/∂b = Σ_q c_q (m_q − t_q T_q ∇w_qᵀ m_q)

where T is Zermelo's metric and ∂T/∂d = m, ∂T/∂w = −T m (formulations.moving_cost.newton_time); by a, with −1 for the
d and 1 − t_q for the t_q that stand in front. The wind is a cubic spline through samples: value and slope agree.
A leg is flown in |d|/v where the cost is energy, v being the flying speed over ground, and in C where it is time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.interpolate import RectBivariateSpline

from instances.arrays import Floats
from instances.environment.region import Region
from instances.moving_cost import CostKind, CostMeasure

CELLS = 160
"""Samples of the wind along the region's longer side, as many as the moving costs' search takes."""
NODES, WEIGHTS = (0.5 * (x + shift) for x, shift in zip(np.polynomial.legendre.leggauss(6), (1.0, 0.0), strict=True))
"""Gauss's six points in (0, 1) and their weights: exact for the slopes of a wind over a leg of some cells."""
SHORTEST = 1e-9
"""Lengths [m] that are divided by are at least this: a leg of length 0 has no direction."""


class Costed(NamedTuple):
    """Of each of w legs: cost and duration [s], (w,), and their slopes by its start and end [s/m], (w, 2, 2)."""

    cost: Floats
    duration: Floats
    cost_slopes: Floats
    duration_slopes: Floats


@dataclass(frozen=True, eq=False)
class StraightLegs:
    """What straight legs cost.

    speed : v0 [m/s], held constant: ground speed where the cost is energy, airspeed where it is time.
    flying_speed : v [m/s] over ground where the cost is energy; not looked at where it is time.
    wind : the wind's samples, or None where calm.
    """

    speed: float
    flying_speed: float
    kind: CostKind = CostKind.ENERGY
    wind: Wind | None = None

    @classmethod
    def of(cls, measure: CostMeasure | None, region: Region, speed: float, flying_speed: float) -> StraightLegs:
        """Return legs costed by `measure`, whose wind is sampled over `region`; in calm air where it is None."""
        if measure is None:
            return cls(speed, flying_speed)
        return cls(measure.speed, flying_speed, measure.kind, Wind.over(measure, region))

    def __call__(self, path: Floats) -> Costed:
        """Return what the legs between consecutive places of `path` (w + 1, 2) [m] cost."""
        a, d = path[:-1], np.diff(path, axis=0)
        length = np.maximum(np.hypot(*d.T), SHORTEST)
        direction = d / length[:, None]
        straight = np.stack([-direction, direction], axis=1)
        if self.wind is None:
            cost, slopes = length / self.speed, straight / self.speed
        elif self.kind is CostKind.TIME:
            cost, slopes = self._times(a, d)
        else:
            cost, slopes = self._energies(a, d)
            cost, slopes = length / self.speed - cost, straight / self.speed - slopes
        if self.kind is CostKind.TIME:
            return Costed(cost, cost, slopes, slopes)
        return Costed(cost, length / self.flying_speed, slopes, straight / self.flying_speed)

    def _energies(self, a: Floats, d: Floats) -> tuple[Floats, Floats]:
        """Return ∫ w·dσ/v0² [s] and its slopes."""
        assert self.wind is not None
        w, jacobian = self.wind.at(a[:, None] + NODES[:, None] * d[:, None])
        mean = np.einsum("q,kqc->kc", WEIGHTS, w)
        by_place = np.einsum("kqcd,kc->kqd", jacobian, d)
        start = np.einsum("q,kqd->kd", WEIGHTS * (1.0 - NODES), by_place) - mean
        end = np.einsum("q,kqd->kd", WEIGHTS * NODES, by_place) + mean
        return (mean * d).sum(axis=1) / self.speed**2, np.stack([start, end], axis=1) / self.speed**2

    def _times(self, a: Floats, d: Floats) -> tuple[Floats, Floats]:
        """Return the flight times [s] and their slopes."""
        assert self.wind is not None
        w, jacobian = self.wind.at(a[:, None] + NODES[:, None] * d[:, None])
        room = self.speed**2 - (w * w).sum(axis=2)
        tail = np.einsum("kqc,kc->kq", w, d)
        time = (np.sqrt(tail**2 + (d * d).sum(axis=1)[:, None] * room) - tail) / room
        heading = (d[:, None] - w * time[..., None]) / np.maximum(self.speed * time, SHORTEST)[..., None]
        m = heading / (self.speed + (heading * w).sum(axis=2))[..., None]
        by_place = -time[..., None] * np.einsum("kqcd,kqc->kqd", jacobian, m)
        start = np.einsum("q,kqd->kd", WEIGHTS, (1.0 - NODES)[:, None] * by_place - m)
        end = np.einsum("q,kqd->kd", WEIGHTS, NODES[:, None] * by_place + m)
        return time @ WEIGHTS, np.stack([start, end], axis=1)


@dataclass(frozen=True, eq=False)
class Wind:
    """A wind as cubic splines through samples: x (p,), y (q,) [m]; u, v (q, p) [m/s]. Continued constant outside."""

    x: Floats
    y: Floats
    u: Floats
    v: Floats

    @classmethod
    def over(cls, measure: CostMeasure, region: Region) -> Wind:
        """Return the wind of `measure` over the bounding box of `region`."""
        x0, y0, x1, y1 = region.bounds
        cell = max(x1 - x0, y1 - y0) / CELLS
        x = np.linspace(x0, x1, max(8, math.ceil((x1 - x0) / cell)) + 1)
        y = np.linspace(y0, y1, max(8, math.ceil((y1 - y0) / cell)) + 1)
        w = measure.wind(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)).reshape(len(y), len(x), 2)
        return cls(x, y, w[..., 0], w[..., 1])

    def at(self, places: Floats) -> tuple[Floats, Floats]:
        """Return the wind [m/s] at `places` (…, 2) [m], shape (…, 2), and ∂w_c/∂x_d [1/s], shape (…, 2, 2)."""
        x, y = np.clip(places[..., 0], *self.x[[0, -1]]), np.clip(places[..., 1], *self.y[[0, -1]])
        w = np.stack([spline.ev(y, x) for spline in self._splines], axis=-1)
        rows = [np.stack([s.ev(y, x, dy=1), s.ev(y, x, dx=1)], axis=-1) for s in self._splines]
        return w, np.stack(rows, axis=-2)

    @cached_property
    def _splines(self) -> tuple[RectBivariateSpline, RectBivariateSpline]:
        return RectBivariateSpline(self.y, self.x, self.u), RectBivariateSpline(self.y, self.x, self.v)
