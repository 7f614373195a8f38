"""Dubins paths in a steady wind: the least time to fly from pose to pose, which in the air is a chase.

In the frame of the air, in turning radii and radians flown, the goal drifts: after s it lies at d − w s, w the wind
over the airspeed, |w| < 1. A word of the Dubins set with turns t and q and a middle p arrives where its end is there
and t + p + q = s. With u(h) the direction of a heading h and n(h) = (sin h, −cos h) the right of it:

* LSL   p u(φ) = b − w p,  b = d − n(h1) + n(h0) − w K,  so  (1 − w²) p² + 2 (b·w) p − b² = 0,
        K = h1 − h0 + 2πk the sum of the turns, fixed before p is known
* LSR   p u(φ) + c n(φ) = v(s),  v = d + n(h0) + n(h1) − w s,  |v|² = p² + c²,  c = 2,  s = p + c φ − h0 − h1 + 2πk:
        the right side less s falls with s at the rate 1 + w·u, so for each k there is one root
* SR    the same with c = 1 and no first turn, from any heading: a depot where one may take off as one likes
* LRL   v(s) = 4 sin(p/2) u(φ − p/2),  v = d + n(h0) − n(h1) − w s,  π ≤ p ≤ 2π,  s − 2p = h1 − h0 + 2πk:
        the left side is convex in s, falls to a least value known in closed form, and rises

and the mirror images. Headings are those of the air. Full turns may be added to either turn, so that a word arrives at
the least s at which s less its own length is 2πk, k ≥ 0: where Dubins lengths jump the shortest path can be there too
early, and every word is solved for separately. The least of all is the time of flight (Techy & Woolsey, J. Guid.
Control Dyn. 32 (2009) 1768; McGee & Hedrick 2005). Paths lengthened otherwise than by another word or by full turns
are not looked for.
"""

from __future__ import annotations

import math

import numpy as np

from instances.arrays import Floats, Ints
from instances.kernels import njit

_TURN = 2.0 * math.pi
_ROUNDING = 1e-9
"""By so much [rad] the turns of a word may miss what they add up to."""
_STEPS = 80
"""Steps of Newton's method at most: half an interval each at worst."""
_MORE = 10
"""Full turns tried beyond the fewest; a tangent's direction varies by less than two over all s."""
_NEAR, _TRIED = 4.0, 32
"""Radii from which on one line and one turn are quickest from a free heading; headings tried below that."""
Segments = tuple[float, float, float]


@njit(cache=True)
def _angle(x: float) -> float:
    """Return x modulo 2π in [0, 2π), rounding just below a full turn read as 0."""
    x = x % _TURN
    return 0.0 if x > _TURN - 1e-10 else x


@njit(cache=True)
def _with_turns(t: float, p: float, q: float, total: float) -> Segments:
    """Return the segments, full turns added to the first so that both turns make `total`; inf where they exceed it."""
    more = total - t - q
    if more < -_ROUNDING:
        return math.inf, math.inf, math.inf
    return t + _TURN * round(more / _TURN), p, q


@njit(cache=True)
def _same_side(dx: float, dy: float, h0: float, h1: float, wx: float, wy: float) -> Segments:
    """Return the segments of the least LSL."""
    room = 1.0 - wx * wx - wy * wy
    total = _angle(h1 - h0)
    for _ in range(2):  # with one more full turn there is a solution
        bx = dx - math.sin(h1) + math.sin(h0) - wx * total
        by = dy + math.cos(h1) - math.cos(h0) - wy * total
        along = bx * wx + by * wy
        p = (math.sqrt(along * along + room * (bx * bx + by * by)) - along) / room
        x, y = bx - wx * p, by - wy * p
        t = _angle(math.atan2(y, x) - h0) if p > 1e-10 else 0.0
        segments = _with_turns(t, p, _angle(h1 - h0 - t), total)
        if segments[0] < math.inf:
            return segments
        total += _TURN
    return segments


