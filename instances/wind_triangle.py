"""The wind triangle: how fast a UAV that holds its airspeed moves along a given track, and how long it takes.

To stay on a track of unit tangent e in a wind w at airspeed va, the UAV heads into the wind so that its velocity
through the air and w add up to a velocity along e. With w∥ = w·e and w⊥ the wind across the track,

    ground speed  g = w∥ + √(va² − w⊥²),      time  T = ∫ ds/g,

positive in every direction where |w| < va. Over a segment d in a uniform wind the same is Zermelo's metric,

    T(w, d) = (√((w·d)² + |d|² (va² − |w|²)) − w·d) / (va² − |w|²).

Source: E. Zermelo, ZAMM 11 (1931) 114–124; D. Bao, C. Robles, Z. Shen, J. Differential Geom. 66 (2004) 377–435.
"""

from __future__ import annotations

import numpy as np

from instances.arrays import Floats
from instances.environment.wind import WindField
from instances.errors import InputError

TOLERANCE = 1e-8
"""Difference of the two rules, over the time of the whole segment, at which a piece is not halved any more. The value
kept is Kronrod's, whose error is smaller by orders in a smooth wind."""
DEEPEST = 40
"""Halvings of a segment at most: then a piece is shorter than the rounding of its ends."""

_NODES = np.array([0.0, 0.434243749346802558, 0.774596669241483377, 0.960491268708020283])
_KRONROD = np.array([0.450916538658474142, 0.401397414775962223, 0.268488089868333440, 0.104656226026467265])
_GAUSS = np.array([8.0, 0.0, 5.0, 0.0]) / 9.0


def _rule() -> tuple[Floats, Floats, Floats]:
    """Return nodes in (0, 1) and weights of Kronrod's seven points (1965) and of Gauss's three among them."""
    both = [np.concatenate([half[:0:-1], half]) for half in (_KRONROD, _GAUSS)]
    return 0.5 + 0.5 * np.concatenate([-_NODES[:0:-1], _NODES]), 0.5 * both[0], 0.5 * both[1]


NODES, KRONROD, GAUSS = _rule()


def ground_speeds(w: Floats, tangents: Floats, airspeed: float) -> Floats:
    """Return the ground speeds [m/s] along unit `tangents` (k, 2) in the winds `w` (k, 2) [m/s], shape (k,).

    NaN where the wind across is stronger than the airspeed; not positive where the track cannot be kept.
    """
    along = w[:, 0] * tangents[:, 0] + w[:, 1] * tangents[:, 1]
    across = w[:, 1] * tangents[:, 0] - w[:, 0] * tangents[:, 1]
    with np.errstate(invalid="ignore"):
        return along + np.sqrt(airspeed**2 - across**2)


def flight_times(a: Floats, b: Floats, wind: WindField, airspeed: float, tolerance: float = TOLERANCE) -> Floats:
    """Return the flight time [s] along the straight segments `a` → `b`, each (k, 2) [m], shape (k,).

    By Gauss–Kronrod quadrature of Zermelo's metric, pieces halved until it has settled to `tolerance`.
    Raises InputError that names a place where the wind is as strong as the airspeed.
    """
    total, whole = np.zeros(len(a)), np.empty(0)
    owner, start, size = np.arange(len(a)), np.zeros(len(a)), np.ones(len(a))
    for depth in range(DEEPEST + 1):
        d = size[:, None] * (b - a)[owner]
        at = (a[owner] + start[:, None] * (b - a)[owner])[:, None, :] + NODES[None, :, None] * d[:, None, :]
        times = zermelo_times(at.reshape(-1, 2), np.repeat(d, len(NODES), axis=0), wind, airspeed).reshape(
            -1, len(NODES)
        )
        found, rough = times @ KRONROD, times @ GAUSS
        whole = found if depth == 0 else whole
        rest = np.abs(found - rough) > tolerance * whole[owner] if depth < DEEPEST else np.zeros(len(d), dtype=bool)
        total += np.bincount(owner[~rest], found[~rest], minlength=len(a))
        if not rest.any():
            break
        size = np.repeat(0.5 * size[rest], 2)
        start = np.repeat(start[rest], 2) + np.tile([0.0, 1.0], int(rest.sum())) * size
        owner = np.repeat(owner[rest], 2)
    return total


def zermelo_times(points: Floats, d: Floats, wind: WindField, airspeed: float) -> Floats:
    """Return the time [s] of each displacement `d` (k, 2) [m] in the wind at `points` (k, 2) [m], shape (k,)."""
    w = wind(points)
    room = airspeed**2 - _dot(w, w)
    refuse_strong(points, np.sqrt(np.maximum(airspeed**2 - room, 0.0)), airspeed)
    along = _dot(w, d)
    return np.asarray((np.sqrt(along**2 + _dot(d, d) * room) - along) / room)


def _dot(a: Floats, b: Floats) -> Floats:
    """Return a·b of each row (k,): three times as fast as numpy's sum over rows of two."""
    return np.asarray(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])


def refuse_strong(points: Floats, speeds: Floats, airspeed: float) -> None:
    """Raise InputError that names the place among `points` (k, 2) [m] where `speeds` [m/s] reach the airspeed most."""
    if len(speeds) and not speeds.max() < airspeed:
        worst = int(np.argmax(np.where(np.isnan(speeds), np.inf, speeds)))
        x, y = points[worst]
        raise InputError(
            f"wind: at ({x:.0f}, {y:.0f}) m it blows with {speeds[worst]:.3g} m/s, not less than the airspeed of "
            f"{airspeed:.3g} m/s: flight time needs a wind below it everywhere"
        )
