"""Legs: what each UAV pays for each leg, its own matrix, which legs it may still use, and how long it can fly.

A leg that is forbidden (one its UAV cannot fly, too far under the cap on a tour, fixed away by its reduced cost, or
branched away) costs infinity. Every UAV has its own matrix and limit, so that different aircraft need no other code.

Where costs change with time the matrices hold the least of each leg over all departures (out of the depot: what it
takes at 0), and `courses` say what it takes by the clock.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from formulations.routing.clocks import clocks_of
from formulations.routing.columns.courses import Courses, by_clock
from instances import Instance
from instances.arrays import Bools, Floats, Ints
from instances.routes import ENDURANCE_ROUNDING
from instances.walks import shortest_walks


class UavLegs(NamedTuple):
    """Costs [s] of one UAV: `out` (n,) depot to task, `between` (n, n), `home` (n,) task to depot."""

    out: Floats
    between: Floats
    home: Floats


@dataclass(frozen=True)
class Legs:
    """Costs [s] of every UAV: `out` (m, n) depot to task, `between` (m, n, n), `home` (m, n) task to depot.

    longest : the cost [s] that no tour of the UAV may pass whatever the cap, (m,), +inf where its endurance has no end.
    courses : of each UAV where costs change with time, else none.
    """

    out: Floats
    between: Floats
    home: Floats
    longest: Floats
    courses: tuple[Courses, ...] = ()

    @classmethod
    def of(cls, instance: Instance) -> Legs:
        """Take the legs of an instance; those from a task to itself are forbidden.

        Tours may be longer than the endurance by half of what `instances.check_routes` lets pass: then all that are no
        longer are priced, and none is found that it refuses, in whatever order legs are summed.
        """
        n, uavs = instance.n_tasks, instance.classes
        courses: tuple[Courses, ...] = ()
        if "time" in instance.axes and instance.travel is not None:
            costs, first = instance.travel.cost.min(axis=1), instance.travel.cost[:, 0]
            clocks = clocks_of(instance)
            courses = tuple(by_clock(clocks, k, n) for k in range(instance.n_depots))
        else:
            costs = first = instance.class_costs
        depots = np.array(instance.depots)
        between = np.ascontiguousarray(costs[uavs, :n, :n])
        between[:, np.arange(n), np.arange(n)] = np.inf
        longest = instance.limits * (1 + ENDURANCE_ROUNDING / 2)
        out, home = first[uavs, depots, :n], costs[uavs, :n, depots]
        return cls(np.ascontiguousarray(out), between, np.ascontiguousarray(home), longest, courses)

    @property
    def n_uavs(self) -> int:
        """Number of UAVs, m."""
        return self.out.shape[0]

    @property
    def n_tasks(self) -> int:
        """Number of tasks, n."""
        return self.out.shape[1]

    def copy(self) -> Legs:
        """Return the same legs in arrays of their own."""
        return replace(self, out=self.out.copy(), between=self.between.copy(), home=self.home.copy())

    def of_uav(self, k: int) -> UavLegs:
        """Return UAV k's part of the arrays."""
        return UavLegs(self.out[k], self.between[k], self.home[k])

    def caps(self, cap: float) -> Floats:
        """Return what a tour of each UAV may cost in routes of cost ≤ `cap` [s], (m,)."""
        return np.minimum(self.longest, cap)

    def under(self, cap: float) -> Legs:
        """Forbid every leg that no tour of cost ≤ `cap` can use: the shortest walk through it costs more."""
        left = self.copy()
        limits = self.caps(cap) * (1 + 1e-12)
        walk = np.empty((0, 0))
        for k in range(self.n_uavs):
            if k == 0 or not np.array_equal(self.between[k], self.between[k - 1]):
                walk = shortest_walks(self.between[k])
            out, between, home = left.of_uav(k)
            there = (out[:, None] + walk).min(axis=0)
            back = (walk + home[None, :]).min(axis=1)
            limit = limits[k]
            between[there[:, None] + between + back[None, :] > limit] = np.inf
            out[out + back > limit] = np.inf
            home[there + home > limit] = np.inf
        return left

    def among(self, arcs: Bools) -> Legs:
        """Forbid every leg but those of `arcs` (n + m, n + m), depots last."""
        n, left = self.n_tasks, self.copy()
        left.between[:, ~arcs[:n, :n]] = np.inf
        left.out[~arcs[n:, :n]] = left.home[~arcs[:n, n:].T] = np.inf
        return left

    def kinds(self) -> Ints:
        """Return for every UAV the first that nothing in these legs tells it apart from, (m,)."""
        kinds = np.arange(self.n_uavs)
        for k in kinds:
            for first in range(k):
                pairs = ((a[k], a[first]) for a in (self.longest, self.out, self.home, self.between))
                if not self.courses and all(np.array_equal(one, other) for one, other in pairs):
                    kinds[k] = first
                    break
        return kinds

    def without(self, task: int, uavs: list[int]) -> Legs:
        """Forbid `task` to `uavs`."""
        left = self.copy()
        left.out[uavs, task] = left.home[uavs, task] = np.inf
        left.between[uavs, task, :] = left.between[uavs, :, task] = np.inf
        return left

    def may_visit(self) -> Bools:
        """Say which UAV has a leg left into which task, shape (m, n)."""
        return np.isfinite(self.out) | np.isfinite(self.between).any(axis=1)
