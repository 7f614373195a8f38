"""Flight check: what a flown tour keeps and what it breaks, measured on its track and not taken from the planner.

The track is sampled every few metres; turning radius and closure are judged by these samples, distances to tasks and
the reference path and the length inside no-fly zones by the polyline through them (shapely).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry import Polygon

from formulations.mapping.flight import Flight
from instances.arrays import Floats
from instances.environment.region import Region

STEP = 2.0
"""Distance between samples of the track [m]."""


@dataclass(frozen=True)
class FlightCheck:
    """What was measured on one flown tour, all in metres.

    length; reference_length of the path it follows; closure, how far the end lies from the start; least_radius of
    turn (inf for a UAV that stays home); task_distance, how near it comes to the task it misses most; deviation from
    the reference path, at most; length inside no-fly zones.
    """

    length: float
    reference_length: float
    closure: float
    least_radius: float
    task_distance: float
    deviation: float
    in_no_fly: float


def check_flight(
    flight: Flight, legs: Sequence[Floats], tasks: ArrayLike, no_fly: Sequence[Polygon] = (), step: float = STEP
) -> FlightCheck:
    """Measure `flight` against its reference path `legs`, the tasks (k, 2) [m] it is to pass, and the zones."""
    if flight.length == 0.0:
        return FlightCheck(0.0, 0.0, 0.0, np.inf, 0.0, 0.0, 0.0)
    s = np.append(np.arange(0.0, flight.length, step), flight.length)
    poses = flight.poses(s)
    track = shapely.linestrings(poses[:, :2])
    reference = shapely.linestrings(np.concatenate(legs))
    turn = np.abs((np.diff(poses[:, 2]) + np.pi) % (2 * np.pi) - np.pi)
    moved = np.diff(s)
    curved = turn > 1e-9
    radius = float((moved[curved] / turn[curved]).min(initial=np.inf))
    points = shapely.points(np.asarray(tasks, dtype=float).reshape(-1, 2))
    inside = shapely.length(shapely.intersection(track, shapely.union_all(list(no_fly)))) if no_fly else 0.0
    return FlightCheck(
        length=float(moved.sum()),
        reference_length=float(shapely.length(reference)),
        closure=float(np.hypot(*(poses[-1, :2] - poses[0, :2]))),
        least_radius=radius,
        task_distance=float(shapely.distance(points, track).max(initial=0.0)),
        deviation=float(shapely.distance(shapely.points(poses[:, :2]), reference).max()),
        in_no_fly=float(inside),
    )


def length_outside(flights: Sequence[Flight], region: Region, step: float = 10.0) -> float:
    """Return the length [m] flown outside `region` by all `flights`, on tracks of a point every `step` metres."""
    tracks = [flight.poses(np.arange(0.0, flight.length, step))[:, :2] for flight in flights if flight.length > 0]
    return float(sum(shapely.length(shapely.difference(shapely.linestrings(t), region.polygon)) for t in tracks))
