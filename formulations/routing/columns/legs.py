"""Legs: what each UAV pays for each leg, its own matrix, and which legs it may still use.

A leg that is forbidden (too far under the cap on a tour, fixed away by its reduced cost, or branched away) costs
infinity. Every UAV has its own matrix, so that different aircraft need no other code.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from instances import Instance
from instances.arrays import Bools, Floats
from instances.walks import shortest_walks


class UavLegs(NamedTuple):
    """Costs [s] of one UAV: `out` (n,) depot to task, `between` (n, n), `home` (n,) task to depot."""

    out: Floats
    between: Floats
    home: Floats

    def backwards(self) -> UavLegs:
        """Return the legs flown the other way: the way home becomes the way out."""
        return UavLegs(self.home, np.ascontiguousarray(self.between.T), self.out)


@dataclass(frozen=True)
class Legs:
    """Costs [s] of every UAV: `out` (m, n) depot to task, `between` (m, n, n), `home` (m, n) task to depot."""

    out: Floats
    between: Floats
    home: Floats

    @classmethod
    def of(cls, instance: Instance) -> Legs:
        """Take the legs of an instance; those from a task to itself are forbidden."""
        n, m, c = instance.n_tasks, instance.n_depots, instance.cost
        between = np.broadcast_to(c[:n, :n], (m, n, n)).copy()
        between[:, np.arange(n), np.arange(n)] = np.inf
        return cls(c[n:, :n].copy(), between, c[:n, n:].T.copy())

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
        return Legs(self.out.copy(), self.between.copy(), self.home.copy())

    def of_uav(self, k: int) -> UavLegs:
        """Return UAV k's part of the arrays."""
        return UavLegs(self.out[k], self.between[k], self.home[k])

    def under(self, cap: float) -> Legs:
        """Forbid every leg that no tour of cost ≤ `cap` can use: the shortest walk through it costs more."""
        left = self.copy()
        limit = cap * (1 + 1e-12)
        walk = np.empty((0, 0))
        for k in range(self.n_uavs):
            if k == 0 or not np.array_equal(self.between[k], self.between[k - 1]):
                walk = shortest_walks(self.between[k])
            out, between, home = left.of_uav(k)
            there = (out[:, None] + walk).min(axis=0)
            back = (walk + home[None, :]).min(axis=1)
            between[there[:, None] + between + back[None, :] > limit] = np.inf
            out[out + back > limit] = np.inf
            home[there + home > limit] = np.inf
        return left

    def without(self, task: int, uavs: list[int]) -> Legs:
        """Forbid `task` to `uavs`."""
        left = self.copy()
        left.out[uavs, task] = left.home[uavs, task] = np.inf
        left.between[uavs, task, :] = left.between[uavs, :, task] = np.inf
        return left

    def may_visit(self) -> Bools:
        """Say which UAV has a leg left into which task, shape (m, n)."""
        return np.isfinite(self.out) | np.isfinite(self.between).any(axis=1)