@njit(cache=True)
def _tangent(ex: float, ey: float, wx: float, wy: float, c: float, s: float, rx: float, ry: float) -> Segments:
    """Return p, φ and w·u of the straight line at s; φ goes on from the direction (rx, ry) without a jump."""
    x, y = ex - wx * s, ey - wy * s
    p = math.sqrt(max(x * x + y * y - c * c, 0.0))
    phi = math.atan2(ry, rx) + math.atan2(rx * y - ry * x, rx * x + ry * y) + math.atan2(c, p)
    return p, phi, wx * math.cos(phi) + wy * math.sin(phi)


@njit(cache=True)
def _to_the_right(
    ex: float, ey: float, h0: float, h1: float, wx: float, wy: float, c: float, first: float, last: float
) -> Segments:
    """Return the segments of the least word that ends its line by turning right, s from `first` to `last`.

    c : 2 after a left turn, LSR; 1 from any heading, SR.
    """
    rx, ry = ex - wx * first, ey - wy * first
    p, phi, _ = _tangent(ex, ey, wx, wy, c, first, rx, ry)
    ends = h1 + (h0 if c == 2.0 else 0.0)
    base = p + c * phi - ends - first
    wind = math.hypot(wx, wy)
    fewest = math.ceil(-base / _TURN - _ROUNDING)
    for more in range(_MORE):
        turns = _TURN * (fewest + more)
        ahead = max(base + turns, 0.0)
        low, high = first + ahead / (1.0 + wind), min(first + ahead / (1.0 - wind), last)
        if low > high + _ROUNDING:
            break
        s = min(first + ahead, high)
        for _ in range(_STEPS):
            p, phi, drift = _tangent(ex, ey, wx, wy, c, s, rx, ry)
            miss = p + c * phi - ends + turns - s
            if miss > 0.0:
                low = s
            else:
                high = s
            following = s + miss / (1.0 + drift)
            if not low <= following <= high:
                following = 0.5 * (low + high)
            if abs(following - s) <= 1e-15 * s:
                break
            s = following
        if abs(miss) > 1e-9 * (1.0 + s):  # the root lies behind the last s
            break
        t = _angle(phi - h0) if c == 2.0 else 0.0
        segments = _with_turns(t, p, _angle(phi - h1), c * phi - ends + turns)
        if segments[0] < math.inf:
            return segments
    return math.inf, math.inf, math.inf


@njit(cache=True)
def _line_then_right(ex: float, ey: float, h0: float, h1: float, wx: float, wy: float, c: float) -> Segments:
    """Return the segments of the least LSR (c = 2) or SR (c = 1), before and after the goal's circle is too near."""
    w2, along, room = wx * wx + wy * wy, ex * wx + ey * wy, ex * ex + ey * ey - c * c
    none = (math.inf, math.inf, math.inf)
    root = along * along - w2 * room
    if w2 == 0.0 or root <= 0.0:
        return _to_the_right(ex, ey, h0, h1, wx, wy, c, 0.0, math.inf) if room >= 0.0 else none
    # |v| < c between these
    enters, leaves = (along - math.sqrt(root)) / w2, (along + math.sqrt(root)) / w2
    if leaves <= 0.0:
        return _to_the_right(ex, ey, h0, h1, wx, wy, c, 0.0, math.inf)
    found = _to_the_right(ex, ey, h0, h1, wx, wy, c, 0.0, enters) if enters >= 0.0 else none
    return found if found[0] < math.inf else _to_the_right(ex, ey, h0, h1, wx, wy, c, leaves, math.inf)


@njit(cache=True)
def _middle(ex: float, ey: float, wx: float, wy: float, s: float) -> tuple[float, float, float, float]:
    """Return v(s), the middle arc p of LRL and s − 2p."""
    x, y = ex - wx * s, ey - wy * s
    p = _TURN - 2.0 * math.asin(min(0.25 * math.hypot(x, y), 1.0))
    return x, y, p, s - 2.0 * p


