"""What path polish minimises: what stays unknown, and what it costs to fly further than a UAV may or beyond a border.

    F(P) = log J(X(P)) + ρ Σ_k max(0, (C_k(P) − b_k)/b_k)² + ρ Σ_q (depth_q/l)²

over the waypoints P between start and home of every UAV, X being where its path is sampled, C_k its cost, b_k its
budget, l the kernel's shorter length scale, and depth_q how far a waypoint lies outside of where waypoints may be, or a
place along a leg outside of where legs may.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry import Polygon

from formulations.average_variance import AverageVariance
from formulations.polish.sampling import Samples, count_of, times_of
from formulations.polish.straight_legs import Costed, StraightLegs
from instances.arrays import Floats, Ints

WATCHED = np.arange(1, 8) / 8
"""Where along a leg is looked whether it lies in the room; the paths that are returned are checked exactly."""
AT_END = np.ones(1)


@dataclass(frozen=True, eq=False)
class Objective:
    """F as a function of the waypoints of all UAVs, in length scales, flat.

    judged : J. legs : what legs cost. period : time between two samples of a UAV [s].
    paths : of each UAV the places from start to home, (w + 1, 2) [m]; the ends stay.
    budgets : b_k [s], (m,). weight : ρ.
    room, inner : where legs and where waypoints are to stay; None where bounds of the waypoints see to it.
    held : whether samples keep their shares of the legs they are on in `paths`, X = M P: smooth, and right for legs
    that hardly change; otherwise they are taken by the clock.
    start : when the paths are begun [s], by the clock of `judged`.
    """

    judged: AverageVariance
    legs: StraightLegs
    period: float
    paths: Sequence[Floats]
    budgets: Floats
    weight: float
    room: Polygon | None = None
    inner: Polygon | None = None
    held: bool = False
    start: float = 0.0

    @property
    def begin(self) -> Floats:
        """The waypoints of `paths` as unknowns."""
        inner = [path[1:-1] for path in self.paths]
        return np.asarray((np.concatenate(inner) / self._scales).ravel())

    def moved(self, unknowns: Floats) -> list[Floats]:
        """Return the paths through the waypoints that `unknowns` are."""
        points = np.split(unknowns.reshape(-1, 2) * self._scales, self._cuts)
        return [np.concatenate([p[:1], q, p[-1:]]) for p, q in zip(self.paths, points, strict=True)]

    def __call__(self, unknowns: Floats) -> tuple[float, Floats]:
        """Return F and its gradient."""
        paths = self.moved(unknowns)
        costed = [self.legs(path) for path in paths]
        value, slopes = self._unknown(paths, costed)
        for k, (path, legs) in enumerate(zip(paths, costed, strict=True)):
            over = legs.cost.sum() / self.budgets[k] - 1.0
            if over > 0:
                value += self.weight * over**2
                by_cost = 2.0 * self.weight * over / self.budgets[k]
                slopes[k][:-1] += by_cost * legs.cost_slopes[:, 0]
                slopes[k][1:] += by_cost * legs.cost_slopes[:, 1]
            if self.room is not None:
                value += self._beyond(self.room, WATCHED, path, slopes[k])
            if self.inner is not None:
                value += self._beyond(self.inner, AT_END, path[:-1], slopes[k][:-1])
        gradient = np.concatenate([slope[1:-1] for slope in slopes]) * self._scales
        return value, gradient.ravel()

    def _unknown(self, paths: list[Floats], costed: list[Costed]) -> tuple[float, list[Floats]]:
        """Return log J and its slopes by the places of each path."""
        if self.held:
            samples = [replace(first, path=path) for first, path in zip(self._first, paths, strict=True)]
            stretched = [np.zeros_like(legs.duration_slopes) for legs in costed]
        else:
            sampled = zip(paths, costed, self._first, strict=True)
            samples = [Samples.along(p, legs.duration, self.period, len(first.leg)) for p, legs, first in sampled]
            stretched = [legs.duration_slopes for legs in costed]
        unknown, slopes = self.judged(np.concatenate([each.places for each in samples]), self._times)
        parts = np.split(slopes / unknown, np.cumsum([len(first.leg) for first in self._first])[:-1])
        return math.log(unknown), [s.pulled(p, by) for s, p, by in zip(samples, parts, stretched, strict=True)]

    def _beyond(self, room: Polygon, shares: Floats, path: Floats, slopes: Floats) -> float:
        """Return what places at `shares` of the legs of `path` that lie outside `room` add to F, and add its slopes."""
        a, b = path[:-1], path[1:]
        places = (a[:, None] + shares[:, None] * (b - a)[:, None]).reshape(-1, 2)
        outside = np.flatnonzero(~shapely.intersects_xy(room, *places.T))
        if not len(outside):
            return 0.0
        nearest = shapely.get_coordinates(shapely.shortest_line(shapely.points(places[outside]), room))[1::2]
        beyond = (places[outside] - nearest) / self._least
        leg, share = outside // len(shares), shares[outside % len(shares), None]
        pull = 2.0 * self.weight * beyond / self._least
        np.add.at(slopes, leg, (1.0 - share) * pull)
        np.add.at(slopes, leg + 1, share * pull)
        return self.weight * float((beyond**2).sum())

    @property
    def _scales(self) -> Floats:
        return np.asarray(self.judged.kernel.length_scales)

    @property
    def _least(self) -> float:
        return min(self.judged.kernel.length_scales)

    @cached_property
    def _cuts(self) -> Ints:
        return np.asarray(np.cumsum([len(path) - 2 for path in self.paths])[:-1])

    @cached_property
    def _times(self) -> Floats:
        """When the samples are taken [s], whichever way is flown."""
        return self.start + times_of([len(first.leg) for first in self._first], self.period)

    @cached_property
    def _first(self) -> list[Samples]:
        """The samples of `paths`; as many as of paths that use up their budgets."""
        samples = []
        for path, budget in zip(self.paths, self.budgets, strict=True):
            legs = self.legs(path)
            longest = legs.duration.sum() * max(1.0, budget / legs.cost.sum())
            samples.append(Samples.along(path, legs.duration, self.period, count_of(longest, self.period)))
        return samples
