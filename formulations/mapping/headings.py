"""Headings at the waypoints of a closed tour: of least Dubins length, and such that no turn leaves a polygon.

The closed programme knows lengths only. Where a leg it chose leaves the polygon, every pair of headings by which that
leg would leave is forbidden and the programme is run again; a tour that stays inside is what it was without one.
"""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon

from formulations.mapping import dubins
from instances.arrays import Bools, Floats, Ints

PIECES = 200
"""Pieces a segment of a leg is drawn with: the arc between two points of a full turn bulges by 1.2e-4 radii."""


def choose_headings(
    waypoints: Floats, headings: Floats, radius: float, within: Polygon | None = None, *, closed: bool = True
) -> Ints:
    """Return which of the candidate `headings` (w, H) [rad] each waypoint (w, 2) [m] is flown with, shape (w,).

    within : where the tour is to stay; where no choice stays inside, the shortest tour whatever it leaves.
    closed : whether the tour returns to its first waypoint; else that is left by its first candidate heading.
    """
    cost = dubins.heading_costs(waypoints, headings, radius)
    if not closed:
        cost[0, 1:], cost[-1] = np.inf, 0.0
    length, shortest = dubins.closed_programme(cost)
    if within is None:
        return np.asarray(shortest)
    choice, legs = shortest, np.arange(len(waypoints))
    pairs = np.indices(cost.shape[1:]).reshape(2, -1)
    judged = np.zeros(len(waypoints), dtype=bool)
    judged[-1] = not closed
    while np.isfinite(length):
        leaves = ~_inside(*_ends(waypoints, headings, legs, choice, np.roll(choice, -1)), radius, within) & ~judged
        if not leaves.any():
            return np.asarray(choice)
        for k in np.flatnonzero(leaves):
            stays = _inside(*_ends(waypoints, headings, np.full(pairs.shape[1], k), *pairs), radius, within)
            cost[k][~stays.reshape(cost.shape[1:])] = np.inf
        judged |= leaves
        length, choice = dubins.closed_programme(cost)
    return np.asarray(shortest)


def _ends(waypoints: Floats, headings: Floats, legs: Ints, first: Ints, last: Ints) -> tuple[Floats, Floats]:
    """Return poses (p, 3) at start and end of `legs` (p,) by the candidates `first` and `last` (p,) at their ends."""
    to = (legs + 1) % len(waypoints)
    starts = np.column_stack([waypoints[legs], headings[legs, first]])
    return starts, np.column_stack([waypoints[to], headings[to, last]])


def _inside(starts: Floats, ends: Floats, radius: float, within: Polygon) -> Bools:
    """Return which of the Dubins paths between poses (p, 3) stay in `within`, shape (p,)."""
    pairs = np.concatenate([starts, ends], axis=1).tolist()
    paths = np.array([dubins.dubins_path(x0, y0, h0, x1, y1, h1, radius) for x0, y0, h0, x1, y1, h1 in pairs])
    turns, segments = dubins.TURNS[paths[:, 0].astype(int)], paths[:, 1:]
    begins = np.cumsum(segments, axis=1) - segments
    travelled = (begins[:, :, None] + segments[:, :, None] * np.linspace(0.0, 1.0, PIECES + 1)).reshape(len(paths), -1)
    of_path = np.repeat(np.arange(len(paths)), travelled.shape[1])
    poses = np.empty((travelled.size, 3))
    dubins.poses_along(starts[of_path], turns[of_path], segments[of_path], travelled.ravel(), radius, poses)
    lines = shapely.linestrings(poses[:, :2].reshape(len(paths), -1, 2))
    return np.asarray(shapely.covers(within, lines), dtype=bool)
