"""The clock of a flight at constant airspeed: when it is where along its track, by the wind triangle.

The track is the Dubins tour over ground; along it the ground speed is w∥ + √(va² − w⊥²) (`instances.wind_triangle`).
The least radius of turn holds over ground: through the air, downwind turns are tighter and upwind ones wider.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from formulations.mapping.flight import Flight
from instances.arrays import Floats
from instances.environment.wind import WindField
from instances.wind_triangle import ground_speeds, refuse_strong

STEP = 10.0
"""Greatest distance [m] between the knots of the clock."""


def clocked(flight: Flight, wind: WindField) -> Flight:
    """Return `flight` at the constant airspeed ``flight.speed`` in `wind`.

    Raises InputError that names the place on the track where the wind is as strong.
    """
    pieces = max(1, math.ceil(flight.length / STEP))
    poses = flight.poses(np.linspace(0.0, flight.length, 2 * pieces + 1)) if flight.length else np.zeros((1, 3))
    w: Floats = wind(poses[:, :2])
    refuse_strong(poses[:, :2], np.hypot(*w.T), flight.speed)
    tangents = np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    slowness = 1.0 / ground_speeds(w, tangents, flight.speed)
    steps = (slowness[:-1:2] + 4.0 * slowness[1::2] + slowness[2::2]) * flight.length / (6.0 * pieces)  # Simpson
    return replace(flight, clock=np.concatenate([[0.0], np.cumsum(steps)]))
