"""Newton polish: from any feasible path to the locally best one of its homotopy class.

The steps are those of ``newton.py``, sideways moves of the nodes. Obstacles enter as in a taut string:

* a step that would sweep over a corner of an obstacle (the corner lies between old and new path: winding
  number) is cut short there and the corner becomes a *pin*, a fixed node of the path;
* a node that would enter an obstacle through an edge (a curved path can, without sweeping a corner) stays
  on the edge as long as the gradient pushes it there;
* a pin lets go where moving away from the obstacle lowers the cost.

Paths through the corners of a polygon thus end exactly in them, and in a potential wind the result is the
shortest path of its class to rounding.
"""

from __future__ import annotations

import math

import numpy as np

from formulations.moving_cost.field import Bending
from formulations.moving_cost.free_space import FreeSpace, clearance_at, point_free, segment_free
from formulations.moving_cost.newton import newton_step
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit

STEPS = 60
"""Newton steps at most, and one more for every corner there is to wrap around; a path that has not settled by then
is judged by its cost as it is."""


@njit(cache=True)
def subdivide(p: Floats, corner: Ints, h: float) -> tuple[Floats, Ints]:
    """Split each segment into equal pieces no longer than h; corner[k] ≥ 0 marks a node in an obstacle's corner."""
    count = 1
    for k in range(len(p) - 1):
        length = math.hypot(p[k + 1, 0] - p[k, 0], p[k + 1, 1] - p[k, 1])
        count += max(1, math.ceil(length / h - 1e-9)) if length > 0 else 0
    q = np.empty((count, 2))
    c = np.full(count, -1, dtype=np.int64)
    q[0], c[0] = p[0], corner[0]
    at = 0
    for k in range(len(p) - 1):
        length = math.hypot(p[k + 1, 0] - p[k, 0], p[k + 1, 1] - p[k, 1])
        pieces = max(1, math.ceil(length / h - 1e-9)) if length > 0 else 0
        for i in range(1, pieces + 1):
            at += 1
            for d in range(2):
                q[at, d] = p[k, d] + (p[k + 1, d] - p[k, d]) * i / pieces
        if pieces > 0:
            q[at] = p[k + 1]
        if pieces > 0 or corner[k + 1] >= 0:
            c[at] = corner[k + 1]
    return q, c


@njit(cache=True)
def _between(x: float, y: float, old: Floats, new: Floats) -> bool:
    """Whether a point lies between two paths with common ends: winding number of the loop old, then new back."""
    winding = 0
    n = len(old)
    for side in range(2):
        path = old if side == 0 else new
        for k in range(n - 1):
            ax, ay, bx, by = path[k, 0], path[k, 1], path[k + 1, 0], path[k + 1, 1]
            if (ay <= y) != (by <= y):
                left = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
                if ay <= y and left > 0:
                    winding += 1 if side == 0 else -1
                elif by <= y and left < 0:
                    winding -= 1 if side == 0 else -1
    return winding != 0


@njit(cache=True)
def _swept_corner(old: Floats, new: Floats, corner: Ints, space: FreeSpace) -> int:
    """Index of a corner of an obstacle that lies between the two paths and is no pin of theirs, or −1."""
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    near = False
    for k in range(len(old)):
        x0, x1 = min(x0, old[k, 0], new[k, 0]), max(x1, old[k, 0], new[k, 0])
        y0, y1 = min(y0, old[k, 1], new[k, 1]), max(y1, old[k, 1], new[k, 1])
        move = math.hypot(new[k, 0] - old[k, 0], new[k, 1] - old[k, 1])
        h = math.hypot(old[k, 0] - old[k - 1, 0], old[k, 1] - old[k - 1, 1]) if k > 0 else 0.0
        near = near or clearance_at(old[k, 0], old[k, 1], space) <= move + h
    if not near:
        return -1
    for c in range(len(space.corners)):
        x, y = space.corners[c, 0], space.corners[c, 1]
        if x < x0 or x > x1 or y < y0 or y > y1:
            continue
        pinned = False
        for k in range(len(corner)):
            pinned = pinned or corner[k] == c
        if not pinned and _between(x, y, old, new):
            return c
    return -1


