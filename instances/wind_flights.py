"""How long a given way over ground takes that is begun at a time, at constant airspeed in a wind that changes.

On a polyline the ground speed is that of the wind triangle, dt/ds = 1/g(s, t). The track is fixed, so solutions do not
cross: it is "first in, first out". Integrated by Kutta's rule of third order on pieces of each segment,

    k₁ = 1/g(s, t),  k₂ = 1/g(s + h/2, t + h k₁/2),  k₃ = 1/g(s + h, t − h k₁ + 2 h k₂),  Δt = h (k₁ + 4 k₂ + k₃)/6,

which is Simpson's where the wind does not change. Pieces are halved until the times have settled to `TOLERANCE`, as
some of the flights tell.

Source: W. Kutta, Z. Math. Phys. 46 (1901) 435–453.
"""

from __future__ import annotations

import numpy as np

from instances.arrays import Floats, Ints
from instances.environment.wind_changing import ChangingWind
from instances.moving_cost import segments
from instances.wind_triangle import ground_speeds, refuse_strong

PIECE = 200.0
"""Greatest length [m] of a piece at first."""
HALVINGS = 8
"""Of the pieces, at most."""
TOLERANCE = 5e-5
"""Share of the time by which halving the pieces may still change it; the finer pieces are kept."""
TELLING = 64
"""Flights at least, or every so-many-th, that tell how fine pieces must be."""
TOGETHER = 1 << 13
"""Flights that advance together: few are as dear as many, and these lie in a processor's cache."""


def polyline_times(
    points: Floats, offsets: Ints, which: Ints, departures: Floats, wind: ChangingWind, airspeed: float
) -> Floats:
    """Return the time [s] of each flight along polyline `which` (k,), begun at `departures` (k,) [s], shape (k,).

    Polyline p is ``points[offsets[p]:offsets[p + 1]]`` [m]; one of no points takes no time. Raises InputError that
    names a place where the wind is as strong as `airspeed` [m/s].
    """
    a, b, owner = segments(points, offsets)
    moving = np.hypot(*(b - a).T) > 0
    a, b, owner = a[moving], b[moving], owner[moving]
    some = np.arange(len(which))[:: max(1, min(TELLING, len(which) // TELLING))]
    rough = np.full(len(some), np.inf)
    for halving in range(HALVINGS + 1):
        pieces = _Pieces.of(a, b, owner, len(offsets) - 1, PIECE / 2**halving)
        fine = pieces.flown(which[some], departures[some], wind, airspeed)
        if (np.abs(fine - rough) <= TOLERANCE * fine).all():
            break
        rough = fine
    return fine if len(some) == len(which) else pieces.flown(which, departures, wind, airspeed)


class _Pieces:
    """Pieces of polylines: starts, displacements, tangents and lengths [m], and where those of each polyline begin.

    A piece's are a row, x, y, Δx, Δy, eₓ, e_y, |Δ|: taken six times as fast as from four arrays.
    """

    def __init__(self, start: Floats, d: Floats, first: Ints) -> None:
        far = np.hypot(*d.T)[:, None]
        self.rows, self.first = np.hstack([start, d, d / far, far]), first

    @classmethod
    def of(cls, a: Floats, b: Floats, owner: Ints, count: int, longest: float) -> _Pieces:
        """Return the segments `a` → `b` of `count` polylines in equal pieces no longer than `longest` [m]."""
        number = np.maximum(1, np.ceil(np.hypot(*(b - a).T) / longest)).astype(np.int64)
        which = np.repeat(np.arange(len(a)), number)
        inner = np.arange(len(which)) - np.repeat(np.cumsum(number) - number, number)
        d = ((b - a) / number[:, None])[which]
        each = np.bincount(owner[which], minlength=count)
        return cls(a[which] + inner[:, None] * d, d, np.concatenate([[0], np.cumsum(each)]).astype(np.int64))

    def flown(self, which: Ints, departures: Floats, wind: ChangingWind, airspeed: float) -> Floats:
        """Return the times [s] of the flights along polylines `which` (k,) begun at `departures` (k,) [s]."""
        count = (self.first[1:] - self.first[:-1])[which]
        order = np.argsort(-count, kind="stable")  # those of most pieces first: who still flies is a slice
        found = np.empty(len(which))
        for begin in range(0, len(which), TOGETHER):
            some = order[begin : begin + TOGETHER]
            found[some] = self._together(self.first[which[some]], count[some], departures[some], wind, airspeed)
        return found

    def _together(self, first: Ints, left: Ints, begun: Floats, wind: ChangingWind, airspeed: float) -> Floats:
        """Return the times (k,) [s] of flights over `left` pieces (k,), falling, from `first` on, begun at `begun`."""
        times = begun.astype(np.float64)
        for piece in range(int(left.max(initial=0))):
            flying = int(np.searchsorted(-left, -piece, side="left"))
            at = self.rows.take(first[:flying] + piece, axis=0)
            start, d, tangents, far = at[:, 0:2], at[:, 2:4], at[:, 4:6], at[:, 6]
            now = times[:flying]
            one = far * _slowness(start, now, tangents, wind, airspeed)
            two = far * _slowness(start + 0.5 * d, now + 0.5 * one, tangents, wind, airspeed)
            three = far * _slowness(start + d, now - one + 2.0 * two, tangents, wind, airspeed)
            times[:flying] = now + (one + 4.0 * two + three) / 6.0
        return times - begun


def _slowness(points: Floats, times: Floats, tangents: Floats, wind: ChangingWind, airspeed: float) -> Floats:
    """Return 1/g [s/m] at `points` (k, 2) [m] and `times` (k,) [s] along unit `tangents` (k, 2)."""
    w = wind.velocities(points, times)
    if not (w[:, 0] ** 2 + w[:, 1] ** 2).max(initial=0.0) < (1.0 - 1e-9) * airspeed**2:  # in a tenth of hypot's time
        refuse_strong(points, np.hypot(*w.T), airspeed)
    return np.asarray(1.0 / ground_speeds(w, tangents, airspeed))
