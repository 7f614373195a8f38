"""Heading states: which headings a node may be flown over with, or in which sectors they lie.

Dubins lengths jump by up to a full circle, so a grid of headings alone can price a tour with a loop that no continuous
plan needs. Besides a uniform grid a node may have the headings that short legs like: along the lines of sight to and
from its nearest nodes (a straight leg), and along the chords between two of them (the tangents of a smooth tour).
Depots are free, where a UAV takes off and lands in any direction it likes, or have the same headings as tasks, where
both must be in the same one ("closed").
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from instances.arrays import Floats, Ints
from instances.errors import InputError, shown

MOST_STATES = 10_000
"""More have a cost array of nearly a gigabyte."""
_SAME = 1e-9
"""Headings [rad] nearer than that are one."""


@dataclass(frozen=True, eq=False)
class HeadingStates:
    """Sectors [low, low + width] of headings at nodes, all (S,), node by node; a heading has width 0.

    nodes : the node of each. lows : [rad]. widths : [rad], from 0 to 2π.
    """

    nodes: Ints
    lows: Floats
    widths: Floats

    @cached_property
    def middles(self) -> Floats:
        """The heading in the middle of each [rad], (S,)."""
        return self.lows + 0.5 * self.widths

    def also(self, nodes: Ints, headings: Floats) -> HeadingStates:
        """Return these states and more `headings` (k,) [rad] at `nodes` (k,), those that are there already left out."""
        new = [k for k, (i, h) in enumerate(zip(nodes, headings, strict=True)) if not self._has(int(i), float(h))]
        order = np.argsort(together := np.concatenate([self.nodes, nodes[new]]), kind="stable")
        lows, widths = np.concatenate([self.lows, headings[new]]), np.concatenate([self.widths, np.zeros(len(new))])
        return HeadingStates(together[order], lows[order], widths[order])

    def _has(self, node: int, heading: float) -> bool:
        apart = (self.of(node) - heading + np.pi) % (2 * np.pi) - np.pi
        return bool((np.abs(apart) <= _SAME).any())

    def of(self, node: int) -> Floats:
        """Return the middle headings [rad] of a node."""
        return self.middles[self.nodes == node]


def headings(
    points: Floats,
    n_tasks: int,
    *,
    uniform: int = 16,
    sights: int = 0,
    tangents: int = 0,
    free_depots: bool = True,
    drift: tuple[float, float] = (0.0, 0.0),
) -> HeadingStates:
    """Return the heading states of tasks and depots.

    points : tasks, then depots [m], (N, 2).
    uniform : headings 2πa / uniform, a = 0, 1, …
    sights : nearest nodes whose lines of sight are headings, there and back.
    tangents : nearest nodes the chords between any two of which are headings, there and back.
    free_depots : whether depots have one state, any heading; else they have headings as tasks do.
    drift : a steady wind over the airspeed: headings are those of the air, by which sights and chords are flown along.
    """
    if uniform < 0 or sights < 0 or tangents < 0 or uniform + sights + (tangents > 1) == 0:
        raise InputError(f"a task needs a heading: uniform, sights and tangents are {uniform}, {sights} and {tangents}")
    grid = np.arange(uniform) * (2 * np.pi / max(uniform, 1))
    each: list[Floats] = []
    for node in range(len(points)):
        if node >= n_tasks and free_depots:
            each.append(np.zeros(1))
            continue
        away = points - points[node]
        near = np.argsort(np.hypot(*away.T), kind="stable")
        near = near[np.hypot(*away[near].T) > 0]
        found = np.concatenate(
            [grid, _along(away[near[:sights]], drift), _along(_chords(points[near[:tangents]]), drift)]
        )
        each.append(_distinct(found) if len(found) else np.zeros(1))
    widths = [
        np.full(len(lows), 2 * np.pi if node >= n_tasks and free_depots else 0.0) for node, lows in enumerate(each)
    ]
    return _states(each, widths)


def sectors(n_tasks: int, n_depots: int, count: int) -> HeadingStates:
    """Return `count` sectors of headings a task, centred on 2πa / count, and free depots: all headings there are."""
    lows = np.linspace(0.0, 2 * np.pi, count, endpoint=False, dtype=np.float64) - np.pi / count
    each = [lows] * n_tasks + [np.zeros(1)] * n_depots
    widths = [np.full(count, 2 * np.pi / count)] * n_tasks + [np.full(1, 2 * np.pi)] * n_depots
    return _states(each, widths)


def _states(lows: list[Floats], widths: list[Floats]) -> HeadingStates:
    """Return the states of nodes with these sectors."""
    nodes = np.repeat(np.arange(len(lows)), [len(each) for each in lows])
    if len(nodes) > MOST_STATES:
        raise InputError(f"there can be {MOST_STATES} headings of all nodes together, got {shown(len(nodes))}")
    return HeadingStates(nodes, np.concatenate(lows), np.concatenate(widths))


def _along(vectors: Floats, drift: tuple[float, float]) -> Floats:
    """Return the headings [rad] by which a UAV that drifts flies along vectors (k, 2), and back along them."""
    there = np.arctan2(vectors[:, 1], vectors[:, 0])
    both = np.concatenate([there, there + np.pi])
    return both - np.arcsin(drift[1] * np.cos(both) - drift[0] * np.sin(both))  # the wind triangle


def _chords(points: Floats) -> Floats:
    """Return the vectors between any two points that differ, (k, 2)."""
    i, j = np.triu_indices(len(points), 1)
    vectors = points[j] - points[i]
    return vectors[np.hypot(*vectors.T) > 0]


def _distinct(found: Floats) -> Floats:
    """Return headings [rad] in [0, 2π), rising, each once."""
    turned = np.sort(found % (2 * np.pi))
    kept = turned[np.concatenate([[True], np.diff(turned) > _SAME])]
    return kept[:-1] if len(kept) > 1 and kept[0] + 2 * np.pi - kept[-1] < _SAME else kept
