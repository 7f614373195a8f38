r"""The total bound: the least sum of all tours in the linear relaxation, arcs without a UAV, a UAV's share of it.

With x_ij how much of arc (i, j) all UAVs fly together, and w_k, c_ij = min_k w_k c_ijk as in ``simple_bounds.py``,

    min Σ c_ij x_ij    Σ_j x_ij = Σ_j x_ji = 1 for every task i,
                       Σ_j x_kj = Σ_j x_jk ≤ 1 for every depot k,
                       Σ_{i∈S} Σ_{j∈S} x_ij ≤ |S| − 1 for every set S of tasks, 0 ≤ x_ij ≤ 1,

÷ Σ_k w_k: eqs. const1 to const6 of the paper added up over the UAVs (for one UAV the relaxation of Dantzig, Fulkerson
and Johnson, whose value is Held and Karp's bound). As weak for min-max as the relaxation of the MILP, whose size is m
times this one's: instances of hundreds of tasks take seconds.

Rows are separated (``separation.py``) and arcs priced: those to the nearest tasks first, then whatever has a negative
reduced cost. The bound is not the LP solver's value but the Lagrangian at its duals over *all* arcs,

    Σ_r π_r rhs_r + Σ_ij min(0, c_ij − Σ_r π_r a_rij),

which holds at any duals of the right sign, less what rounding can come to.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import highspy
import numpy as np

from formulations.routing.separation import subtours
from formulations.routing.simple_bounds import weighted_costs
from instances import Instance
from instances.arrays import Bools, Floats, Ints

_NEAREST = 8
"""Arcs into and out of each node to begin with."""
_LEAST = 1e-3
"""Violation of a cut worth adding."""
_CHEAP = 1e-7
"""Share of the upper bound below −1 times which the reduced cost of an arc makes it worth adding."""
_NEW = 3
"""Arcs added at once, for each node."""


class Total(NamedTuple):
    """The `bound` [s], whether nothing more can be cut off, a UAV's share of what each task costs, `price` (n,) [s].

    Tasks in a set that is cut off share what it costs to enter it. No claim is made about prices.
    """

    bound: float
    complete: bool
    price: Floats


def total(instance: Instance, upper: float, time_limit: float) -> Total:
    """Return the bound, at most `upper` [s], the cost of routes known.

    0, as the prices, where not even the first programme was solved within `time_limit` [s].
    """
    end = time.perf_counter() + time_limit
    programme = _Programme(instance, upper)
    complete = False
    while not complete and programme.solve(end):
        cut, grown = programme.cut(), programme.grow()
        complete = not grown and not cut
    return Total(min(upper, max(0.0, programme.bound)), complete, programme.price)


class _Programme:
    """The programme over the arcs `tail`, `head` and the sets `cuts` known so far, solved warm by HiGHS."""

    def __init__(self, instance: Instance, upper: float) -> None:
        self.n, self.N, self.upper, self.bound = instance.n_tasks, instance.n_nodes, upper, 0.0
        self.cost, self.weight = weighted_costs(instance, upper)
        np.fill_diagonal(self.cost, np.inf)
        self.cost[self.n :, self.n :] = np.inf
        self.cuts, self.price = np.zeros((0, self.n), np.bool_), np.zeros(self.n)
        self.tail, self.head = np.zeros(0, np.int64), np.zeros(0, np.int64)
        self.lp = highspy.Highs()
        for option, value in (("output_flag", False), ("threads", 1), ("random_seed", 0)):
            self.lp.setOptionValue(option, value)
        none = np.array([], dtype=np.int32), np.array([])
        m, below = self.N - self.n, -highspy.kHighsInf
        for low, high, count in ((1.0, 1.0, 2 * self.n), (0.0, 0.0, m), (below, 1.0, m)):
            for _ in range(count):
                self.lp.addRow(low, high, 0, *none)
        self._add(np.argwhere(self._first()))

    def _first(self) -> Bools:
        """Return the arcs to begin with, (N, N): the cheapest at every node, and one tour, to be feasible."""
        first = np.zeros((self.N, self.N), np.bool_)
        at = np.arange(self.N)[:, None]
        first[at, np.argsort(self.cost, axis=1)[:, :_NEAREST]] = True
        first[np.argsort(self.cost, axis=0)[:_NEAREST].T, at] = True
        tour = np.arange(self.n + 1)
        first[tour, np.roll(tour, -1)] = True
        return first & np.isfinite(self.cost)

    def _add(self, arcs: Ints) -> None:
        """Add arcs (a, 2): rows are tasks entered, tasks left, depots balanced, depots left, cuts."""
        n, m = self.n, self.N - self.n
        for i, j in arcs.tolist():
            rows, signs = ([j], [1.0]) if j < n else ([n + j], [-1.0])
            rows += [n + i] if i < n else [n + i, n + m + i]
            signs += [1.0] * (len(rows) - 1)
            if i < n and j < n:
                held = np.flatnonzero(self.cuts[:, i] & self.cuts[:, j])
                rows, signs = rows + (2 * self.N + held).tolist(), signs + [1.0] * held.size
            entries = np.array(rows, dtype=np.int32), np.array(signs)
            self.lp.addCol(float(self.cost[i, j]), 0.0, highspy.kHighsInf, len(rows), *entries)  # entered: at most 1
        self.tail, self.head = np.concatenate([self.tail, arcs[:, 0]]), np.concatenate([self.head, arcs[:, 1]])

    def solve(self, end: float) -> bool:
        """Solve, and raise the bound; say whether that was done before `end`."""
        self.lp.setOptionValue("time_limit", self.lp.getRunTime() + max(0.0, end - time.perf_counter()))
        self.lp.run()
        if self.lp.getModelStatus() != highspy.HighsModelStatus.kOptimal:
            return False
        solution = self.lp.getSolution()
        self.flow, dual = np.array(solution.col_value), np.array(solution.row_dual)
        dual[self.N + self.n :] = np.minimum(dual[self.N + self.n :], 0.0)
        self._price(dual)
        return True

    def _price(self, dual: Floats) -> None:
        """Raise the bound to the Lagrangian at the duals, and keep the reduced costs of all arcs."""
        n = self.n
        entered, left, balance, used, cut = np.split(dual, [n, 2 * n, self.N + n, 2 * self.N])
        reduced = self.cost.copy()
        reduced[:, :n] -= entered
        reduced[:, n:] += balance
        reduced[:n] -= left[:, None]
        reduced[n:] -= (balance + used)[:, None]
        paid = np.flatnonzero(cut < 0)
        for price, held in zip(cut[paid], self.cuts[paid], strict=True):
            tasks = np.flatnonzero(held)
            reduced[np.ix_(tasks, tasks)] -= price
        value = entered.sum() + left.sum() + used.sum() + float(cut @ (self.cuts.sum(axis=1) - 1))
        value += np.minimum(reduced, 0.0)[np.isfinite(reduced)].sum()
        size = 2 * self.upper + float(np.abs(dual).sum())
        margin = (self.N**2 + dual.size) * (paid.size + 8) * 2.0**-52 * size
        self.reduced = reduced
        self.price = (entered + left + cut @ (self.cuts - self.cuts / self.cuts.sum(axis=1)[:, None])) / self.weight
        self.bound = max(self.bound, (float(value) - margin) / self.weight)

    def grow(self) -> bool:
        """Add arcs of negative reduced cost; say whether there were any."""
        missing = self.reduced < -_CHEAP * self.upper
        missing[self.tail, self.head] = False
        arcs = np.argwhere(missing)
        order = np.argsort(self.reduced[arcs[:, 0], arcs[:, 1]], kind="stable")
        self._add(arcs[order[: _NEW * self.N]])
        return arcs.size > 0

    def cut(self) -> bool:
        """Add the cuts that the flow violates; say whether there were any. All depots count as one."""
        theta = np.zeros((self.n + 1, self.n + 1))
        np.add.at(theta, (np.minimum(self.tail, self.n), np.minimum(self.head, self.n)), np.maximum(self.flow, 0.0))
        sets, _ = subtours(theta, _LEAST)
        for held in sets:
            inside = (self.tail < self.n) & (self.head < self.n)
            inside[inside] = held[self.tail[inside]] & held[self.head[inside]]
            arcs = np.flatnonzero(inside).astype(np.int32)
            self.lp.addRow(-highspy.kHighsInf, float(held.sum() - 1), arcs.size, arcs, np.ones(arcs.size))
        self.cuts = np.concatenate([self.cuts, sets])
        return len(sets) > 0
