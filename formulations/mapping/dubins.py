"""Dubins paths: the shortest flight of bounded turning radius between two poses.

The paper's UAV model (§Numerical Example): ẋ = v cos θ, ẏ = v sin θ, θ̇ = u with |u| ≤ v / r_min. A shortest
path is one of six words of three segments (Dubins 1957): LSL, RSR, LSR, RSL, RLR, LRL. The formulas below are
those of Shkel & Lumelsky (2001, "Classification of the Dubins set") in units of the turning radius, with the
start at the origin: d the distance to the goal, α and β the two headings relative to the line to the goal.

A pose is (x [m], y [m], heading [rad], anticlockwise from east).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from instances.arrays import Floats, Ints
from instances.kernels import njit

TURNS = np.array([[1, 0, 1], [-1, 0, -1], [1, 0, -1], [-1, 0, 1], [-1, 1, -1], [1, -1, 1]], dtype=np.int8)
"""Signs of curvature of the three segments of LSL, RSR, LSR, RSL, RLR, LRL: 1 left, −1 right, 0 straight."""

_TURN = 2.0 * math.pi
# Below this an angle is 0 up to rounding: without it, flying on straight would be priced as a full circle.
_ANGLE_ROUNDING = 1e-10


@njit(cache=True)
def _angle(x: float) -> float:
    """Return x modulo 2π in [0, 2π), rounding just below a full turn read as 0."""
    x = x % _TURN
    return 0.0 if x > _TURN - _ANGLE_ROUNDING else x


@njit(cache=True)
def _word_segments(word: int, d: float, a: float, b: float) -> tuple[float, float, float]:
    """Return the three segment lengths of `word` in units of the radius, or (inf, inf, inf) where it does not exist."""
    sa, sb, ca, cb, cab = math.sin(a), math.sin(b), math.cos(a), math.cos(b), math.cos(a - b)
    none = (math.inf, math.inf, math.inf)
    if word == 0:  # LSL
        x, y = d + sa - sb, cb - ca
        p = math.hypot(x, y)
        # both turns on one circle: any tangent will do, and rounding must not choose one behind the start
        tangent = math.atan2(y, x) if p > _ANGLE_ROUNDING else a
        return _angle(tangent - a), p, _angle(b - tangent)
    if word == 1:  # RSR
        x, y = d - sa + sb, ca - cb
        p = math.hypot(x, y)
        tangent = math.atan2(y, x) if p > _ANGLE_ROUNDING else a
        return _angle(a - tangent), p, _angle(tangent - b)
    if word == 2:  # LSR
        p2 = d * d - 2.0 + 2.0 * cab + 2.0 * d * (sa + sb)
        if p2 < 0.0:
            return none
        p = math.sqrt(p2)
        tangent = math.atan2(-ca - cb, d + sa + sb) - math.atan2(-2.0, p)
        return _angle(tangent - a), p, _angle(tangent - b)
    if word == 3:  # RSL
        p2 = d * d - 2.0 + 2.0 * cab - 2.0 * d * (sa + sb)
        if p2 < 0.0:
            return none
        p = math.sqrt(p2)
        tangent = math.atan2(ca + cb, d - sa - sb) - math.atan2(2.0, p)
        return _angle(a - tangent), p, _angle(b - tangent)
    if word == 4:  # RLR
        c = (6.0 - d * d + 2.0 * cab + 2.0 * d * (sa - sb)) / 8.0
        if abs(c) > 1.0:
            return none
        p = _TURN - math.acos(c)  # the middle arc exceeds π: a full circle here is one, not nothing
        t = _angle(a - math.atan2(ca - cb, d - sa + sb) + p / 2.0)
        return t, p, _angle(a - b - t + p)
    c = (6.0 - d * d + 2.0 * cab + 2.0 * d * (sb - sa)) / 8.0  # LRL
    if abs(c) > 1.0:
        return none
    p = _TURN - math.acos(c)
    t = _angle(-a + math.atan2(cb - ca, d + sa - sb) + p / 2.0)
    return t, p, _angle(b - a - t + p)


@njit(cache=True)
def dubins_path(
    x0: float, y0: float, h0: float, x1: float, y1: float, h1: float, radius: float
) -> tuple[int, float, float, float]:
    """Return the shortest path's word (row of TURNS) and its three segment lengths [m]."""
    dx, dy = x1 - x0, y1 - y0
    d = math.hypot(dx, dy) / radius
    line = math.atan2(dy, dx) if d > 0.0 else 0.0
    a, b = _angle(h0 - line), _angle(h1 - line)
    best, shortest = 0, math.inf
    s0 = s1 = s2 = 0.0
    for word in range(6):
        t, p, q = _word_segments(word, d, a, b)
        if t + p + q < shortest:
            best, shortest, s0, s1, s2 = word, t + p + q, t, p, q
    return best, s0 * radius, s1 * radius, s2 * radius


