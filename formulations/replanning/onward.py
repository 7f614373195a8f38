"""The way on from the pose a UAV has, along new legs, to its home; and the flight that it completes.

A Dubins flight goes on as one, a flight of turning radius 0 as the polyline that it is.
What was flown stays as it was flown: a flight that is changed in the air is its flown part and the way on together.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import Polygon

from formulations.mapping import dubins
from formulations.mapping.clock import STEP, clocked
from formulations.mapping.flight import HEADINGS, STRAY_RADII, Flight
from formulations.mapping.headings import choose_headings
from instances.arrays import Floats
from instances.environment.wind import WindField


def fly_on(
    flown: Flight, legs: list[Floats], within: Polygon | None = None, wind: WindField | None = None
) -> tuple[Flight, Flight]:
    """Return `flown` completed by the way on along `legs`, and the way on alone.

    legs : polylines [m], each beginning where the one before ended, the first where `flown` ends; none is an end there.
    within : where turns are to stay if they can. wind : that of the clock, of flights which have one.
    """
    x, y, heading = flown.poses(flown.length)[0]
    stray = STRAY_RADII * flown.radius
    points = [shapely.get_coordinates(shapely.simplify(shapely.linestrings(leg), stray)) for leg in legs]
    line = np.concatenate([[[x, y]], *points])
    waypoints = line[np.append(True, np.hypot(*np.diff(line, axis=0).T) > 1e-6)]
    if len(waypoints) < 2:
        return flown, _over(flown)
    turned = flown.radius > 0
    on = _turning(flown, waypoints, heading, within) if turned else Flight.straight(waypoints, flown.speed)
    on = on if wind is None else clocked(on, wind)
    return joined(flown, on), on


def _turning(flown: Flight, waypoints: Floats, heading: float, within: Polygon | None) -> Flight:
    """Return the Dubins flight over `waypoints` (w + 1, 2) [m] from `heading` [rad], by the UAV that has `flown`."""
    chord = np.gradient(waypoints, axis=0)
    first = np.arctan2(chord[:, 1], chord[:, 0])
    first[0] = heading
    headings = first[:, None] + np.arange(HEADINGS) * (2 * np.pi / HEADINGS)
    choice = choose_headings(waypoints, headings, flown.radius, within, closed=False)
    poses = np.column_stack([waypoints, headings[np.arange(len(waypoints)), choice]])
    paths = [dubins.dubins_path(*a, *b, flown.radius) for a, b in pairwise(poses.tolist())]
    words = np.array([path[0] for path in paths], dtype=np.int64)
    return replace(flown, starts=poses[:-1], words=words, segments=np.array([path[1:] for path in paths]), clock=None)


def joined(flown: Flight, on: Flight) -> Flight:
    """Return the flight of `flown` and then `on`."""
    starts, words, segments = (
        np.concatenate([getattr(flown, name), getattr(on, name)]) for name in ("starts", "words", "segments")
    )
    whole = replace(flown, starts=starts, words=words, segments=segments, clock=None)
    if flown.clock is None or on.clock is None:
        return whole
    s = np.linspace(0.0, whole.length, max(1, math.ceil(whole.length / STEP)) + 1)
    before, after = (np.linspace(0.0, part.length, len(part.clock)) for part in (flown, on) if part.clock is not None)
    late = flown.duration + np.interp(s - flown.length, after, on.clock)
    clock = np.where(s <= flown.length, np.interp(s, before, flown.clock), late)
    return replace(whole, clock=clock)


def flown_until(flight: Flight, time: float) -> Flight:
    """Return the part of `flight` that is flown by `time` [s] after take-off, which ends in the air."""
    if time >= flight.duration:
        return flight
    travelled = float(flight.travelled([time])[0])
    ends = np.cumsum(flight.segments.sum(axis=1))
    last = min(int(np.searchsorted(ends, travelled, side="right")), len(ends) - 1)
    segments = flight.segments[: last + 1].copy()
    begins = np.cumsum(segments[last]) - segments[last]
    into = travelled - (ends[last] - segments[last].sum())
    segments[last] = np.clip(into - begins, 0.0, segments[last])
    starts, words = flight.starts[: last + 1], flight.words[: last + 1]
    flown = replace(flight, starts=starts, words=words, segments=segments, clock=None)
    if flight.clock is None:
        return flown
    s = np.linspace(0.0, flown.length, max(1, math.ceil(flown.length / STEP)) + 1)
    clock = np.interp(s, np.linspace(0.0, flight.length, len(flight.clock)), flight.clock)
    clock[-1] = time
    return replace(flown, clock=clock)


def rest_after(flight: Flight, flown: Flight) -> Flight:
    """Return what is left of `flight` where its part `flown` (`flown_until`) is flown."""
    last = len(flown.segments) - 1
    if flown.length >= flight.length:
        return _over(flight)
    x, y, heading = flown.poses(flown.length)[0]
    starts, segments = flight.starts[last:].copy(), flight.segments[last:].copy()
    starts[0] = x, y, heading
    segments[0] = np.maximum(segments[0] - flown.segments[last], 0.0)
    return replace(flight, starts=starts, words=flight.words[last:], segments=segments, clock=None)


def _over(flight: Flight) -> Flight:
    """Return a flight of no legs by the UAV of `flight`."""
    return replace(flight, starts=flight.starts[:0], words=flight.words[:0], segments=flight.segments[:0], clock=None)