@njit(cache=True)
def _pin(p: Floats, corner: Ints, c: int, space: FreeSpace) -> tuple[Floats, Ints]:
    """Return the path with corner `c` as a node of its nearest segment."""
    x, y = space.corners[c, 0], space.corners[c, 1]
    best, at, where = np.inf, 0, 0.0
    for k in range(len(p) - 1):
        dx, dy = p[k + 1, 0] - p[k, 0], p[k + 1, 1] - p[k, 1]
        t = min(max(((x - p[k, 0]) * dx + (y - p[k, 1]) * dy) / (dx * dx + dy * dy), 0.0), 1.0)
        d = (p[k, 0] + t * dx - x) ** 2 + (p[k, 1] + t * dy - y) ** 2
        if d < best:
            best, at, where = d, k, t
    near = at if where < 0.25 else at + 1
    if (where < 0.25 or where > 0.75) and 0 < near < len(p) - 1 and corner[near] < 0:
        p[near, 0], p[near, 1], corner[near] = x, y, c
        return p, corner
    q, d2 = np.empty((len(p) + 1, 2)), np.empty(len(p) + 1, dtype=np.int64)
    q[: at + 1], d2[: at + 1] = p[: at + 1], corner[: at + 1]
    q[at + 1, 0], q[at + 1, 1], d2[at + 1] = x, y, c
    q[at + 2 :], d2[at + 2 :] = p[at + 1 :], corner[at + 1 :]
    return q, d2


@njit(cache=True)
def _stop_at_edges(old: Floats, new: Floats, edge: Ints, held: Bools, space: FreeSpace) -> None:
    """Move nodes of `new` that entered an obstacle back to where they crossed its edge, and note the edge."""
    for k in range(1, len(new) - 1):
        if held[k]:
            continue
        edge[k] = -1
        if point_free(new[k, 0], new[k, 1], space):
            continue
        ax, ay = old[k, 0], old[k, 1]
        dx, dy = new[k, 0] - ax, new[k, 1] - ay
        first, nearest, distance, along = 2.0, -1, np.inf, 0.0
        for e in range(len(space.edges)):
            ex, ey = space.edges[e, 2] - space.edges[e, 0], space.edges[e, 3] - space.edges[e, 1]
            px, py = space.edges[e, 0] - ax, space.edges[e, 1] - ay
            across = dx * ey - dy * ex
            if across > 0.0:  # leaving free space, on the edge's left, means crossing to its right
                t, s = (px * ey - py * ex) / across, (px * dy - py * dx) / across
                if -1e-9 <= s <= 1.0 + 1e-9 and 0.0 <= t < first:
                    first, edge[k] = t, e
            s = min(max(-(px * ex + py * ey) / (ex * ex + ey * ey), 0.0), 1.0)
            d = math.hypot(px + s * ex, py + s * ey)
            if d < distance:
                distance, nearest, along = d, e, s
        if distance <= 2 * space.eps or first > 1.0:
            # It was on an edge already, to rounding: put it there.
            edge[k] = nearest
            new[k, 0] = space.edges[nearest, 0] + along * (space.edges[nearest, 2] - space.edges[nearest, 0])
            new[k, 1] = space.edges[nearest, 1] + along * (space.edges[nearest, 3] - space.edges[nearest, 1])
        else:
            new[k, 0], new[k, 1] = ax + first * dx, ay + first * dy


@njit(cache=True)
def _held(p: Floats, corner: Ints, edge: Ints, g: Floats, normal: Floats, space: FreeSpace) -> Bools:
    """Nodes that do not move: ends, pins, and nodes on an edge that the gradient pushes into it."""
    held = corner >= 0
    held[0] = held[-1] = True
    for k in range(1, len(p) - 1):
        e = edge[k]
        if e >= 0:
            ex, ey = space.edges[e, 2] - space.edges[e, 0], space.edges[e, 3] - space.edges[e, 1]
            free_side = -ey * normal[k, 0] + ex * normal[k, 1]
            held[k] = held[k] or free_side * g[k] >= 0.0
    return held


