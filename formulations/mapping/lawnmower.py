"""Lawnmower tours: what a person would fly without a planner, the baseline of the mission.

Parallel lanes of equal spacing, flown to and fro (boustrophedon), clipped to the region. Several UAVs share one such
track: it is cut into as many stretches, and each UAV flies out to the start of its stretch, along it and back home.
Cuts and who flies which stretch are chosen so that the longest closed tour is about least. Of the fewest lanes that
make tours of a given length, `best_lawnmower` takes the direction and the margin that promise most.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from formulations.mapping.flight import Flight, plan_flight
from instances.arrays import Floats, Ints
from instances.environment.region import Region

ROUNDS = 40
"""Rounds of balancing the cuts."""
MOST_LANES = 60
INSETS = (0.5, 0.3)
"""Margins at the ends of lanes that are tried, in spacings of the lanes."""


def best_lawnmower(
    region: Region,
    depots: Floats,
    length: float,
    worth: Callable[[list[Flight]], Any],
    *,
    speed: float,
    radius: float,
) -> tuple[int, list[Flight]]:
    """Return the number of lanes and the flights, one a depot, of the lawnmower of least `worth`.

    For lanes west–east and south–north and each margin of INSETS: the fewest lanes whose flights are `length` [m] long
    together (or MOST_LANES − 1). depots (m, 2) [m]; worth : of any kind that compares, such as the sd that a survey by
    these flights promises; speed v [m/s]; radius r_min [m].
    """
    tried = [_fewest_lanes(region, depots, length, along, inset, speed, radius) for along in (0, 1) for inset in INSETS]
    return min(tried, key=lambda lawnmower: worth(lawnmower[1]))


def _fewest_lanes(
    region: Region, depots: Floats, length: float, along: int, inset: float, speed: float, radius: float
) -> tuple[int, list[Flight]]:
    flights: list[Flight] = []
    for count in range(len(depots), max(MOST_LANES, len(depots) + 1)):
        tours = lawnmower_tours(region, depots, count, along, inset)
        flights = [_flown(tour, speed, radius) for tour in tours]
        if sum(flight.length for flight in flights) >= length:
            break
    return count, flights


def _flown(tour: Floats, speed: float, radius: float) -> Flight:
    """Return the flight over the corners of a closed tour."""
    moved = np.append(True, np.hypot(*np.diff(tour, axis=0).T) > 0)
    corners = tour[moved]
    return plan_flight([corners[k : k + 2] for k in range(len(corners) - 1)], speed=speed, radius=radius)


def lanes(region: Region, count: int, along: int, inset: float = 0.5) -> Floats:
    """Return the track over `count` lanes as waypoints (k, 2) [m]; `along` is 0 for lanes west–east, 1 south–north.

    The outer lanes lie half a spacing inside the region's bounding box, the ends of lanes `inset` spacings inside the
    region.
    """
    low, high = np.array(region.bounds[:2]), np.array(region.bounds[2:])
    across = 1 - along
    spacing = (high[across] - low[across]) / count
    track: list[Floats] = []
    for number in range(count):
        at = low[across] + (number + 0.5) * spacing
        ends = np.empty((2, 2))
        ends[:, along] = low[along], high[along]
        ends[:, across] = at
        cut = shapely.intersection(region.polygon, shapely.LineString(ends))
        points = np.array([c for part in shapely.get_parts(cut) for c in shapely.get_coordinates(part)])
        if len(points):
            stop = _shortened(points[np.argsort(points[:, along])][[0, -1]], along, inset * spacing)
            track.append(stop if number % 2 == 0 else stop[::-1])
    return np.concatenate(track)


def _shortened(ends: Floats, along: int, margin: float) -> Floats:
    room = 0.5 * (ends[1, along] - ends[0, along])
    inner = ends.copy()
    inner[0, along] += min(margin, 0.9 * room)
    inner[1, along] -= min(margin, 0.9 * room)
    return inner


def lawnmower_tours(region: Region, depots: ArrayLike, count: int, along: int, inset: float = 0.5) -> list[Floats]:
    """Return each UAV's closed tour over its share of `count` lanes, waypoints (k, 2) [m] from depot to depot."""
    homes = np.asarray(depots, dtype=float).reshape(-1, 2)
    track = lanes(region, count, along, inset)
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(track, axis=0).T))])
    m = len(homes)
    share = np.full(m, travelled[-1] / m)
    best: tuple[float, list[Floats]] = (np.inf, [])
    for _ in range(ROUNDS):
        cuts = np.concatenate([[0.0], np.cumsum(share)])
        stretches = [_stretch(track, travelled, a, b) for a, b in itertools.pairwise(cuts)]
        tours, flies = _assigned(stretches, homes)
        lengths = np.array([length_of(tour) for tour in tours])
        if lengths.max() < best[0]:
            best = float(lengths.max()), tours
        # who is longer than the mean gives some of the stretch away
        order = np.argsort(flies)
        share = np.maximum(share - 0.5 * (lengths[order] - lengths.mean()), 1.0)
        share *= travelled[-1] / share.sum()
    return best[1]


def length_of(tour: Floats) -> float:
    """Return the length [m] of a polyline (k, 2)."""
    return float(np.hypot(*np.diff(tour, axis=0).T).sum())


def _stretch(track: Floats, travelled: Floats, a: float, b: float) -> Floats:
    """Return the part of the track from `a` to `b` metres, shape (k, 2)."""
    inner = track[(travelled > a) & (travelled < b)]
    ends = np.array([[np.interp(s, travelled, track[:, axis]) for axis in (0, 1)] for s in (a, b)])
    return np.concatenate([ends[:1], inner, ends[1:]])


def _assigned(stretches: list[Floats], homes: Floats) -> tuple[list[Floats], Ints]:
    """Return closed tours, one a home, each over one stretch, of least total length, and which stretch each flies."""
    reach = np.array([[np.hypot(*(s[0] - h)) + np.hypot(*(s[-1] - h)) for s in stretches] for h in homes])
    _, which = linear_sum_assignment(reach)
    tours = [np.concatenate([h[None], stretches[k], h[None]]) for h, k in zip(homes, which, strict=True)]
    return tours, which
