"""Flight check: what a flown tour keeps and what it breaks, measured on its track and not taken from the planner.

The track is sampled every few metres; turning radius and closure are judged by these samples, distances to tasks and
the reference path, borders and no-fly zones by the polyline through them (shapely).
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

RESOLUTION = 0.02
"""How far a track may lie beside the polyline through its samples [m]: STEP²/8r is 1 cm at r = 50 m."""


@dataclass(frozen=True)
class Margin:
    """How near a track comes to where must not be flown: `distance` [m], negative beyond it, and the `place` [m]."""

    distance: float
    place: tuple[float, float]


@dataclass(frozen=True)
class FlightCheck:
    """What was measured on one flown tour, all in metres.

    length; reference_length of the path it follows; closure, how far the end lies from the start; least_radius of
    turn (inf for a UAV that stays home); task_distance, how near it comes to the task it misses most; deviation from
    the reference path, at most; length inside no-fly zones; length outside the region; margin, the least distance from
    the region's border and the zones, negative beyond them.
    """

    length: float
    reference_length: float
    closure: float
    least_radius: float
    task_distance: float
    deviation: float
    in_no_fly: float
    outside: float
    margin: float


def check_flight(
    flight: Flight,
    legs: Sequence[Floats],
    tasks: ArrayLike,
    region: Region,
    no_fly: Sequence[Polygon] = (),
    step: float = STEP,
) -> FlightCheck:
    """Measure `flight` against its reference path `legs`, the tasks (k, 2) [m] it is to pass, region and zones."""
    if flight.length == 0.0:
        return FlightCheck(0.0, 0.0, 0.0, np.inf, 0.0, 0.0, 0.0, 0.0, 0.0)
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
        outside=float(shapely.length(shapely.difference(track, region.polygon))),
        margin=margin(flight, region, no_fly, step).distance,
    )


def margin(flight: Flight, region: Region, no_fly: Sequence[Polygon] = (), step: float = STEP) -> Margin:
    """Return how near `flight` (not of length 0) comes to the border of `region` and to `no_fly`, or how far beyond."""
    free = region.polygon.difference(shapely.union_all(list(no_fly))) if no_fly else region.polygon
    s = np.append(np.arange(0.0, flight.length, step), flight.length)
    track = shapely.linestrings(flight.poses(s)[:, :2])
    beyond = shapely.get_coordinates(shapely.difference(track, free))
    if len(beyond):
        depth = np.asarray(shapely.distance(shapely.points(beyond), free))
        deepest = int(np.argmax(depth))
        return Margin(-float(depth[deepest]), (float(beyond[deepest, 0]), float(beyond[deepest, 1])))
    between = shapely.shortest_line(track, shapely.boundary(free))
    x, y = shapely.get_coordinates(between)[0]
    return Margin(float(shapely.length(between)), (float(x), float(y)))


def length_outside(flights: Sequence[Flight], region: Region, step: float = 10.0) -> float:
    """Return the length [m] flown outside `region` by all `flights`, on tracks of a point every `step` metres."""
    tracks = [flight.poses(np.arange(0.0, flight.length, step))[:, :2] for flight in flights if flight.length > 0]
    return float(sum(shapely.length(shapely.difference(shapely.linestrings(t), region.polygon)) for t in tracks))
