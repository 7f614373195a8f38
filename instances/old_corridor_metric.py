"""For old files only: the metric `wind` with a region, by which large instances of the family `corridor` were stored.

Their costs were those of the cheapest path of straight legs that bends at corners of the region only, up to 4 % above
the moving cost. Costs are planned by `formulations.moving_cost` now; this keeps the old files readable, to the bit.
"""

from __future__ import annotations

import numpy as np
import shapely

from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.wind import WindField
from instances.moving_cost import moving_cost
from instances.walks import shortest_walks

TOLERANCE = 1e-9
"""Touching a wall within this fraction of the region's diameter is no crossing."""


def old_corridor_costs(points: Floats, region: Region, v0: float, wind: WindField | None) -> Floats:
    """Return ``cost[i, j]`` [s], shape (k, k), between `points` (k, 2) [m] inside `region`, as old files mean them."""
    cost = _leg_costs(points, points, region, v0, wind)
    corners = turning_corners(region)
    if len(corners):
        among = shortest_walks(_leg_costs(corners, corners, region, v0, wind))
        first = _leg_costs(points, corners, region, v0, wind)
        last = _leg_costs(corners, points, region, v0, wind)
        reach = np.min(first[:, :, None] + among[None, :, :], axis=1)
        for corner in range(len(corners)):
            np.minimum(cost, reach[:, corner, None] + last[None, corner, :], out=cost)
    if wind is None:
        np.minimum(cost, cost.T, out=cost)  # the same both ways to the last bit, in whichever order corners were added
    np.fill_diagonal(cost, 0.0)
    return cost


def turning_corners(region: Region) -> Floats:
    """Return the corners a taut string can bend around, shape (c, 2) [m]: reflex ones, and the convex ones of holes."""
    found = []
    oriented = shapely.geometry.polygon.orient(region.polygon)  # outer ring anticlockwise, holes clockwise
    for ring in (oriented.exterior, *oriented.interiors):
        xy = np.asarray(ring.coords)[:-1, :2]
        before, after = xy - np.roll(xy, 1, axis=0), np.roll(xy, -1, axis=0) - xy
        turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        found.append(xy[turn < 0])
    return np.concatenate(found)


def _leg_costs(a: Floats, b: Floats, region: Region, v0: float, wind: WindField | None) -> Floats:
    """Return the cost [s] of the straight legs a → b, shape (len(a), len(b)); inf where one leaves the region."""
    x0, y0, x1, y1 = region.bounds
    roomy = shapely.buffer(region.polygon, TOLERANCE * float(np.hypot(x1 - x0, y1 - y0)), join_style="mitre")
    shapely.prepare(roomy)
    cost = np.empty((len(a), len(b)))
    for i, start in enumerate(a):
        starts = np.broadcast_to(start, b.shape)
        cost[i] = np.sqrt(((b - start) ** 2).sum(axis=1)) / v0
        if wind is not None:
            cost[i] = moving_cost(cost[i], wind.line_integral(starts, b), v0)
        outside = ~np.asarray(shapely.covers(roomy, shapely.linestrings(np.stack([starts, b], axis=1))))
        cost[i, outside & (b != start).any(axis=1)] = np.inf  # a leg of no length is no line to shapely
    return cost
