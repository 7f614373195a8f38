r"""Arcs and the time at which they are flown: no tour is longer than the cap, in the linear relaxation.

t_ij is when whoever flies arc (i, j) arrives at j, 0 where nobody does. With c_ij the least that a UAV takes for the
arc, d_i and h_i the least that it takes to task i from a depot and home, and the cap U on all tours,

    Σ_j t_ij = Σ_j t_ji + Σ_j c_ij x_ij      for every task i,    (d_i + c_ij) x_ij ≤ t_ij ≤ (U − h_j) x_ij

(the flow of Gavish & Graves, 1978, for a limit on distance; Kara, "Arc based integer programming formulations for the
distance constrained vehicle routing problem", LINDI 2011). Arcs for which the two sides leave no room are in no routes
within the cap. Here s_ij = t_ij − (d_i + c_ij) x_ij ≥ 0, at most w_ij x_ij, w_ij = U − h_j − c_ij − d_i, and times are
shares of U.

With μ_i the duals of the times, an arc's least contribution to the Lagrangian takes s_ij = 0 or w_ij x_ij, whichever is
cheaper: that is a reduced cost of x_ij alone. The rows s_ij ≤ w_ij x_ij need no duals, and arcs are priced as before.
"""

from __future__ import annotations

import highspy
import numpy as np

from formulations.routing.arc_programme import ArcProgramme
from formulations.routing.simple_bounds import ways_between_tasks, ways_from_depot
from instances.arrays import Floats

_ROUNDING = 1e-9  # of the cap: room that an arc may lack
_DEAR = 4.0  # caps: what leaving out a task costs, which keeps the programme feasible while arcs are missing


class TimedArcs(ArcProgramme):
    """The programme with times; `time` (N, N) [s]: the least that a UAV takes for each arc, `cap` [s] of the tours."""

    def __init__(self, cost: Floats, time: Floats, n_tasks: int, fleet: int, cap: float) -> None:
        N, between = len(cost), ways_between_tasks(time, n_tasks)
        ways = [ways_from_depot(time, between, k) for k in range(n_tasks, N)]
        at_depots = np.zeros(N - n_tasks)
        self.out = np.append(np.min([out for out, _ in ways], axis=0), at_depots) / cap
        home = np.append(np.min([home for _, home in ways], axis=0), at_depots) / cap
        self.arrival = self.out[:, None] + time / cap
        self.room = 1.0 - home[None, :] - self.arrival
        cost = np.where(self.room < -_ROUNDING, np.inf, cost)
        self.room = np.maximum(self.room, 0.0) * (1 + _ROUNDING)
        self.room[n_tasks:] = 0.0  # nobody waits at a depot
        self.arrival = np.where(np.isfinite(cost), self.arrival, 0.0)
        super().__init__(cost, n_tasks, fleet, cap)

    def _begin(self) -> None:
        """Add the rows of times, and what stands in for missing arcs."""
        self._times = [self.add_row(0.0, 0.0) for _ in range(self.n)]
        for i in range(self.n):
            self.add_column(_DEAR * self.upper, [i, self.n + i], [1.0, 1.0])

    def _add_arc(self, i: int, j: int) -> int:
        """Add x and s of one arc, and the row between them."""
        rows, entries = self._entries(i, j)
        left, arriving = ([self._times[i]] if i < self.n else []), ([self._times[j]] if j < self.n else [])
        if left:
            rows, entries = rows + left, [*entries, self.out[i]]
        if arriving:
            rows, entries = rows + arriving, [*entries, -self.arrival[i, j]]
        if not self.room[i, j] > 0:
            return self.add_column(float(self.cost[i, j]), rows, entries)
        link = self.add_row(-highspy.kHighsInf, 0.0)
        column = self.add_column(float(self.cost[i, j]), [*rows, link], [*entries, -self.room[i, j]])
        self.add_column(0.0, [*left, *arriving, link], [1.0] * len(left) + [-1.0] * len(arriving) + [1.0])
        return column

    def _beside(self, reduced: Floats, dual: Floats) -> float:
        """Take off what the duals of the times say."""
        n, of_time = self.n, np.append(dual[self._times], np.zeros(self.N - self.n))
        reduced -= of_time[:, None] * self.out[:, None]
        reduced[:, :n] += of_time[None, :n] * self.arrival[:, :n]
        reduced += self.room * np.minimum(of_time[None, :] - of_time[:, None], 0.0)
        return 4 * float(np.abs(of_time).sum())
