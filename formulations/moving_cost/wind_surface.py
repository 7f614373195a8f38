"""The wind as the polish of flight times sees it: samples on a grid and a surface through them with smooth slopes.

Cubic convolution (R. G. Keys, IEEE Trans. ASSP 29 (1981) 1153–1160, a = −1/2): continuous with its slopes, and exact
for quadratic fields. Newton's method needs the wind and its first and second derivatives, consistent with each other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from instances.arrays import Floats
from instances.environment.wind import WindField
from instances.kernels import njit

MARGIN = 2
"""Samples beyond the region's bounding box on each side: the surface reaches that far around a point."""


class WindSurface(NamedTuple):
    """Wind u, v [m/s] at grid nodes (rows, columns): first node (x, y) [m], spacing dx, dy [m]."""

    x: float
    y: float
    dx: float
    dy: float
    u: Floats
    v: Floats


NO_SURFACE = WindSurface(0.0, 0.0, 1.0, 1.0, np.empty((0, 0)), np.empty((0, 0)))
"""Where nothing asks for it."""


def wind_surface(
    wind: WindField, bounds: tuple[float, float, float, float], spacing: tuple[float, float]
) -> WindSurface:
    """Return the surface over `bounds` (x0, y0, x1, y1) [m] through samples `spacing` [m] apart."""
    x0, y0, x1, y1 = bounds
    dx, dy = spacing
    x, y = (
        low + step * np.arange(-MARGIN, round((high - low) / step) + MARGIN + 1)
        for low, high, step in ((x0, x1, dx), (y0, y1, dy))
    )
    w = wind(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)).reshape(len(y), len(x), 2)
    return WindSurface(float(x[0]), float(y[0]), dx, dy, w[..., 0].copy(), w[..., 1].copy())


@njit(cache=True)
def _weights(t: float, out: Floats) -> None:
    """Write Keys's four weights at t in [0, 1] into row 0, their first and second derivatives into rows 1 and 2."""
    out[0, 0] = ((-0.5 * t + 1.0) * t - 0.5) * t
    out[0, 1] = (1.5 * t - 2.5) * t * t + 1.0
    out[0, 2] = ((-1.5 * t + 2.0) * t + 0.5) * t
    out[0, 3] = (0.5 * t - 0.5) * t * t
    out[1, 0] = (-1.5 * t + 2.0) * t - 0.5
    out[1, 1] = (4.5 * t - 5.0) * t
    out[1, 2] = (-4.5 * t + 4.0) * t + 0.5
    out[1, 3] = (1.5 * t - 1.0) * t
    out[2, 0] = -3.0 * t + 2.0
    out[2, 1] = 9.0 * t - 5.0
    out[2, 2] = -9.0 * t + 4.0
    out[2, 3] = 3.0 * t - 1.0


@njit(cache=True)
def wind_at(x: float, y: float, surface: WindSurface, along: Floats, across: Floats, out: Floats) -> None:
    """Write the wind at a point into `out` (2, 6): for u and v the value, ∂x, ∂y, ∂xx, ∂xy, ∂yy.

    Points outside are moved onto the grid. along, across : room for weights, (3, 4) each.
    """
    rows, columns = surface.u.shape
    fx = min(max((x - surface.x) / surface.dx, 1.0), columns - 2.0)
    fy = min(max((y - surface.y) / surface.dy, 1.0), rows - 2.0)
    i, j = min(int(fx), columns - 3), min(int(fy), rows - 3)
    _weights(fx - i, along)
    _weights(fy - j, across)
    out[:] = 0.0
    for b in range(4):
        for a in range(4):
            for c in range(2):
                value = surface.u[j - 1 + b, i - 1 + a] if c == 0 else surface.v[j - 1 + b, i - 1 + a]
                out[c, 0] += value * along[0, a] * across[0, b]
                out[c, 1] += value * along[1, a] * across[0, b]
                out[c, 2] += value * along[0, a] * across[1, b]
                out[c, 3] += value * along[2, a] * across[0, b]
                out[c, 4] += value * along[1, a] * across[1, b]
                out[c, 5] += value * along[0, a] * across[2, b]
    for c in range(2):
        out[c, 1] /= surface.dx
        out[c, 2] /= surface.dy
        out[c, 3] /= surface.dx * surface.dx
        out[c, 4] /= surface.dx * surface.dy
        out[c, 5] /= surface.dy * surface.dy
