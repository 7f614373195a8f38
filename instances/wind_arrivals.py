"""How long a leg takes that begins at a time, at constant airspeed in a wind that changes.

In a wind that is the same everywhere the quickest way is a straight line through the air, flown to where the air will
have carried the goal: with the air's displacement W(t) = ∫₀ᵗ w the leg d begun at t takes the least T with

    |d − W(t + T) + W(t)| = va·T,

a single root where |w| < va, found by Newton's method. Elsewhere the straight track over ground is flown, on which by
the wind triangle (`wind_triangle`)

    ds/dt = g(s, t) = w∥ + √(va² − w⊥²),

integrated by Runge and Kutta's method of fourth order. Both are "first in, first out": who departs later arrives later.

Source: E. Zermelo, ZAMM 11 (1931) 114–124.
"""

from __future__ import annotations

import numpy as np

from instances.arrays import Floats
from instances.environment.wind_changing import ChangingWind, Turning, Valley
from instances.errors import InputError
from instances.wind_triangle import ground_speeds, refuse_strong

ROUNDS = 100
"""Steps of Newton's method at most: half an interval each at worst."""
STEPS = (8, 4096)
"""Steps along a track, first and at most."""
TOLERANCE = 1e-7
"""Share of the time by which doubling the steps may still change it; Richardson's rule takes off 15/16 of that."""


def leg_times(a: Floats, b: Floats, departures: Floats, wind: ChangingWind, airspeed: float) -> Floats:
    """Return the time [s] of each leg `a` → `b`, (k, 2) [m], begun at its time `departures` (k,) [s], shape (k,).

    By the quickest way where the wind is the same everywhere, else along the straight track.
    Raises InputError where the wind is as strong as `airspeed` [m/s].
    """
    if isinstance(wind, Turning | Valley):
        return quickest_times(b - a, departures, wind, airspeed)
    return track_times(a, b, departures, wind, airspeed)


def quickest_times(d: Floats, departures: Floats, wind: Turning | Valley, airspeed: float) -> Floats:
    """Return the least time [s] of each displacement `d` (k, 2) [m] begun at `departures` (k,) [s], shape (k,)."""
    strongest = _strongest(wind)
    if strongest >= airspeed:
        raise InputError(
            f"wind: it blows with up to {strongest:.3g} m/s, not less than the airspeed of {airspeed:.3g} m/s: flight "
            "time needs a wind below it at all times"
        )
    far = np.hypot(*d.T)
    goal = d + wind.displacement(departures)
    low, high = far / (airspeed + strongest), far / (airspeed - strongest)
    time = far / airspeed
    for _ in range(ROUNDS):
        rest = goal - wind.displacement(departures + time)
        left = np.hypot(*rest.T)
        miss = left - airspeed * time
        low, high = np.where(miss > 0, time, low), np.where(miss < 0, time, high)
        towards = np.einsum("ij,ij->i", rest, wind.velocity_at(departures + time))
        slope = airspeed + np.divide(towards, left, out=np.zeros_like(left), where=left > 0)
        step = time + miss / slope
        step = np.where((step < low) | (step > high), 0.5 * (low + high), step)
        settled = np.abs(step - time) <= 1e-15 * time
        time = step
        if settled.all():
            break
    return time


def _strongest(wind: Turning | Valley) -> float:
    """Return a speed [m/s] that the wind never passes."""
    mean = float(np.hypot(*wind.velocity))
    return mean + (float(np.hypot(*wind.amplitude)) if isinstance(wind, Valley) else 0.0)


def track_times(a: Floats, b: Floats, departures: Floats, wind: ChangingWind, airspeed: float) -> Floats:
    """Return the time [s] along each straight track `a` → `b`, (k, 2) [m], begun at `departures` (k,) [s], (k,).

    Steps are doubled until the time has settled to `TOLERANCE`; the value kept is Richardson's.
    """
    time = np.zeros(len(a))
    going = np.flatnonzero(np.hypot(*(b - a).T) > 0)
    steps = STEPS[0]
    rough = _tracked(a[going], b[going], departures[going], wind, airspeed, steps)
    while len(going):
        steps *= 2
        fine = _tracked(a[going], b[going], departures[going], wind, airspeed, steps)
        time[going] = fine + (fine - rough) / 15
        open_ones = (np.abs(fine - rough) > TOLERANCE * fine) & (steps < STEPS[1])
        going, rough = going[open_ones], fine[open_ones]
    return time


def _tracked(a: Floats, b: Floats, departures: Floats, wind: ChangingWind, airspeed: float, steps: int) -> Floats:
    """Return the times of `track_times` by so many equal steps along each track."""
    d = b - a
    far = np.hypot(*d.T)
    tangents = d / far[:, None]

    def slowness(share: float, times: Floats) -> Floats:
        """Return d(time)/d(share) [s] at a share of the track."""
        points = a + share * d
        w = wind.velocities(points, times)
        refuse_strong(points, np.hypot(*w.T), airspeed)
        return far / ground_speeds(w, tangents, airspeed)

    times, h = departures.astype(np.float64), 1.0 / steps
    for step in range(steps):
        one = slowness(step * h, times)
        two = slowness((step + 0.5) * h, times + 0.5 * h * one)
        three = slowness((step + 0.5) * h, times + 0.5 * h * two)
        four = slowness((step + 1) * h, times + h * three)
        times = times + h / 6 * (one + 2 * two + 2 * three + four)
    return times - departures