@njit(cache=True)
def dubins_length(x0: float, y0: float, h0: float, x1: float, y1: float, h1: float, radius: float) -> float:
    """Return the length [m] of the shortest path between two poses."""
    _, a, b, c = dubins_path(x0, y0, h0, x1, y1, h1, radius)
    return a + b + c


@njit(cache=True)
def advance(x: float, y: float, h: float, turn: int, length: float, radius: float) -> tuple[float, float, float]:
    """Return the pose after flying `length` [m] with `turn` 1 (left), −1 (right) or 0 (straight)."""
    if turn == 0 or radius == 0.0:  # a polyline has no radius, and turns of length 0
        return x + length * math.cos(h), y + length * math.sin(h), h
    h1 = h + turn * length / radius
    return x + turn * radius * (math.sin(h1) - math.sin(h)), y - turn * radius * (math.cos(h1) - math.cos(h)), h1


@njit(cache=True)
def poses_along(
    starts: Floats, turns: NDArray[np.int8], segments: Floats, travelled: Floats, radius: float, poses: Floats
) -> None:
    """Write into `poses` (k, 3) the pose after `travelled[i]` metres of path i.

    starts : poses (k, 3); turns and segments [m] of the three segments of each path, shape (k, 3).
    """
    for i in range(len(travelled)):
        x, y, h = starts[i, 0], starts[i, 1], starts[i, 2]
        left = travelled[i]
        for part in range(3):
            x, y, h = advance(x, y, h, turns[i, part], min(left, segments[i, part]), radius)
            left -= segments[i, part]
            if left <= 0.0:
                break
        poses[i, 0], poses[i, 1], poses[i, 2] = x, y, h


@njit(cache=True)
def heading_costs(points: Floats, headings: Floats, radius: float) -> Floats:
    """Return Dubins lengths [m] of each leg of a closed tour for all heading pairs, shape (w, H, H).

    points : waypoints [m] in flying order, shape (w, 2); the last leg returns to the first.
    headings : candidate headings [rad] of each waypoint, shape (w, H).
    """
    w, count = headings.shape
    cost = np.empty((w, count, count))
    for k in range(w):
        j = (k + 1) % w
        for a in range(count):
            for b in range(count):
                cost[k, a, b] = dubins_length(
                    points[k, 0], points[k, 1], headings[k, a], points[j, 0], points[j, 1], headings[j, b], radius
                )
    return cost


@njit(cache=True)
def closed_programme(cost: Floats) -> tuple[float, Ints]:
    """Return the least length [m] and the heading choice of each waypoint of a closed tour, shape (w,).

    A dynamic programme along the tour for each heading of the first waypoint, which the tour must end with.
    """
    w, count = cost.shape[0], cost.shape[1]
    best, choice = math.inf, np.zeros(w, dtype=np.int64)
    came = np.empty((w, count), dtype=np.int64)
    for first in range(count):
        value = np.full(count, math.inf)
        value[first] = 0.0
        for k in range(w):
            new = np.full(count, math.inf)
            for b in range(count):
                for a in range(count):
                    total = value[a] + cost[k, a, b]
                    if total < new[b]:
                        new[b] = total
                        came[k, b] = a
            value = new
        if value[first] < best:
            best = value[first]
            b = first
            for k in range(w - 1, -1, -1):
                b = came[k, b]
                choice[k] = b
    return best, choice
