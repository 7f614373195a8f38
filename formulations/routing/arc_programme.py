r"""The linear programme over arcs without a UAV, with sets of tasks that must be entered often enough.

With x_ij how much of arc (i, j) all UAVs fly together,

    min Σ c_ij x_ij    Σ_j x_ij = Σ_j x_ji = 1                 for every task i,
                       Σ_j x_kj = Σ_j x_jk ≤ 1                 for every depot k,   Σ_k Σ_j x_kj ≤ the UAVs there are,
                       Σ_{i∈S} Σ_{j∈S} x_ij ≤ |S| − r(S)       for sets S of tasks that need r(S) UAVs, 0 ≤ x_ij ≤ 1:

eqs. const1 to const6 of the paper added up over the UAVs. r(S) is 1 as a rule: const6. That S is entered r(S) times at
least is the same, written from outside.

Rows are separated and arcs priced: those to the nearest tasks first, then whatever has a negative reduced cost. The
bound is not the LP solver's value but the Lagrangian at its duals over *all* arcs,

    Σ_r π_r rhs_r + Σ_ij min(0, c_ij − Σ_r π_r a_rij),

which holds at any duals of the right sign, less what rounding can come to.
"""

from __future__ import annotations

import time

import highspy
import numpy as np

from formulations.routing.separation import subtours
from instances.arrays import Bools, Floats, Ints

_NEAREST = 8
"""Arcs into and out of each node to begin with."""
_LEAST = 1e-3
"""Violation of a cut worth adding."""
_CHEAP = 1e-7
"""Share of the upper bound below −1 times which the reduced cost of an arc makes it worth adding."""
_NEW = 3
"""Arcs added at once, for each node."""


