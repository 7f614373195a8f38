"""Newton steps of a path towards the quickest one at constant airspeed, without obstacles.

The time T of a displacement d in a wind w solves |d − wT| = va·T (`instances.wind_triangle`). With the air heading
n = (d − wT)/(va·T), r = va + n·w and m = n/r, differentiating that equation gives

    ∂T/∂d = m,   ∂T/∂w = −T m,   dn = n⊥ n⊥·(dd − T dw − w dT)/(va·T),   dm = dn/r − n (dn·w + n·dw)/r²,

n⊥ being n turned by a right angle. Each segment of a polyline costs T at its two Gauss points, where moving its ends
sideways changes d, and w through its slopes. As for the energy (`newton`), the Hessian is tridiagonal; its part with a
still wind is never negative.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from formulations.moving_cost.newton_terms import GAUSS_1, GAUSS_2, Terms
from formulations.moving_cost.wind_surface import WindSurface, wind_at
from instances.arrays import Floats
from instances.kernels import njit

LEAST_ROOM = 1e-3
"""va² − |w|² over va² that is reckoned with at least: a step may leave the region, where the wind is not checked."""


class Air(NamedTuple):
    """A displacement flown in a wind: its time T [s], air heading n, r = va + n·w [m/s], wind across n, va [m/s]."""

    time: float
    hx: float
    hy: float
    r: float
    crossing: float
    airspeed: float


@njit(cache=True)
def _flown(dx: float, dy: float, u: float, v: float, airspeed: float) -> Air:
    room = max(airspeed * airspeed - u * u - v * v, LEAST_ROOM * airspeed * airspeed)
    tail = u * dx + v * dy
    time = (math.sqrt(tail * tail + (dx * dx + dy * dy) * room) - tail) / room
    hx, hy = dx - u * time, dy - v * time
    size = math.hypot(hx, hy)  # va·T but where the wind was reckoned weaker than it is
    hx, hy = hx / size, hy / size
    return Air(time, hx, hy, max(airspeed + hx * u + hy * v, LEAST_ROOM * airspeed), hx * v - hy * u, airspeed)


@njit(cache=True)
def _changes(air: Air, mx: float, my: float, wx: float, wy: float) -> tuple[float, float, float]:
    """Return dT and dm where the displacement changes by (mx, my) and the wind by (wx, wy)."""
    ax, ay = mx - air.time * wx, my - air.time * wy
    slope = (air.hx * ax + air.hy * ay) / air.r
    turn = (air.hx * ay - air.hy * ax - air.crossing * slope) / (air.airspeed * air.time)
    rise = (turn * air.crossing + air.hx * wx + air.hy * wy) / (air.r * air.r)
    return slope, -air.hy * turn / air.r - air.hx * rise, air.hx * turn / air.r - air.hy * rise


@njit(cache=True)
def _point_terms(air: Air, wind: Floats, normals: Floats, shares: tuple[float, float], out: Floats) -> None:
    """Add to `out` (8,) what T at a point of a segment says.

    Derivatives by the start's and the end's move; second ones start-start, start-end, end-end; these with a still wind.
    """
    slope, mx, my = np.empty(2), np.empty((2, 2)), np.empty((2, 2))
    drift = np.empty((2, 2))
    for e in range(2):
        x, y = normals[e, 0], normals[e, 1]
        sign = 1.0 if e else -1.0
        for c in range(2):
            drift[e, c] = shares[e] * (wind[c, 1] * x + wind[c, 2] * y)
        slope[e], mx[e, 0], my[e, 0] = _changes(air, sign * x, sign * y, drift[e, 0], drift[e, 1])
        _, mx[e, 1], my[e, 1] = _changes(air, sign * x, sign * y, 0.0, 0.0)
        out[e] += slope[e]
    at = 2
    for e in range(2):
        for f in range(e, 2):
            ex, ey, fx, fy = normals[e, 0], normals[e, 1], normals[f, 0], normals[f, 1]
            sign = 1.0 if f else -1.0
            bent = slope[e] * (air.hx * drift[f, 0] + air.hy * drift[f, 1])
            for c in range(2):
                second = wind[c, 3] * ex * fx + wind[c, 4] * (ex * fy + ey * fx) + wind[c, 5] * ey * fy
                bent += air.time * shares[e] * shares[f] * (air.hx if c == 0 else air.hy) * second
            ahead = mx[e, 0] * (sign * fx - air.time * drift[f, 0]) + my[e, 0] * (sign * fy - air.time * drift[f, 1])
            out[at] += ahead - bent / air.r
            out[at + 3] += sign * (mx[e, 1] * fx + my[e, 1] * fy)
            at += 1


@njit(cache=True)
def time_terms(p: Floats, normal: Floats, surface: WindSurface, airspeed: float) -> Terms:
    """Return the derivatives of va·T of the polyline `p` by sideways moves of its nodes."""
    n = len(p)
    g, diagonal, bend, off, off_bend = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    along, across, wind, out = np.empty((3, 4)), np.empty((3, 4)), np.empty((2, 6)), np.empty(8)
    for k in range(n - 1):
        dx, dy = p[k + 1, 0] - p[k, 0], p[k + 1, 1] - p[k, 1]
        out[:] = 0.0
        for s in (GAUSS_1, GAUSS_2):
            wind_at(p[k, 0] + s * dx, p[k, 1] + s * dy, surface, along, across, wind)
            air = _flown(dx, dy, wind[0, 0], wind[1, 0], airspeed)
            _point_terms(air, wind, normal[k : k + 2], (1.0 - s, s), out)
        out *= 0.5 * airspeed
        g[k] += out[0]
        g[k + 1] += out[1]
        diagonal[k] += out[5]
        diagonal[k + 1] += out[7]
        bend[k] += out[2] - out[5]
        bend[k + 1] += out[4] - out[7]
        off[k], off_bend[k] = out[6], out[3] - out[6]
    return Terms(g, diagonal, bend, off, off_bend)
