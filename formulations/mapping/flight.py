"""Flight: the Dubins tour a UAV flies along its reference path, and where it measures.

The reference path of a tour is the closed polyline of the moving costs (§Calculation of Moving Cost), from the depot
through its tasks and back. Waypoints are the tasks, the depot and points of the reference path in between; each gets
a heading from a few candidates about its tangent, chosen together by a closed dynamic programme over Dubins lengths
(`headings.choose_headings`), so that the flown tour is closed, keeps the minimum turning radius and passes over every
task. Sensing is discrete in time (§Problem Formulation): a measurement every `period` seconds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry import Polygon

from formulations.mapping import dubins
from formulations.mapping.headings import choose_headings
from instances import InputError
from instances.arrays import Floats, Ints
from instances.environment.wind import pair
from instances.extent import check_positions, positive

HEADINGS = 16
"""Candidate headings a waypoint: 16 add 0.3 % to a tour's Euclidean length at r_min = 50 m, more hardly help."""

LONGEST = 1e7
"""Longest flight [s] that is read: its track has a pose every fraction of a second."""

STRAY_RADII = 0.2
"""Waypoints inside a leg keep to the reference path within this many turning radii (Douglas & Peucker 1973)."""


@dataclass(frozen=True)
class Flight:
    """A closed Dubins tour at constant speed over ground or, with a clock or a wind, through the air.

    With a wind the segments are those of the air, in which each leg drifts (`planned.planned_flight`), headings are the
    air's, and lengths are ways through the air.

    starts : pose (x [m], y [m], heading [rad]) at the start of each leg, shape (w, 3).
    words : Dubins word of each leg (row of dubins.TURNS), shape (w,).
    segments : lengths of its three segments [m], shape (w, 3).
    radius : minimum turning radius r_min [m]; 0 for a polyline.
    speed : v [m/s], over ground; with a clock or a wind the airspeed.
    clock : times [s] at equal steps of the tour, from 0 at take-off to landing, linear between (`clock.clocked`).
    wind : the steady wind [m/s] legs drift in, or None.
    """

    starts: Floats
    words: Ints
    segments: Floats
    radius: float
    speed: float
    clock: Floats | None = None
    wind: tuple[float, float] | None = None

    @property
    def length(self) -> float:
        """Length of the tour [m], with a wind through the air."""
        return float(self.segments.sum())

    @property
    def duration(self) -> float:
        """Time of flight [s]."""
        return self.length / self.speed if self.clock is None else float(self.clock[-1])

    @property
    def fastest(self) -> float:
        """Greatest ground speed [m/s]."""
        if self.wind is not None:
            return self.speed + float(np.hypot(*self.wind))
        if self.clock is None or self.length == 0.0:
            return self.speed
        return self.length / (len(self.clock) - 1) / float(np.diff(self.clock).min())

    def travelled(self, times: ArrayLike) -> Floats:
        """Return how far [m] the UAV is along the tour at `times` [s], shape (k,)."""
        t = np.asarray(times, dtype=float)
        if self.clock is None:
            return t * self.speed
        return np.interp(t, self.clock, np.linspace(0.0, self.length, len(self.clock)))

    def poses(self, travelled: ArrayLike) -> Floats:
        """Return the poses (x, y, heading) after `travelled` metres of the tour, shape (k, 3).

        Distances beyond the tour's length are its end.
        """
        s = np.clip(np.asarray(travelled, dtype=float).reshape(-1), 0.0, self.length)
        ends = np.cumsum(self.segments.sum(axis=1))
        legs = np.minimum(np.searchsorted(ends, s, side="right"), len(ends) - 1)
        into = s - (ends[legs] - self.segments[legs].sum(axis=1))
        poses = np.empty((len(s), 3))
        dubins.poses_along(
            self.starts[legs], dubins.TURNS[self.words[legs]], self.segments[legs], into, self.radius, poses
        )
        if self.wind is not None:
            poses[:, :2] += into[:, None] * (np.array(self.wind) / self.speed)
        return poses

    def track(self, step: float) -> tuple[Floats, Floats]:
        """Return times [s], shape (k,), every `step` seconds and at landing, and the poses then, shape (k, 3).

        Headings are in [−π, π).
        """
        times = np.append(np.arange(0.0, self.duration, step), self.duration)
        poses = self.poses(self.travelled(times))
        poses[:, 2] = (poses[:, 2] + np.pi) % (2 * np.pi) - np.pi
        return times, poses

    def measurements(self, period: float) -> tuple[Floats, Floats]:
        """Return times [s], shape (k,), and positions [m], shape (k, 2), of a measurement every `period` seconds.

        The first is one period after take-off; a tour shorter than the period has none.
        """
        times = period * np.arange(1, int(self.duration / period + 1e-9) + 1, dtype=np.float64)
        return times, self.poses(self.travelled(times))[:, :2]

    def repeated(self, laps: int) -> Flight:
        """Return the tour flown `laps` times, one after the other."""
        starts, segments = (np.tile(array, (laps, 1)) for array in (self.starts, self.segments))
        clock = self.clock
        if clock is not None:
            clock = np.append(0.0, (clock[1:] + clock[-1] * np.arange(laps)[:, None]).reshape(-1))
        return replace(self, starts=starts, words=np.tile(self.words, laps), segments=segments, clock=clock)

    @classmethod
    def straight(cls, points: Floats, speed: float) -> Flight:
        """Return the flight along the polyline `points` (w + 1, 2) [m], which turns on the spot; none for (0, 2)."""
        steps = np.diff(points, axis=0)
        headings, lengths = np.arctan2(steps[:, 1], steps[:, 0]), np.hypot(*steps.T)
        starts = np.column_stack([points[:-1], headings])
        segments = np.column_stack([0.0 * lengths, lengths, 0.0 * lengths])
        return cls(starts, np.zeros(len(steps), dtype=np.int64), segments, 0.0, speed)

    def to_json(self) -> dict[str, Any]:
        """Return the flight as JSON values."""
        table: dict[str, Any] = {
            "starts": self.starts.tolist(),
            "words": self.words.tolist(),
            "segments": self.segments.tolist(),
            "radius": self.radius,
            "speed": self.speed,
        }
        table |= {} if self.clock is None else {"clock": self.clock.tolist()}
        return table if self.wind is None else {**table, "wind": list(self.wind)}

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Flight:
        """Read what `to_json` wrote; InputError where it is no flight."""
        flight = cls(
            np.array(data["starts"], dtype=float).reshape(-1, 3),
            np.array(data["words"], dtype=np.int64),
            np.array(data["segments"], dtype=float).reshape(-1, 3),
            positive(data["radius"], "radius [m]"),
            positive(data["speed"], "speed [m/s]"),
            np.array(data["clock"], dtype=float) if "clock" in data else None,
            pair(data["wind"], "wind [m/s]") if "wind" in data else None,
        )
        if not len(flight.starts) == len(flight.words) == len(flight.segments):
            raise InputError("starts, words and segments of a flight must be equally many")
        if not np.isin(flight.words, np.arange(len(dubins.TURNS))).all() or not (flight.segments >= 0).all():
            raise InputError("words of a flight must be numbers of Dubins words, and its segments not negative")
        check_positions(flight.starts, "starts")
        if flight.clock is not None:
            flight.check_clock()
        if not flight.duration <= LONGEST:
            raise InputError(f"a flight must take at most {LONGEST:g} s, got {flight.duration:g} s")
        return flight

    def check_clock(self) -> None:
        """Raise InputError where the clock does not run from 0."""
        times = self.clock
        if times is None or times.ndim != 1 or len(times) < 2 or times[0] != 0.0 or not (np.diff(times) >= 0).all():
            raise InputError("the clock of a flight must be times from 0 that do not fall")