@njit(cache=True)
def _on_branch(
    ex: float, ey: float, h0: float, h1: float, wx: float, wy: float, first: float, last: float, rising: bool
) -> Segments:
    """Return the segments of the least LRL with s from `first` to `last`, where s − 2p rises or falls."""
    low_value, high_value = _middle(ex, ey, wx, wy, first)[3], _middle(ex, ey, wx, wy, last)[3]
    turn = math.ceil((low_value - h1 + h0) / _TURN - _ROUNDING)
    if not rising:
        turn = math.floor((low_value - h1 + h0) / _TURN + _ROUNDING)
    for _ in range(_MORE):
        aim = h1 - h0 + _TURN * turn
        if (aim > high_value + _ROUNDING) if rising else (aim < high_value - _ROUNDING):
            break
        low, high = first, last
        for _ in range(_STEPS):
            s = 0.5 * (low + high)
            if not low < s < high:
                break
            if (_middle(ex, ey, wx, wy, s)[3] < aim) == rising:
                low = s
            else:
                high = s
        x, y, p, _ = _middle(ex, ey, wx, wy, s)
        phi = math.atan2(y, x) + 0.5 * p
        segments = _with_turns(_angle(phi - h0), p, _angle(h1 - phi + p), s - p)
        if segments[0] < math.inf:
            return segments
        turn += 1 if rising else -1
    return math.inf, math.inf, math.inf


@njit(cache=True)
def _three_turns(dx: float, dy: float, h0: float, h1: float, wx: float, wy: float) -> Segments:
    """Return the segments of the least LRL."""
    none = (math.inf, math.inf, math.inf)
    ex, ey = dx + math.sin(h0) - math.sin(h1), dy - math.cos(h0) + math.cos(h1)
    w2, e2 = wx * wx + wy * wy, ex * ex + ey * ey
    # without wind s − 2p rises for ever, and two full turns more than the middle arc are enough
    first, last, least = 0.0, 6.0 * _TURN, 0.0
    if w2 > 0.0:
        nearest, beside2 = (ex * wx + ey * wy) / w2, (ex * wy - ey * wx) ** 2 / w2
        if beside2 >= 16.0:
            return none
        half = math.sqrt((16.0 - beside2) / w2)
        first, last = max(nearest - half, 0.0), nearest + half
        lower = 8.0 * (1.0 - w2 + math.sqrt((1.0 - w2) ** 2 + 0.25 * w2 * beside2))
        least = max(nearest - math.sqrt(max(lower - beside2, 0.0) / w2), first) if lower < 16.0 else first
        if last <= 0.0:
            return none
        last = min(last, max(least, 0.0) + 6.0 * _TURN)
    elif e2 > 16.0:
        return none
    found = _on_branch(ex, ey, h0, h1, wx, wy, first, least, False) if least > first else none
    return found if found[0] < math.inf else _on_branch(ex, ey, h0, h1, wx, wy, max(least, first), last, True)


@njit(cache=True)
def _word(word: int, x: float, y: float, h0: float, h1: float, wx: float, wy: float) -> Segments:
    """Return the segments, in turning radii, with which a word (row of `dubins.TURNS`) arrives first."""
    side = 1.0 if word == 0 or word == 2 or word == 5 else -1.0  # right first is the mirror image
    y, h0, h1, wy = side * y, side * h0, side * h1, side * wy
    if word < 2:
        return _same_side(x, y, h0, h1, wx, wy)
    if word < 4:
        ex, ey = x + math.sin(h0) + math.sin(h1), y - math.cos(h0) - math.cos(h1)
        return _line_then_right(ex, ey, h0, h1, wx, wy, 2.0)
    return _three_turns(x, y, h0, h1, wx, wy)


