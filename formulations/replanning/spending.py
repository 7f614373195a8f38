"""What a track costs, in the cost that the mission's endurance is counted in (`instances.moving_cost`).

Integrated along the track as flown, turns included: energy (1 − w∥/v0)/v0 ds, time ds/g with the ground speed g of the
wind triangle. What is counted so is a little more than the cost of the legs the tour was planned by.
"""

from __future__ import annotations

import math

import numpy as np

from formulations.mapping.flight import Flight
from instances.environment.wind import Uniform
from instances.moving_cost import CostKind, CostMeasure
from instances.wind_triangle import ground_speeds, refuse_strong

STEP = 10.0
"""Length of the pieces [m] of Simpson's rule."""


def track_cost(flight: Flight, measure: CostMeasure) -> float:
    """Return the cost [s] of flying the track of `flight`; InputError, for times, where the wind is as strong."""
    if flight.radius == 0.0 and len(flight.starts):
        line = np.concatenate([flight.starts[:, :2], flight.poses(flight.length)[:, :2]])
        return float(measure.segments(line[:-1], line[1:]).sum())
    if flight.length == 0.0 or measure.wind == Uniform((0.0, 0.0)):
        return flight.length / measure.speed
    pieces = math.ceil(flight.length / STEP)
    poses = flight.poses(np.linspace(0.0, flight.length, 2 * pieces + 1))
    w = measure.wind(poses[:, :2])
    tangents = np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    if measure.kind is CostKind.TIME:
        refuse_strong(poses[:, :2], np.hypot(*w.T), measure.speed)
        rates = 1.0 / ground_speeds(w, tangents, measure.speed)
    else:
        rates = (1.0 - (w * tangents).sum(axis=1) / measure.speed) / measure.speed
    total = rates[0] + rates[-1] + 4.0 * rates[1::2].sum() + 2.0 * rates[2:-1:2].sum()
    return float(total * flight.length / (6.0 * pieces))
