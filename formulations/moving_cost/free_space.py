"""Free space for path search: which straight segments stay inside the region, fast.

The border of the region (outer ring and no-fly holes) is a set of edges, the free side on the left of each. Paths
may touch the border: only a segment that runs through the outside is blocked. A coarse grid of clearances lets
most segments pass by stepping from disc to disc (sphere tracing, Hart 1996); near the border the test is exact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import shapely

from instances.arrays import Bools, Floats
from instances.environment.region import Region
from instances.kernels import njit

CELLS = 96
"""Cells of the clearance grid along the longer side."""


class FreeSpace(NamedTuple):
    """The free space as flat arrays, for numba kernels.

    edges : border edges (E, 4) [m]: start x, y, end x, y; free space on the left.
    corners : reflex corners of free space (K, 2) [m], around which paths may bend.
    outward : unit vectors (K, 2) that point from each corner into free space, along its bisector.
    clearance : lower bound [m] of the distance to the border for every point of a cell; 0 outside.
    origin, cell : lower left corner [m] and cell size [m] of the clearance grid.
    eps : length [m] under which touching is not crossing.
    """

    edges: Floats
    corners: Floats
    outward: Floats
    clearance: Floats
    origin: tuple[float, float]
    cell: float
    eps: float


def free_space(region: Region) -> FreeSpace:
    """Return `region` as flat arrays."""
    polygon = shapely.geometry.polygon.orient(region.polygon)  # outer ring anticlockwise, holes clockwise
    rings = [np.asarray(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    edges = np.concatenate([np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in rings])
    corners, outward = (np.concatenate(parts) for parts in zip(*map(_reflex_corners, rings), strict=True))
    x0, y0, x1, y1 = region.bounds
    extent = max(x1 - x0, y1 - y0)
    cell = extent / CELLS
    columns, rows = math.ceil((x1 - x0) / cell), math.ceil((y1 - y0) / cell)
    xs, ys = x0 + (np.arange(columns) + 0.5) * cell, y0 + (np.arange(rows) + 0.5) * cell
    centres = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    clearance = np.maximum(_distance(centres, edges) - cell * math.sqrt(0.5) * (1 + 1e-9), 0.0)
    clearance[~region.contains(centres)] = 0.0
    return FreeSpace(edges, corners, outward, clearance.reshape(rows, columns), (x0, y0), float(cell), 1e-10 * extent)


def _reflex_corners(ring: Floats) -> tuple[Floats, Floats]:
    """Return the corners of a ring (free space on its left) where free space exceeds a half plane."""
    back, ahead = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    back = back / np.linalg.norm(back, axis=1, keepdims=True)
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    reflex = back[:, 0] * ahead[:, 1] - back[:, 1] * ahead[:, 0] < -1e-9
    outward = (back - ahead)[reflex]
    return ring[reflex], outward / np.linalg.norm(outward, axis=1, keepdims=True)


@njit(cache=True)
def _distance(points: Floats, edges: Floats) -> Floats:
    """Distance of each point to the nearest edge."""
    out = np.empty(len(points))
    for k in range(len(points)):
        best = np.inf
        for e in range(len(edges)):
            ax, ay = edges[e, 0], edges[e, 1]
            dx, dy = edges[e, 2] - ax, edges[e, 3] - ay
            px, py = points[k, 0] - ax, points[k, 1] - ay
            t = min(max((px * dx + py * dy) / (dx * dx + dy * dy), 0.0), 1.0)
            best = min(best, (px - t * dx) ** 2 + (py - t * dy) ** 2)
        out[k] = math.sqrt(best)
    return out


@njit(cache=True)
def clearance_at(x: float, y: float, space: FreeSpace) -> float:
    """Lower bound of the distance to the border; 0 where unknown."""
    fx, fy = (x - space.origin[0]) / space.cell, (y - space.origin[1]) / space.cell
    rows, columns = space.clearance.shape
    if fx < 0.0 or fy < 0.0 or fx >= columns or fy >= rows:
        return 0.0
    return space.clearance[int(fy), int(fx)]


@njit(cache=True)
def point_free(x: float, y: float, space: FreeSpace) -> bool:
    """Whether a point is inside the region or within eps of its border."""
    if clearance_at(x, y, space) > 0.0:
        return True
    inside = False
    edges, eps = space.edges, space.eps
    for e in range(len(edges)):
        ax, ay, bx, by = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
        dx, dy = bx - ax, by - ay
        px, py = x - ax, y - ay
        t = min(max((px * dx + py * dy) / (dx * dx + dy * dy), 0.0), 1.0)
        if (px - t * dx) ** 2 + (py - t * dy) ** 2 <= eps * eps:
            return True
        if (ay > y) != (by > y) and px < dx * py / dy:
            inside = not inside
    return inside


@njit(cache=True)
def segment_free(ax: float, ay: float, bx: float, by: float, space: FreeSpace) -> bool:
    """Whether the straight segment between two free points runs through no outside; touching is allowed."""
    dx, dy = bx - ax, by - ay
    length = math.hypot(dx, dy)
    if length <= space.eps:
        return True
    ux, uy = dx / length, dy / length
    done = 0.0
    while True:
        r = clearance_at(ax + done * ux, ay + done * uy, space)
        if r >= length - done:
            return True
        if r < 0.5 * space.cell:
            break
        done += r
    return _segment_free_exact(ax, ay, ux, uy, length, space)


@njit(cache=True)
def _segment_free_exact(ax: float, ay: float, ux: float, uy: float, length: float, space: FreeSpace) -> bool:
    """Proper crossings block at once; between touching points the middle of each piece decides."""
    edges, eps = space.edges, space.eps
    touches = np.empty(2 * len(edges) + 2)
    count = 0
    for e in range(len(edges)):
        px, py = edges[e, 0] - ax, edges[e, 1] - ay
        qx, qy = edges[e, 2] - ax, edges[e, 3] - ay
        hp, hq = ux * py - uy * px, ux * qy - uy * qx  # heights over the segment's line
        if (hp > eps and hq > eps) or (hp < -eps and hq < -eps):
            continue
        sp, sq = ux * px + uy * py, ux * qx + uy * qy  # positions along it
        if max(sp, sq) < -eps or min(sp, sq) > length + eps:
            continue
        if abs(hp) <= eps or abs(hq) <= eps:
            if abs(hp) <= eps and -eps <= sp <= length + eps:
                touches[count] = sp
                count += 1
            if abs(hq) <= eps and -eps <= sq <= length + eps:
                touches[count] = sq
                count += 1
            continue
        s = sp + (sq - sp) * hp / (hp - hq)
        if s < -eps or s > length + eps:
            continue
        edge = math.hypot(qx - px, qy - py)
        # Height of the segment's two ends over the edge's line: a start or end on the edge only touches it.
        start = abs(px * (qy - py) - py * (qx - px)) / edge
        end = abs((px - length * ux) * (qy - py) - (py - length * uy) * (qx - px)) / edge
        if start > eps and end > eps:
            if s > 0.0 and s < length:
                return False
            continue
        touches[count] = s
        count += 1
    if count == 0:
        return True
    touches[count] = 0.0
    touches[count + 1] = length
    cuts = np.sort(touches[: count + 2])
    for k in range(len(cuts) - 1):
        if cuts[k + 1] - cuts[k] > 4 * eps:
            s = 0.5 * (cuts[k] + cuts[k + 1])
            if s > 0.0 and s < length and not point_free(ax + s * ux, ay + s * uy, space):
                return False
    return True


@njit(cache=True)
def segments_free(a: Floats, b: Floats, space: FreeSpace) -> Bools:
    """Whether each straight segment `a` → `b`, (k, 2) [m], stays in free space, shape (k,)."""
    out = np.empty(len(a), dtype=np.bool_)
    for k in range(len(a)):
        out[k] = segment_free(a[k, 0], a[k, 1], b[k, 0], b[k, 1], space)
    return out