@njit(cache=True)
def wind_path(
    dx: float, dy: float, h0: float, h1: float, radius: float, wx: float, wy: float
) -> tuple[int, float, float, float]:
    """Return word (row of `dubins.TURNS`) and segments [m of air] of the quickest path to (dx, dy) [m] over ground.

    h0, h1 : air headings [rad]. wx, wy : wind over airspeed, together below 1. The time is the segments' sum over the
    airspeed.
    """
    best, found, shortest = 0, (math.inf, math.inf, math.inf), math.inf
    for word in range(6):
        each = _word(word, dx / radius, dy / radius, h0, h1, wx, wy)
        length = each[0] + each[1] + each[2]
        if length < shortest:
            best, found, shortest = word, each, length
    return best, found[0] * radius, found[1] * radius, found[2] * radius


@njit(cache=True)
def wind_path_free(
    dx: float, dy: float, first: bool, heading: float, radius: float, wx: float, wy: float
) -> tuple[int, float, float, float, float]:
    """Return word, segments [m of air] and the free heading [rad] of the quickest path of one line and one turn.

    Within a few radii, where two turns may be quicker, also paths of some headings are tried. first : whether the
    heading at the start is the free one, else that at the end; `heading` [rad] is the other.
    """
    x, y, h, sign = dx / radius, dy / radius, heading, 1.0
    if not first:  # flown backwards, the wind turned round
        x, y, h, sign = -x, -y, heading + math.pi, -1.0
    right, p, q, shortest = 1.0, math.inf, math.inf, math.inf
    for side in (1.0, -1.0):
        ex, ey = x + math.sin(side * h), side * y - math.cos(side * h)
        circles, line, turn = _line_then_right(ex, ey, 0.0, side * h, sign * wx, sign * side * wy, 1.0)
        turn += circles
        if line + turn < shortest:
            right, p, q, shortest = side, line, turn, line + turn
    free = h + right * q
    if first:
        best = 1 if right > 0.0 else 0, 0.0, p * radius, q * radius, free
    else:
        best = 0 if right > 0.0 else 1, q * radius, p * radius, 0.0, free - math.pi
    if dx * dx + dy * dy < (_NEAR * radius) ** 2:
        for k in range(_TRIED):
            free = _TURN * k / _TRIED
            ends = (free, heading) if first else (heading, free)
            word, a, b, c = wind_path(dx, dy, ends[0], ends[1], radius, wx, wy)
            if a + b + c < best[1] + best[2] + best[3]:
                best = word, a, b, c, free
    return best


@njit(cache=True)
def wind_lengths(
    points: Floats, nodes: Ints, lows: Floats, widths: Floats, radius: float, wx: float, wy: float
) -> Floats:
    """Return the air lengths [m] of the quickest legs between all states, (S, S); 0 between those of one node.

    points : of the nodes [m], (N, 2). nodes, lows [rad], widths [rad], 0 or 2π : of the states, (S,). A leg between a
    free heading and a given one is that of `wind_path_free`; between two free headings it is straight. wx, wy : wind
    over airspeed.
    """
    size = nodes.size
    length = np.zeros((size, size))
    for s in range(size):
        for t in range(size):
            i, j = nodes[s], nodes[t]
            if i == j:
                continue
            dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            if widths[s] > 0.0 and widths[t] > 0.0:
                along, room = wx * dx + wy * dy, 1.0 - wx * wx - wy * wy
                length[s, t] = (math.sqrt(along * along + room * (dx * dx + dy * dy)) - along) / room
            elif widths[s] > 0.0 or widths[t] > 0.0:
                heading = lows[t] if widths[s] > 0.0 else lows[s]
                _, a, b, c, _ = wind_path_free(dx, dy, widths[s] > 0.0, heading, radius, wx, wy)
                length[s, t] = a + b + c
            else:
                _, a, b, c = wind_path(dx, dy, lows[s], lows[t], radius, wx, wy)
                length[s, t] = a + b + c
    return length