@njit(cache=True)
def _let_go(p: Floats, corner: Ints, g: Floats, normal: Floats, space: FreeSpace) -> bool:
    """Release pins where moving away from the obstacle lowers the cost; True where one was."""
    found = False
    for k in range(1, len(p) - 1):
        c = corner[k]
        if c < 0:
            continue
        away = space.outward[c, 0] * normal[k, 0] + space.outward[c, 1] * normal[k, 1]
        if away * g[k] < -1e-10:
            corner[k] = -1
            sign = 1.0 if away > 0 else -1.0
            p[k, 0] += 100 * space.eps * sign * normal[k, 0]
            p[k, 1] += 100 * space.eps * sign * normal[k, 1]
            found = True
    return found


@njit(cache=True)
def _drop_crowded(p: Floats, corner: Ints, edge: Ints, space: FreeSpace) -> tuple[Floats, Ints, Ints]:
    """Drop nodes that ran together where the path turned sharply: they would hold up every further step."""
    n = len(p)
    h = np.empty(n + 1)
    h[0] = h[n] = np.inf
    for k in range(1, n):
        h[k] = math.hypot(p[k, 0] - p[k - 1, 0], p[k, 1] - p[k - 1, 1])
    keep = np.ones(n, dtype=np.bool_)
    for k in range(1, n):
        if h[k] >= 0.1 * min(h[k - 1], h[k + 1]):
            continue
        i = k if k < n - 1 and corner[k] < 0 else k - 1
        if 0 < i < n - 1 and corner[i] < 0 and keep[i - 1]:
            keep[i] = not segment_free(p[i - 1, 0], p[i - 1, 1], p[i + 1, 0], p[i + 1, 1], space)
    if keep.all():
        return p, corner, edge
    return p[keep], corner[keep], edge[keep]


@njit(cache=True)
def relax(p: Floats, corner: Ints, bending: Bending, space: FreeSpace, settled: float) -> tuple[Floats, Ints]:
    """Newton steps and obstacle events: the locally best polyline, and the corners its nodes lie in.

    It ends after a step that moved no node by more than `settled` of its distance to the next; Newton's next step
    would be of the order of its square.
    """
    edge = np.full(len(p), -1, dtype=np.int64)
    for _ in range(STEPS + len(space.corners)):
        n = len(p)
        held = corner >= 0
        held[0] = held[n - 1] = True
        if (edge >= 0).any():
            g, normal, y = newton_step(p, np.ones(n, dtype=np.bool_), bending)
            held = _held(p, corner, edge, g, normal, space)
        g, normal, y = newton_step(p, held, bending)
        slope = 0.0
        for k in range(n - 1):
            slope = max(slope, abs(y[k + 1] - y[k]) / math.hypot(p[k + 1, 0] - p[k, 0], p[k + 1, 1] - p[k, 1]))
        scale = min(1.0, 0.5 / slope) if slope > 0 else 1.0
        new = p + scale * y.reshape(n, 1) * normal
        c = _swept_corner(p, new, corner, space)
        if c >= 0:
            low, high = 0.0, scale
            for _ in range(24):
                middle = 0.5 * (low + high)
                there = _swept_corner(p, p + middle * y.reshape(n, 1) * normal, corner, space)
                if there >= 0:
                    high, c = middle, there
                else:
                    low = middle
            new = p + low * y.reshape(n, 1) * normal
            _stop_at_edges(p, new, edge, held, space)
            p, corner = _pin(new, corner, c, space)
            edge = np.full(len(p), -1, dtype=np.int64)
            continue
        _stop_at_edges(p, new, edge, held, space)
        shift = 0.0
        for k in range(1, n):
            move = math.hypot(new[k, 0] - p[k, 0], new[k, 1] - p[k, 1])
            shift = max(shift, move / math.hypot(p[k, 0] - p[k - 1, 0], p[k, 1] - p[k - 1, 1]))
        p, corner, edge = _drop_crowded(new, corner, edge, space)
        if len(p) < n:
            continue
        if shift < settled and not _let_go(p, corner, g, normal, space):
            break
    return p, corner


