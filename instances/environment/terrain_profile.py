"""Terrain heights along a straight line, for propagation models."""

from __future__ import annotations

import math

import numpy as np

from instances.arrays import Floats
from instances.kernels import njit


@njit(cache=True)
def profile(
    ground: Floats, x0: float, y0: float, dx: float, dy: float, ax: float, ay: float, bx: float, by: float, step: float
) -> Floats:
    """Return terrain heights [m] from (ax, ay) to (bx, by) at about `step` [m], bilinear."""
    rows, columns = ground.shape
    count = max(2, int(math.hypot(bx - ax, by - ay) / step) + 1)
    out = np.empty(count)
    for i in range(count):
        t = i / (count - 1)
        fx = min(max((ax + t * (bx - ax) - x0) / dx, 0.0), columns - 1.0)
        fy = min(max((ay + t * (by - ay) - y0) / dy, 0.0), rows - 1.0)
        c, r = max(min(int(fx), columns - 2), 0), max(min(int(fy), rows - 2), 0)  # 0 of what is no number
        s, u = fx - c, fy - r
        south = (1 - s) * ground[r, c] + s * ground[r, c + 1]
        north = (1 - s) * ground[r + 1, c] + s * ground[r + 1, c + 1]
        out[i] = (1 - u) * south + u * north
    return out
