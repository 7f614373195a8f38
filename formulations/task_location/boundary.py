"""The border of the region as a constraint s(p) ≥ 0, s the signed distance [m], positive inside."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.optimize import Bounds

from instances.arrays import Floats
from instances.environment.region import Region


def is_rectangle(region: Region) -> bool:
    """Return whether the region fills its bounding box, so that bounds on the unknowns say it all."""
    x0, y0, x1, y1 = region.bounds
    box = (x1 - x0) * (y1 - y0)
    return abs(region.area - box) <= 1e-12 * box


def box(region: Region, scales: Floats, n: int) -> Bounds:
    """Return the bounding box of `region` as bounds on n points in units of `scales`, z = x / l, flat."""
    x0, y0, x1, y1 = region.bounds
    return Bounds(np.tile([x0, y0] / scales, n), np.tile([x1, y1] / scales, n))


def distance_gradient(region: Region, points: Floats) -> Floats:
    """Return ∇s at `points`, shape (n, 2), dimensionless: the unit vector that leads inwards.

    0 on the border itself, where it is not defined.
    """
    lines = shapely.shortest_line(shapely.points(points), region.polygon.boundary)
    nearest = shapely.get_coordinates(shapely.get_point(lines, 1))
    inwards = np.where(region.contains(points)[:, None], 1.0, -1.0) * (points - nearest)
    length = np.linalg.norm(inwards, axis=1, keepdims=True)
    return np.divide(inwards, length, out=np.zeros_like(inwards), where=length > 1e-9)
