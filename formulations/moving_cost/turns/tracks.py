"""Where legs between headings lead over ground, and which of them stay in a polygon.

A leg is flown by the word and segments of `mapping.dubins` or, in a steady wind, of `wind`: then it drifts with the
air. Tracks are judged by polylines. The arc between two points of a turn is never farther from its chord than the
sagitta r(1 − cos(δ/2)), δ the angle between them, and drifting changes nothing of that; so coarse polylines decide for
all legs but those within a sagitta of the border, which are drawn again, finely.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from formulations.mapping import dubins
from formulations.moving_cost.turns.headings import HeadingStates
from formulations.moving_cost.turns.refinement import Candidates, LegCosts
from formulations.moving_cost.turns.travel import Turns
from formulations.moving_cost.turns.wind import wind_path
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit

COARSE, FINE = math.radians(10.0), math.radians(2.0)
"""Angles [rad] between points of a turn: sagittas of 3.8e-3 and 1.5e-4 turning radii."""
_CHUNK = 20_000
_WIDE = 4.0
"""Radii that a Dubins path keeps to about the line between its ends: its circles have centres within 3 of an end."""


@njit(cache=True)
def _flown(starts: Floats, ends: Floats, radius: float, wx: float, wy: float, words: Ints, segments: Floats) -> None:
    """Write words and segments [m of air] of the legs between poses (k, 3); wx, wy : wind over airspeed."""
    for k in range(len(starts)):
        x0, y0, h0 = starts[k]
        x1, y1, h1 = ends[k]
        if wx == 0.0 and wy == 0.0:
            word, a, b, c = dubins.dubins_path(x0, y0, h0, x1, y1, h1, radius)
        else:
            word, a, b, c = wind_path(x1 - x0, y1 - y0, h0, h1, radius, wx, wy)
        words[k], segments[k, 0], segments[k, 1], segments[k, 2] = word, a, b, c


def flown_legs(starts: Floats, ends: Floats, turns: Turns) -> tuple[Ints, Floats]:
    """Return words (k,) and segments (k, 3) [m through the air] of the quickest legs between poses (k, 3)."""
    words, segments = np.empty(len(starts), dtype=np.int64), np.empty((len(starts), 3))
    _flown(np.ascontiguousarray(starts), np.ascontiguousarray(ends), turns.radius, *turns.drift, words, segments)
    return words, segments


def tracks(starts: Floats, words: Ints, segments: Floats, turns: Turns, angle: float) -> NDArray[Any]:
    """Return the tracks over ground of legs as polylines, a point for every `angle` [rad] of a turn at least."""
    curved = dubins.TURNS[words] != 0
    pieces = np.where(curved, np.ceil(segments / (turns.radius * angle)), segments > 0).astype(np.int64)
    begins = np.cumsum(segments, axis=1) - segments
    of_piece = np.repeat(np.arange(pieces.size), pieces.ravel())
    number = np.arange(len(of_piece)) - np.repeat(np.cumsum(pieces.ravel()) - pieces.ravel(), pieces.ravel())
    share = (number + 1) / pieces.ravel()[of_piece]
    legs = np.concatenate([np.arange(len(starts)), of_piece // 3])
    ends = begins.ravel()[of_piece] + share * segments.ravel()[of_piece]
    travelled = np.concatenate([np.zeros(len(starts)), ends])
    order = np.argsort(legs, kind="stable")
    legs, travelled = legs[order], travelled[order]
    poses = np.empty((len(legs), 3))
    dubins.poses_along(starts[legs], dubins.TURNS[words[legs]], segments[legs], travelled, turns.radius, poses)
    ground = poses[:, :2] + travelled[:, None] * np.array(turns.drift)
    alone = np.bincount(legs, minlength=len(starts))[legs] < 2  # a leg without length is drawn as its point, twice
    repeats = np.where(alone, 2, 1)
    return np.asarray(shapely.linestrings(np.repeat(ground, repeats, axis=0), indices=np.repeat(legs, repeats)))


def stay_inside(starts: Floats, ends: Floats, turns: Turns, room: Polygon) -> Bools:
    """Return which of the quickest legs between poses (k, 3) stay in `room`, (k,)."""
    sagitta = turns.radius * (1 - math.cos(COARSE / 2))
    surely, maybe = room.buffer(-sagitta), room.buffer(sagitta)
    for polygon in (surely, maybe, room):
        shapely.prepare(polygon)
    stays = np.zeros(len(starts), dtype=bool)
    for low in range(0, len(starts), _CHUNK):
        here = np.arange(low, min(low + _CHUNK, len(starts)))
        words, segments = flown_legs(starts[here], ends[here], turns)
        coarse = tracks(starts[here], words, segments, turns, COARSE)
        stays[here] = shapely.covers(surely, coarse)
        open_ones = np.flatnonzero(~stays[here])
        open_ones = open_ones[shapely.covers(maybe, coarse[open_ones])]
        if len(open_ones):
            fine = tracks(starts[here][open_ones], words[open_ones], segments[open_ones], turns, FINE)
            stays[here[open_ones]] = shapely.covers(room, fine)
    return stays


def kept_inside(lengths: Floats, points: Floats, states: HeadingStates, turns: Turns, room: Polygon) -> Floats:
    """Return `lengths` (S, S), +inf where a leg would leave `room`; states have one heading each, none is free."""
    first, second = np.nonzero(states.nodes[:, None] != states.nodes[None, :])
    if turns.calm:  # far from borders no leg needs to be drawn
        i, j = np.indices((len(points), len(points))).reshape(2, -1)
        lines = shapely.linestrings(np.stack([points[i], points[j]], axis=1))
        inner = room.buffer(-_WIDE * turns.radius)
        shapely.prepare(inner)
        far = shapely.covers(inner, lines).reshape(len(points), -1)
        near = ~far[states.nodes[first], states.nodes[second]]
        first, second = first[near], second[near]
    poses = np.column_stack([points[states.nodes], states.lows])
    kept = lengths.copy()
    leaves = ~stay_inside(poses[first], poses[second], turns, room)
    kept[first[leaves], second[leaves]] = np.inf
    return kept


def legs_inside(stops: Floats, turns: Turns, room: Polygon) -> LegCosts:
    """Return what legs between `stops` [m], (w + 1, 2), cost [s] from each heading to each; +inf where one leaves."""

    def legs(s: int, here: Candidates, there: Candidates) -> Floats:
        assert here is not None
        assert there is not None
        a, b = np.indices((len(here), len(there))).reshape(2, -1)
        starts, ends = (
            np.column_stack([np.broadcast_to(stops[k], (a.size, 2)), h]) for k, h in ((s, here[a]), (s + 1, there[b]))
        )
        times = flown_legs(starts, ends, turns)[1].sum(axis=1) / turns.speed
        times[~stay_inside(starts, ends, turns, room)] = np.inf
        return times.reshape(len(here), -1)

    return legs
