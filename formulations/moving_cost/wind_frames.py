"""The wind that changes as searches by the clock see it: frames on a grid, and how long a segment takes in them.

Bilinear between nodes and linear between frames, as a forecast is. A segment d begun at t takes one step of Kutta's
rule of third order on each of its pieces,

    k₁ = 1/g(0, t),  k₂ = 1/g(½, t + k₁/2),  k₃ = 1/g(1, t − k₁ + 2 k₂),  Δt = (k₁ + 4 k₂ + k₃)/6,

g being the ground speed of the wind triangle (`instances.wind_triangle`) over the piece's length. What is found so is
flown in the wind itself before anything is claimed (`instances.wind_flights`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.wind_changing import ChangingWind
from instances.environment.wind_forecast import sampled
from instances.kernels import njit

FRAMES = 65
"""Moments at which the wind is asked."""
CELLS = 120
"""Cells of the grid along the region's longer side."""
PIECE = 2.6
"""Longest piece of a segment, in cells."""


class WindFrames(NamedTuple):
    """Velocities `w` [m/s], (frames, rows, columns, 2), at moments `step` [s] apart from 0 on, the last one held.

    x, y : of the first node [m]. dx, dy : between nodes [m]. airspeed : of who flies there [m/s].
    """

    x: float
    y: float
    dx: float
    dy: float
    step: float
    w: Floats
    airspeed: float


def wind_frames(wind: ChangingWind, region: Region, airspeed: float, until: float) -> WindFrames:
    """Return the frames of `wind` over the bounds of `region` from 0 to `until` [s]."""
    times = np.linspace(0.0, until, FRAMES)
    made = sampled(wind, region, times, CELLS)
    return WindFrames(*made.origin, *made.spacing, float(times[1]), np.stack([made.u, made.v], axis=-1), airspeed)


@njit(cache=True)
def _slowness(x: float, y: float, time: float, ex: float, ey: float, wind: WindFrames) -> float:
    """Return 1/g [s/m] along the unit vector (ex, ey); inf where the track cannot be kept."""
    frames, rows, columns, _ = wind.w.shape
    fx = min(max((x - wind.x) / wind.dx, 0.0), columns - 1.0)
    fy = min(max((y - wind.y) / wind.dy, 0.0), rows - 1.0)
    ft = min(max(time / wind.step, 0.0), frames - 1.0)
    i, j, k = min(int(fx), columns - 2), min(int(fy), rows - 2), min(int(ft), frames - 2)
    s, t, r = fx - i, fy - j, ft - k
    u = v = 0.0
    for later in range(2):
        share = r if later else 1.0 - r
        for up in range(2):
            height = share * (t if up else 1.0 - t)
            a, b = wind.w[k + later, j + up, i], wind.w[k + later, j + up, i + 1]
            u += height * (a[0] + s * (b[0] - a[0]))
            v += height * (a[1] + s * (b[1] - a[1]))
    across = v * ex - u * ey
    room = wind.airspeed * wind.airspeed - across * across
    g = u * ex + v * ey + math.sqrt(room) if room > 0.0 else 0.0
    return 1.0 / g if g > 0.0 else np.inf


@njit(cache=True)
def segment_time(ax: float, ay: float, bx: float, by: float, time: float, wind: WindFrames) -> float:
    """Return how long [s] the segment from (ax, ay) to (bx, by) [m] takes begun at `time` [s]; inf where it cannot."""
    dx, dy = bx - ax, by - ay
    far = math.hypot(dx, dy)
    if far == 0.0:
        return 0.0
    ex, ey = dx / far, dy / far
    pieces = max(1, math.ceil(far / (PIECE * max(wind.dx, wind.dy))))
    h, now = far / pieces, time
    for p in range(pieces):
        x, y = ax + p * h * ex, ay + p * h * ey
        one = h * _slowness(x, y, now, ex, ey, wind)
        if one == np.inf:  # no time at which to ask the wind again
            return np.inf
        two = h * _slowness(x + 0.5 * h * ex, y + 0.5 * h * ey, now + 0.5 * one, ex, ey, wind)
        if two == np.inf:
            return np.inf
        three = h * _slowness(x + h * ex, y + h * ey, now - one + 2.0 * two, ex, ey, wind)
        if three == np.inf:
            return np.inf
        now += (one + 4.0 * two + three) / 6.0
    return now - time


@njit(cache=True, nogil=True)
def segment_times(a: Floats, b: Floats, wind: WindFrames) -> Floats:
    """Return how long [s] each segment `a` → `b`, (k, 2) [m], takes that is begun at each frame, (k, frames)."""
    frames = len(wind.w)
    out = np.empty((len(a), frames))
    for k in range(len(a)):
        for f in range(frames):
            out[k, f] = segment_time(a[k, 0], a[k, 1], b[k, 0], b[k, 1], f * wind.step, wind)
    return out