def plan_flight(
    legs: list[Floats], *, speed: float = 100.0, radius: float = 50.0, within: Polygon | None = None
) -> Flight:
    """Return the Dubins tour along a closed reference path.

    legs : the reference path leg by leg, depot → task → … → depot, each a polyline [m] of shape (k, 2) that begins
        where the one before ended. An empty list is a UAV that stays home.
    speed : v [m/s]; radius : r_min [m].
    within : where turns are to stay; a tour that cannot is the shortest, and its flight check says so.
    """
    if not (speed > 0 and radius > 0):
        raise InputError(f"speed and turning radius must be positive, got {speed} m/s and {radius} m")
    if not legs:
        return Flight(np.empty((0, 3)), np.empty(0, dtype=np.int64), np.empty((0, 3)), radius, speed)
    waypoints, tangents = reference_waypoints(legs, STRAY_RADII * radius)
    offsets = np.arange(HEADINGS) * (2 * np.pi / HEADINGS)
    headings = tangents[:, None] + offsets[None, :]
    choice = choose_headings(waypoints, headings, radius, within)
    chosen = headings[np.arange(len(waypoints)), choice]
    starts = np.column_stack([waypoints, chosen])
    ends = np.roll(starts, -1, axis=0)
    flown = [dubins.dubins_path(a[0], a[1], a[2], b[0], b[1], b[2], radius) for a, b in zip(starts, ends, strict=True)]
    words = np.array([f[0] for f in flown], dtype=np.int64)
    return Flight(starts, words, np.array([f[1:] for f in flown]), radius, speed)


def reference_waypoints(legs: list[Floats], stray: float) -> tuple[Floats, Floats]:
    """Return waypoints [m] on the closed reference path, shape (w, 2), and their tangents [rad], shape (w,).

    Every leg's start (depot or task) is one; within a leg, as few points of the path as keep the straight lines
    between them within `stray` [m] of it. Coincident tasks are one waypoint. The tangent is along the chord between
    the neighbours.
    """
    points = [
        shapely.get_coordinates(shapely.simplify(shapely.linestrings(leg), stray))[:-1]
        for leg in legs
        if len(leg) > 1 and np.ptp(leg, axis=0).any()
    ]
    waypoints = np.concatenate(points) if points else np.asarray(legs[0][:1], dtype=float)
    chord = np.roll(waypoints, -1, axis=0) - np.roll(waypoints, 1, axis=0)
    return waypoints, np.arctan2(chord[:, 1], chord[:, 0])