class ArcProgramme:
    """The programme over the arcs `tail`, `head` and the sets `cuts` known so far, solved warm by HiGHS.

    cost : c_ij [s], shape (N, N), tasks first, infinite where there is no arc; fleet : the UAVs there are.
    upper [s] : the greatest of the costs is about that, twice at most.
    sum : the highest bound so far [s]; solved : whether there was a first one.
    flow : x of the arcs; need : r of the `cuts` (c, n).
    reduced : reduced costs of all arcs at the last duals, whose bound is `last`; entering (n,), leaving (n,) and
        charge (c,) : duals of tasks and cuts; of_uav : what each UAV in use adds at least, ≤ 0 [s].
    below, margin [s] : the negative reduced costs together, ≤ 0, and more than rounding can come to.
    """

    def __init__(self, cost: Floats, n_tasks: int, fleet: int, upper: float) -> None:
        self.n, self.N, self.upper, self.cost, self.fleet = n_tasks, len(cost), upper, cost, fleet
        self.sum, self.last, self.solved = 0.0, -np.inf, False
        self.cuts, self.need = np.zeros((0, self.n), np.bool_), np.zeros(0, np.int64)
        self.entering, self.leaving, self.charge, self.of_uav = np.zeros(self.n), np.zeros(self.n), np.zeros(0), 0.0
        self.tail, self.head = np.zeros(0, np.int64), np.zeros(0, np.int64)
        self._cut_rows, self._columns = list[int](), list[int]()
        self.lp = highspy.Highs()
        for option, value in (("output_flag", False), ("threads", 1), ("random_seed", 0)):
            self.lp.setOptionValue(option, value)
        m, below = self.N - self.n, -highspy.kHighsInf
        for low, high, count in ((1.0, 1.0, 2 * self.n), (0.0, 0.0, m), (below, 1.0, m), (below, float(fleet), 1)):
            for _ in range(count):
                self.add_row(low, high)
        self._begin()
        self._add(np.argwhere(self._first()))

    def solve_all(self, end: float, enough: float = np.inf) -> bool:
        """Solve until no arc is missing and no set is entered less than once, or the bound passes `enough` [s].

        Return whether that was before `end`.
        """
        while self.solve(end):
            if self.sum > enough:
                return True
            cut, grown = self.cut(), self.grow()
            if not grown and not cut:
                return True
        return False

    def add_row(self, low: float, high: float) -> int:
        """Add a row without entries and return its number."""
        self.lp.addRow(low, high, 0, np.array([], dtype=np.int32), np.array([]))
        return int(self.lp.getNumRow()) - 1

    def add_column(self, cost: float, rows: list[int], entries: list[float]) -> int:
        """Add a column ≥ 0 and return its number."""
        self.lp.addCol(cost, 0.0, highspy.kHighsInf, len(rows), np.array(rows, dtype=np.int32), np.array(entries))
        return int(self.lp.getNumCol()) - 1

    def _begin(self) -> None:
        """Add what there is before the first arc."""

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
        """Add arcs (a, 2)."""
        for i, j in arcs.tolist():
            self._columns.append(self._add_arc(i, j))
        self.tail, self.head = np.concatenate([self.tail, arcs[:, 0]]), np.concatenate([self.head, arcs[:, 1]])

    def _add_arc(self, i: int, j: int) -> int:
        """Add one arc and return its column."""
        return self.add_column(float(self.cost[i, j]), *self._entries(i, j))  # entered: at most 1

    def _entries(self, i: int, j: int) -> tuple[list[int], list[float]]:
        """Return the entries of an arc; rows are tasks entered, tasks left, depots balanced, depots left, all left."""
        n, m = self.n, self.N - self.n
        rows, entries = ([j], [1.0]) if j < n else ([n + j], [-1.0])
        rows += [n + i] if i < n else [n + i, n + m + i, 2 * self.N]
        if i < n and j < n:
            rows += [self._cut_rows[c] for c in np.flatnonzero(self.cuts[:, i] & self.cuts[:, j])]
        return rows, entries + [1.0] * (len(rows) - 1)

    def solve(self, end: float) -> bool:
        """Solve, and raise the bound; say whether that was done before `end`."""
        self.lp.setOptionValue("time_limit", self.lp.getRunTime() + max(0.0, end - time.perf_counter()))
        self.lp.run()
        if self.lp.getModelStatus() != highspy.HighsModelStatus.kOptimal:
            return False
        solution = self.lp.getSolution()
        self.flow, dual = np.array(solution.col_value)[self._columns], np.array(solution.row_dual)
        self._price(dual)
        self.solved = True
        return True

    def _price(self, dual: Floats) -> None:
        """Raise the bound to the Lagrangian at the duals, and keep the reduced costs of all arcs."""
        n, m = self.n, self.N - self.n
        ends = [n, 2 * n, self.N + n, 2 * self.N, 2 * self.N + 1]
        self.entering, self.leaving, balance, used, every, _ = np.split(dual, ends)
        used, fleet = np.minimum(used, 0.0), min(float(every[0]), 0.0)
        self.charge, self.of_uav = np.minimum(dual[self._cut_rows], 0.0), float(used.min(initial=0.0)) + fleet
        reduced = self.cost.copy()
        reduced[:, :n] -= self.entering
        reduced[:, n:] += balance
        reduced[:n] -= self.leaving[:, None]
        reduced[n:] -= (balance + used + fleet)[:, None]
        paid = np.flatnonzero(self.charge < 0)
        for price, held in zip(self.charge[paid], self.cuts[paid], strict=True):
            tasks = np.flatnonzero(held)
            reduced[np.ix_(tasks, tasks)] -= price
        size = 2 * self.upper + float(np.abs(dual).sum()) * (m + 2)
        size += self._beside(reduced, dual)
        value = self.entering.sum() + self.leaving.sum() + used.sum() + fleet * self.fleet
        value += float(self.charge @ (self.cuts.sum(axis=1) - self.need))
        self.below = float(np.minimum(reduced, 0.0)[np.isfinite(reduced)].sum())
        self.margin = (self.N**2 + dual.size) * (paid.size + 16) * 2.0**-52 * size
        self.reduced, self.last = reduced, float(value) + self.below - self.margin
        self.sum = max(self.sum, self.last)

    def _beside(self, reduced: Floats, dual: Floats) -> float:
        """Take off the reduced costs what other rows say; return the size of the numbers this takes [s]."""
        return 0.0

    @property
    def price(self) -> Floats:
        """What each task costs [s], (n,): tasks in a set share what it costs to enter it. No bound rests on it."""
        sizes = self.cuts.sum(axis=1)
        return np.asarray(self.entering + self.leaving + (self.charge * (sizes - self.need) / sizes) @ self.cuts)

    def grow(self) -> bool:
        """Add arcs of negative reduced cost; say whether there were any."""
        missing = self.reduced < -_CHEAP * self.upper
        missing[self.tail, self.head] = False
        arcs = np.argwhere(missing)
        order = np.argsort(self.reduced[arcs[:, 0], arcs[:, 1]], kind="stable")
        self._add(arcs[order[: _NEW * self.N]])
        return arcs.size > 0

    def entered(self) -> Floats:
        """Return x between tasks and all depots as one, the last, (n + 1, n + 1)."""
        flow = np.zeros((self.n + 1, self.n + 1))
        np.add.at(flow, (np.minimum(self.tail, self.n), np.minimum(self.head, self.n)), np.maximum(self.flow, 0.0))
        return flow

    def cut(self) -> bool:
        """Add the sets that x enters less than once; say whether there were any."""
        flow = self.entered()
        sets, _ = subtours(flow, _LEAST)
        inside = np.array([flow[np.ix_(held, held)].sum() for held in (np.append(tasks, False) for tasks in sets)])
        sets = sets[inside > sets.sum(axis=1) - 1 + _LEAST / 2]  # tasks may be left out while arcs are missing
        self.add_sets(sets, np.ones(len(sets), np.int64))
        return len(sets) > 0

    def add_sets(self, sets: Bools, need: Ints) -> None:
        """Add sets of tasks (c, n) and how many UAVs each needs, (c,)."""
        for held, least in zip(sets, need.tolist(), strict=True):
            inside = (self.tail < self.n) & (self.head < self.n)
            inside[inside] = held[self.tail[inside]] & held[self.head[inside]]
            arcs = np.array(self._columns, dtype=np.int32)[inside]
            self.lp.addRow(-highspy.kHighsInf, float(held.sum() - least), arcs.size, arcs, np.ones(arcs.size))
            self._cut_rows.append(int(self.lp.getNumRow()) - 1)
        self.cuts, self.need = np.concatenate([self.cuts, sets]), np.concatenate([self.need, need])
