"""Legs: what each UAV pays for each leg, its own matrix, and which legs it may still use.

A leg that is forbidden (too far under the cap on a tour, fixed away by its reduced cost, or branched away) costs
infinity. Every UAV has its own matrix, so that different aircraft need no other code.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from instances import Instance
from instances.arrays import Bools, Floats
from instances.walks import shortest_walks


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

    @property
    def count(self) -> int:
        """Number of legs not forbidden."""
        return int(sum(np.isfinite(part).sum() for part in (self.out, self.between, self.home)))

    def under(self, cap: float) -> Legs:
        """Forbid every leg that no tour of cost ≤ `cap` can use: the shortest walk through it costs more."""
        out, between, home = self.out.copy(), self.between.copy(), self.home.copy()
        limit = cap * (1 + 1e-12)
        walk = np.empty((0, 0))
        for k in range(self.n_uavs):
            if k == 0 or not np.array_equal(self.between[k], self.between[k - 1]):
                walk = shortest_walks(self.between[k])
            there = (out[k][:, None] + walk).min(axis=0)
            back = (walk + home[k][None, :]).min(axis=1)
            between[k][there[:, None] + between[k] + back[None, :] > limit] = np.inf
            out[k][out[k] + back > limit] = np.inf
            home[k][there + home[k] > limit] = np.inf
        return Legs(out, between, home)

    def without(self, task: int, uavs: list[int]) -> Legs:
        """Forbid `task` to `uavs`."""
        out, between, home = self.out.copy(), self.between.copy(), self.home.copy()
        out[uavs, task] = home[uavs, task] = np.inf
        between[uavs, task, :] = between[uavs, :, task] = np.inf
        return Legs(out, between, home)

    def may_visit(self) -> Bools:
        """Say which UAV has a leg left into which task, shape (m, n)."""
        return np.isfinite(self.out) | np.isfinite(self.between).any(axis=1)
