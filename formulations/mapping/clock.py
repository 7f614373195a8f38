"""The clock of a flight at constant airspeed: when it is where along its track, by the wind triangle.

The track is the Dubins tour over ground; along it the ground speed is w∥ + √(va² − w⊥²) (`instances.wind_triangle`).
The least radius of turn holds over ground: through the air, downwind turns are tighter and upwind ones wider.

In a wind that changes, dt/ds = 1/g(s, t): the slowness is taken at the times of passing that the clock said before, and
integrated again until the clock stays (Picard's iteration).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from formulations.mapping.flight import Flight
from instances.arrays import Floats
from instances.environment.wind import WindField
from instances.environment.wind_changing import ChangingWind
from instances.wind_triangle import ground_speeds, refuse_strong

STEP = 10.0
"""Greatest distance [m] between the knots of the clock."""
ROUNDS = 50
"""Of Picard's iteration, at most."""
SETTLED = 1e-6
"""Time [s] by which a round may still change the clock."""


def clocked(flight: Flight, wind: WindField) -> Flight:
    """Return `flight` at the constant airspeed ``flight.speed`` in `wind`.

    Raises InputError that names the place on the track where the wind is as strong.
    """
    pieces = max(1, math.ceil(flight.length / STEP))
    poses = flight.poses(np.linspace(0.0, flight.length, 2 * pieces + 1)) if flight.length else np.zeros((1, 3))
    tangents = np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])

    def passed(w: Floats) -> Floats:
        """Return the clock in the winds `w` (2·pieces + 1, 2) [m/s] along the track."""
        refuse_strong(poses[:, :2], np.hypot(*w.T), flight.speed)
        slowness = 1.0 / ground_speeds(w, tangents, flight.speed)
        steps = (slowness[:-1:2] + 4.0 * slowness[1::2] + slowness[2::2]) * flight.length / (6.0 * pieces)  # Simpson
        return np.concatenate([[0.0], np.cumsum(steps)])

    clock = passed(wind(poses[:, :2]))
    if not isinstance(wind, ChangingWind):
        return replace(flight, clock=clock)
    for _ in range(ROUNDS):
        before = clock
        times = np.interp(0.5 * np.arange(len(poses)), np.arange(len(before)), before)
        clock = passed(wind.velocities(poses[:, :2], times))
        if np.abs(clock - before).max() <= SETTLED:
            break
    return replace(flight, clock=clock)
