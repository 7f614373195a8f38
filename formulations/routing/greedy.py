"""Greedy construction: cheapest insertion for the min-max objective, the floor every other method must beat.

Starting from empty tours, repeat: over every task not yet routed, every UAV k and every position of its tour, take the
insertion after which that UAV's tour C_k (eq. costsum) is shortest; ties go to the lowest UAV, task and position. So
the tours grow side by side, as in the cheapest-insertion heuristic of Rosenkrantz, Stearns and Lewis (SIAM J. Comput.
6, 1977), with the resulting tour cost instead of its increase as the measure, because C_max counts and not the sum.

O(n²) insertions are looked at: after each step only the tour that changed is looked at again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from formulations.recorder import Recorder
from formulations.solver import Limits, Observer, Result, Solver, ignore
from instances import Instance, Routes, as_routes


@dataclass(frozen=True)
class Greedy(Solver):
    """Cheapest insertion for min-max; no options, no randomness."""

    proves: ClassVar[bool] = False

    def prepare(self, instance: Instance) -> None:
        """Compile the kernel."""
        greedy_routes(Instance("warm-up", np.zeros((2, 2)), 1, 1))

    def solve(
        self,
        instance: Instance,
        *,
        limits: Limits,
        seed: int = 0,
        observe: Observer = ignore,
        start: Routes | None = None,
    ) -> Result:
        """Construct routes; the limits are not needed."""
        recorder = Recorder(instance, limits, observe, start)
        recorder.incumbent(greedy_routes(instance))
        return recorder.result("finished")


def greedy_routes(instance: Instance) -> Routes:
    """Return the routes of cheapest insertion for min-max."""
    return as_routes(
        tour[:length]
        for tour, length in zip(
            *cheapest_insertion(instance.cost, int(instance.n_tasks), int(instance.n_depots)), strict=True
        )
    )


@njit(cache=True)
def cheapest_insertion(
    cost: NDArray[np.float64], n: int, m: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:  # pragma: no cover - compiled
    """Return tours (m, n), padded with −1, and their lengths (m,)."""
    tours = np.full((m, n), -1, dtype=np.int64)
    lengths = np.zeros(m, dtype=np.int64)
    totals = np.zeros(m)
    increase = np.empty((m, n))
    position = np.zeros((m, n), dtype=np.int64)
    routed = np.zeros(n, dtype=np.bool_)
    for k in range(m):
        for i in range(n):
            increase[k, i] = cost[n + k, i] + cost[i, n + k]
    for _ in range(n):
        best, best_k, best_i = np.inf, -1, -1
        for k in range(m):
            for i in range(n):
                if not routed[i] and (best_k < 0 or totals[k] + increase[k, i] < best):
                    best, best_k, best_i = totals[k] + increase[k, i], k, i
        k, at = best_k, position[best_k, best_i]
        tour = tours[k]
        for p in range(lengths[k], at, -1):
            tour[p] = tour[p - 1]
        tour[at] = best_i
        lengths[k] += 1
        totals[k] = best
        routed[best_i] = True
        for i in range(n):
            if routed[i]:
                continue
            increase[k, i] = np.inf
            for p in range(lengths[k] + 1):
                a = tour[p - 1] if p > 0 else n + k
                b = tour[p] if p < lengths[k] else n + k
                extra = cost[a, i] + cost[i, b] - cost[a, b]
                if extra < increase[k, i]:
                    increase[k, i], position[k, i] = extra, p
    return tours, lengths
