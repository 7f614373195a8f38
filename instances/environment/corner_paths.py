"""Moving costs inside a region with walls: the cheapest path of straight legs that bends only at corners.

Closed form 2 of a gradient wind w = ∇φ (calm and uniform wind included): C = d/v0 − (φ_b − φ_a)/v0², where d is the
length of the taut string through the region, which bends only at corners the region turns around (visibility graph:
Lozano-Pérez & Wesley 1979). There the cost here is the true minimum.

With vorticity (shear, rotation) the true minimum bends between corners too, with curvature curl(w)/v0, as far as the
walls let it, and has no closed form. What is computed is then the exact cost, by exact line integrals along the legs,
of the cheapest path *of straight legs through corners*: a path that can be flown, hence an upper bound of the minimum.
A leg of length d costs more than its arc by (d/v0)(1 − g(κd/2)) of `closed_form`, about (d/v0)(κd)²/24: 1 % of the time
in calm air at κd = 0.5. (With the default wind of the family `corridor`, refined paths were up to 4 % cheaper.)
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import ArrayLike

from instances.arrays import Bools, Floats
from instances.environment.closed_form import vorticity
from instances.environment.region import Region
from instances.environment.wind import WindField
from instances.errors import InputError

TOLERANCE = 1e-9
"""Touching a wall within this fraction of the region's diameter is no crossing."""


def corner_path_costs(points: ArrayLike, region: Region, airspeed: float, wind: WindField | None) -> Floats:
    """Return ``cost[i, j]`` [s], shape (k, k), between `points` (k, 2) [m] along straight legs inside `region`.

    Raises
    ------
    InputError
        where a point lies outside the region, the wind has no closed form, or it reaches the airspeed in the region.
    """
    p = np.asarray(points, dtype=float).reshape(-1, 2)
    outside = ~region.contains(p)
    if outside.any():
        i = int(np.flatnonzero(outside)[0])
        raise InputError(f"point {i} at {p[i].tolist()} m lies outside the region")
    if wind is not None:
        vorticity(wind)  # refuses fields without closed form
        # |w| of the others is convex: the corners of the region decide
        fastest = float(np.linalg.norm(wind(np.concatenate(region.rings)), axis=1).max())
        if not fastest < airspeed:
            raise InputError(
                f"wind: it reaches {fastest:g} m/s in the region, but must stay below the airspeed of {airspeed:g} m/s"
            )
    cost = _leg_costs(p, p, airspeed, wind)
    cost[~sees(p, region)] = np.inf
    corners = turning_corners(region)
    if len(corners):
        among = np.where(_sees_exactly(corners, corners, region), _leg_costs(corners, corners, airspeed, wind), np.inf)
        for via in range(len(corners)):  # Floyd–Warshall
            np.minimum(among, among[:, via, None] + among[None, via, :], out=among)
        seen = _sees_exactly(p, corners, region)
        first = np.where(seen, _leg_costs(p, corners, airspeed, wind), np.inf)
        last = np.where(seen.T, _leg_costs(corners, p, airspeed, wind), np.inf)
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


def sees(points: Floats, region: Region) -> Bools:
    """Return which straight legs between `points` (k, 2) [m] of the region stay inside, shape (k, k).

    A leg leaves the region where it crosses a wall: its ends lie on different sides of the wall's line, and the wall's
    ends on different sides of the leg's line.
    """
    x0, y0, x1, y1 = region.bounds
    slack = TOLERANCE * float(np.hypot(x1 - x0, y1 - y0))
    p = points - (x0, y0)
    walls = [(a, b) for ring in region.rings for a, b in zip(ring[:-1] - (x0, y0), ring[1:] - (x0, y0), strict=True)]
    x, y = p[:, 0], p[:, 1]
    visible = np.ones((len(p), len(p)), dtype=bool)
    step = max(1, 2_000_000 // max(1, len(p)))
    for i in range(0, len(p), step):
        rows = slice(i, i + step)
        moment = np.outer(x[rows], y) - np.outer(y[rows], x)
        for a, b in walls:
            side = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / np.hypot(*(b - a))
            left, right = side > slack, side < -slack
            apart = np.outer(left[rows], right) | np.outer(right[rows], left)
            if not apart.any():
                continue
            at_a, at_b = x * a[1] - y * a[0], x * b[1] - y * b[0]
            a_left = moment + at_a[None, :] - at_a[rows, None] > 0
            b_left = moment + at_b[None, :] - at_b[rows, None] > 0
            visible[rows] &= ~(apart & (a_left != b_left))
    # a leg between two walls may run outside without crossing either: those few points are looked at one by one
    on_wall = np.abs(region.signed_distance(points)) <= slack
    visible[np.ix_(on_wall, on_wall)] = _sees_exactly(points[on_wall], points[on_wall], region)
    return visible


def _sees_exactly(a: Floats, b: Floats, region: Region) -> Bools:
    """Return which legs `a` → `b` stay inside, shape (len(a), len(b)), also where ends are corners of the region."""
    x0, y0, x1, y1 = region.bounds
    roomy = shapely.buffer(region.polygon, TOLERANCE * float(np.hypot(x1 - x0, y1 - y0)), join_style="mitre")
    shapely.prepare(roomy)
    ends = np.empty((len(a), len(b), 2, 2))
    ends[:, :, 0], ends[:, :, 1] = a[:, None], b[None, :]
    covered = np.asarray(shapely.covers(roomy, shapely.linestrings(ends)), dtype=bool)
    return covered | (a[:, None] == b[None, :]).all(axis=2)  # a leg of no length is no line to shapely


def _leg_costs(a: Floats, b: Floats, airspeed: float, wind: WindField | None) -> Floats:
    """Return the cost [s] of the straight legs a → b, shape (len(a), len(b))."""
    cost = np.empty((len(a), len(b)))
    for i, start in enumerate(a):
        cost[i] = np.sqrt(((b - start) ** 2).sum(axis=1)) / airspeed
        if wind is not None:
            cost[i] -= wind.line_integral(np.broadcast_to(start, b.shape), b) / airspeed**2
    return cost
