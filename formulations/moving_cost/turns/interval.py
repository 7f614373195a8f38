"""The Dubins interval problem: the shortest path between two points whose end headings may lie in sectors.

Manyam & Rathinam, arXiv 1507.06980. A sector is [low, low + width], 0 ≤ width ≤ 2π: width 0 is one heading, 2π any.
By Pontryagin's principle the curvature of a shortest path may change where the path crosses the line of the costate
only, and the path begins (ends) on that line where its first (last) heading is inside its sector. So it is one of

* both headings inside: the straight line, or one arc, longer than π, through both points;
* one at an end of its sector, the other inside: that heading, a turn, and a straight line or a turn the other way;
* both at ends of their sectors: one of four Dubins paths.

The least of those whose headings do lie in the sectors is the interval length: all are paths that can be flown, and
the shortest is among them. It is below the Dubins length between any headings of the sectors, and is that length where
both widths are 0. In units of the turning radius, after reduction to the right frame, as in `mapping.dubins`.
"""

from __future__ import annotations

import math

import numpy as np

from formulations.mapping.dubins import dubins_length
from instances.arrays import Floats, Ints
from instances.kernels import njit

_TURN = 2.0 * math.pi
_ROUNDING = 1e-9
"""By so much [rad] a heading may miss its sector, or an arc a full turn: lengths are off by as many radii at most."""


@njit(cache=True)
def _turn(angle: float) -> float:
    """Return `angle` modulo 2π in [0, 2π), what is just below a full turn read as 0."""
    angle = angle % _TURN
    return 0.0 if angle > _TURN - _ROUNDING else angle


@njit(cache=True)
def _inside(heading: float, low: float, width: float) -> bool:
    """Return whether a heading lies in a sector."""
    return _turn(heading - low) <= width + _ROUNDING


@njit(cache=True)
def _to_free_heading(dx: float, dy: float, heading: float, low: float, width: float) -> tuple[float, float]:
    """Return the least length of turn and line, or turn and turn, from `heading` at 0 to (dx, dy), ending inside.

    And the heading it ends with.
    """
    best, reached = math.inf, heading
    for side in (1.0, -1.0):  # the right turns are the left turns of the mirror image
        x, y, h = dx, side * dy, side * heading
        first = low if side > 0.0 else -(low + width)
        vx, vy = x + math.sin(h), y - math.cos(h)
        away, bearing = math.hypot(vx, vy), math.atan2(vy, vx)
        if away >= 1.0:
            straight = math.sqrt(away * away - 1.0)
            end = bearing + math.atan2(1.0, straight)
            length = _turn(end - h) + straight
            if length < best and _inside(end, first, width):
                best, reached = length, side * end
        cosine = (away * away + 3.0) / (4.0 * max(away, 1e-300))
        if cosine <= 1.0:
            for which in (1.0, -1.0):
                apex = bearing + which * math.acos(cosine)
                around = math.atan2(vy - 2.0 * math.sin(apex), vx - 2.0 * math.cos(apex))
                length = _turn(apex + 0.5 * math.pi - h) + _turn(apex + math.pi - around)
                if length < best and _inside(around - 0.5 * math.pi, first, width):
                    best, reached = length, side * (around - 0.5 * math.pi)
    return best, reached


@njit(cache=True)
def _both_free(d: float, line: float, low0: float, width0: float, low1: float, width1: float) -> float:
    """Return the length of the straight line, else the least of the arcs through both points, if headings are inside.

    d : distance of the points; line : direction from one to the other.
    """
    if _inside(line, low0, width0) and _inside(line, low1, width1):
        return d
    best = math.inf
    if 0.0 < d <= 2.0:
        half = math.asin(0.5 * d)
        for arc in (2.0 * half, _TURN - 2.0 * half):
            for side in (1.0, -1.0):
                if _inside(line - side * 0.5 * arc, low0, width0) and _inside(line + side * 0.5 * arc, low1, width1):
                    best = min(best, arc)
    return best


@njit(cache=True)
def interval_length(
    dx: float, dy: float, low0: float, width0: float, low1: float, width1: float, radius: float
) -> float:
    """Return the least length [m] from a point to another, (dx, dy) [m] away, its headings inside two sectors [rad]."""
    d, line = math.hypot(dx, dy) / radius, math.atan2(dy, dx)
    if d == 0.0 and (_inside(low0, low1, width1) or _inside(low1, low0, width0)):
        return 0.0
    best = _both_free(d, line, low0, width0, low1, width1)
    if best == d:
        return best * radius
    x, y = dx / radius, dy / radius
    for a in range(2 if width0 > 0.0 else 1):
        h0 = low0 + a * width0
        if width1 > 0.0:
            best = min(best, _to_free_heading(x, y, h0, low1, width1)[0])
        for b in range(2 if width1 > 0.0 else 1):
            best = min(best, dubins_length(0.0, 0.0, h0, x, y, low1 + b * width1, 1.0))
    if width0 > 0.0:  # backwards from the other end
        for b in range(2 if width1 > 0.0 else 1):
            back = low1 + b * width1 + math.pi
            best = min(best, _to_free_heading(-x, -y, back, low0 + math.pi, width0)[0])
    return best * radius


def free_end(dx: float, dy: float, heading: float, radius: float) -> float:
    """Return the heading [rad] in which the shortest path from `heading` reaches (dx, dy) [m] if any will do."""
    return float(_to_free_heading(dx / radius, dy / radius, heading, 0.0, _TURN)[1])


@njit(cache=True)
def interval_lengths(points: Floats, nodes: Ints, lows: Floats, widths: Floats, radius: float) -> Floats:
    """Return the interval lengths [m] between all states, (S, S); 0 between those of one node, which nobody flies.

    points : of the nodes [m], (N, 2). nodes, lows [rad], widths [rad] : of the states, (S,).
    """
    size = nodes.size
    length = np.zeros((size, size))
    for s in range(size):
        for t in range(size):
            i, j = nodes[s], nodes[t]
            if i == j:
                continue
            dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            if widths[s] == 0.0 and widths[t] == 0.0:
                length[s, t] = dubins_length(0.0, 0.0, lows[s], dx, dy, lows[t], radius)
            else:
                length[s, t] = interval_length(dx, dy, lows[s], widths[s], lows[t], widths[t], radius)
    return length