@njit(cache=True)
def path_free(p: Floats, space: FreeSpace) -> bool:
    """Whether every segment stays in free space."""
    free = True
    for k in range(len(p) - 1):
        free = free and segment_free(p[k, 0], p[k, 1], p[k + 1, 0], p[k + 1, 1], space)
    return free


@njit(cache=True)
def refine(p: Floats, corner: Ints, precision: float) -> tuple[Floats, Ints]:
    """Halve the segments at every node whose turn θ is too sharp: a polyline exceeds its smooth curve by θ²/24.

    Pins may turn as they like. Returns the path itself where nothing is left to halve.
    """
    n = len(p)
    halve = np.zeros(n, dtype=np.bool_)
    for k in range(1, n - 1):
        if corner[k] >= 0:
            continue
        ax, ay, bx, by = p[k, 0] - p[k - 1, 0], p[k, 1] - p[k - 1, 1], p[k + 1, 0] - p[k, 0], p[k + 1, 1] - p[k, 1]
        turn = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        if turn * turn > 24 * precision:
            halve[k - 1] = halve[k] = True
    if not halve.any():
        return p, corner
    q, c = np.empty((n + halve.sum(), 2)), np.full(n + halve.sum(), -1, dtype=np.int64)
    at = 0
    for k in range(n):
        q[at], c[at] = p[k], corner[k]
        at += 1
        if halve[k]:
            q[at] = 0.5 * (p[k] + p[k + 1])
            at += 1
    return q, c


@njit(cache=True, nogil=True)
def polish_all(
    points: Floats,
    corners: Ints,
    offsets: Ints,
    spacing: float,
    precision: float,
    space: FreeSpace,
    bending: Bending,
) -> tuple[Floats, Ints, Ints]:
    """Polish paths given end to end: path i is ``points[offsets[i]:offsets[i+1]]``; returns the same three arrays.

    Each is split to pieces of `spacing` [m], relaxed, and refined (pieces halved) where the polyline's own excess over
    the smooth curve is above `precision`, at most six times. A path that ended up in an
    obstacle comes back as it was given.
    """
    out_points, out_corners = np.empty((len(points) * 2 + 1024, 2)), np.empty(len(points) * 2 + 1024, dtype=np.int64)
    out_offsets = np.zeros(len(offsets), dtype=np.int64)
    used = 0
    for i in range(len(offsets) - 1):
        given, marks = points[offsets[i] : offsets[i + 1]], corners[offsets[i] : offsets[i + 1]]
        length = 0.0
        for k in range(len(given) - 1):
            length += math.hypot(given[k + 1, 0] - given[k, 0], given[k + 1, 1] - given[k, 1])
        h = min(spacing, length / 4)  # a path of one piece could not turn
        p, c = subdivide(given, marks, h)
        p, c = relax(p, c, bending, space, 1e-4)
        for _ in range(6):
            if precision <= 0.0:
                break
            count = len(p)
            p, c = refine(p, c, precision)
            if len(p) == count:
                break
            p, c = relax(p, c, bending, space, 1e-3)
        if not path_free(p, space):
            p, c = given, marks
        while used + len(p) > len(out_points):
            out_points = np.concatenate((out_points, np.empty_like(out_points)))
            out_corners = np.concatenate((out_corners, np.empty_like(out_corners)))
        out_points[used : used + len(p)] = p
        out_corners[used : used + len(p)] = c
        used += len(p)
        out_offsets[i + 1] = used
    return out_points[:used].copy(), out_corners[:used].copy(), out_offsets
