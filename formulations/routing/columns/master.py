"""The restricted master: the linear programme over the tours known so far, re-solved warm by HiGHS.

    min z + Σ_i (π̂_i + w_i) s_i + (w_i − π̂_i) t_i
    Σ_K Σ_p a_ip λ_p + s_i − t_i = 1        task i        dual π_i, held in π̂_i ± w_i
    Σ_p c_p λ_p − |K| z ≤ 0                 kind K        dual −σ_k
    Σ_p λ_p ≤ |K|                           kind K        dual −μ_k
    Σ_K Σ_p ⌊|S ∩ p|/2⌋ λ_p ≤ 1             cut S         dual −ρ_S

K are the UAVs that nothing tells apart (one each where all differ): they have the same tours, and the mean over all
ways to rename them turns any λ into one that is the same for each, so that one row and one column serve them all, and
σ_k, μ_k are the same for each.

(paper, eqs. c_max, const1, const3 and const5 with whole tours as variables). s and t keep it feasible, and the duals of
a poor set of columns in a box, which `widen` opens where it binds (du Merle et al. 1999). Its value is no bound: bounds
come from `pricing`, at the duals found here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import highspy
import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.cuts import Cut, incidence, pays
from formulations.routing.columns.label_search import Clock, no_limit
from formulations.routing.columns.pricing import SHY, Column, Duals
from instances.arrays import Bools, Floats, Ints

_SIMPLEX = 0  # primal where the basis is primal feasible, as it is after new columns: thrice as fast as always dual
_ONE_BY_ONE = 6  # times that the box is opened only where it binds
WIDE = 20.0
"""Fair shares of the cap, half width of a box for duals of which nothing is known: tasks of a UAV that sets the
relaxation alone cost nearly all of the cap."""


class Optimum(NamedTuple):
    """The master solved: its `value` [s], the `duals` (σ ≥ 0 scaled to Σσ = 1) and `weight`, λ of the columns."""

    value: float
    duals: Duals
    weight: Floats


class Master:
    """A growing linear programme over columns and cuts.

    half : half width of the box the duals of the tasks begin in [s], one for all or (n,); centre : its middle.
    kinds : UAVs of one number are alike, (m,); a column of one of them is kept as one of the `first` of them.
    exempt : UAVs alone of their kind that z need not reach: σ_k = 0.
    uavs : the first of every kind; first (m,) : the first that is like each UAV.
    """

    def __init__(
        self,
        n_tasks: int,
        kinds: Ints,
        half: float | Floats,
        cuts: Sequence[Cut] = (),
        centre: float | Floats = 0.0,
        exempt: Collection[int] = (),
    ) -> None:
        self.n, self.m = n_tasks, kinds.size
        _, self.uavs, self._kind = np.unique(kinds, return_index=True, return_inverse=True)
        self.first, alike = self.uavs[self._kind], np.bincount(self._kind).astype(float)
        self.columns: list[Column] = []
        self.cuts: list[Cut] = []
        self.exempt = frozenset(exempt)
        self.half = np.tile(np.broadcast_to(half, n_tasks), 2)
        self.centre = np.outer((1.0, -1.0), np.broadcast_to(centre, n_tasks)).ravel()
        self._known: dict[tuple[int, tuple[int, ...]], int] = {}
        self._widened = 0
        self._first = 1 + 2 * n_tasks
        n_kinds = self.uavs.size
        self._cuts_from = n_tasks + 2 * n_kinds
        self._lp = lp = highspy.Highs()
        settings = (("output_flag", False), ("threads", 1), ("random_seed", 0), ("simplex_strategy", _SIMPLEX))
        for option, value in settings:
            lp.setOptionValue(option, value)
        empty = np.array([], dtype=np.int32), np.array([])
        below_z = [highspy.kHighsInf if k in self.exempt else 0.0 for k in self.uavs.tolist()]
        for upper in [1.0] * n_tasks + below_z + alike.tolist():
            lower = 1.0 if lp.getNumRow() < n_tasks else -highspy.kHighsInf
            lp.addRow(lower, upper, 0, *empty)
        costs = np.arange(n_tasks, n_tasks + n_kinds, dtype=np.int32)
        lp.addCol(1.0, 0.0, highspy.kHighsInf, n_kinds, costs, -alike)
        for i in range(2 * n_tasks):
            sign = np.array([1.0 if i < n_tasks else -1.0])
            price = float(self.centre[i] + self.half[i])
            lp.addCol(price, 0.0, highspy.kHighsInf, 1, np.array([i % n_tasks], dtype=np.int32), sign)
        self.cut_off(cuts)

    def add(self, columns: Sequence[Column]) -> int:
        """Add those columns that are new, or cheaper than the known one over the same tasks; return how many."""
        new = []
        for column in columns:
            first = int(self.first[column.uav])
            key = (first, tuple(sorted(column.tasks)))
            known = self._known.get(key)
            if known is None or column.cost < self.columns[known].cost:
                self._known[key] = len(self.columns)
                new.append(column if column.uav == first else replace(column, uav=first))
                self.columns.append(new[-1])
        if new:
            paid = pays(incidence([column.tasks for column in new], self.n), self.cuts)
            rows, values = zip(*map(self._entries, new, paid), strict=True)
            start = np.cumsum([0] + [part.size for part in rows[:-1]], dtype=np.int32)
            zeros, size = np.zeros(len(new)), int(sum(part.size for part in rows))
            self._lp.addCols(
                len(new), zeros, zeros, np.full(len(new), highspy.kHighsInf), size, start,
                np.concatenate(rows), np.concatenate(values),
            )  # fmt: skip
        return len(new)

    def _entries(self, column: Column, paid: Bools) -> tuple[NDArray[np.int32], Floats]:
        times, kind = Counter(column.tasks), int(self._kind[column.uav])
        cuts = (self._cuts_from + np.flatnonzero(paid)).tolist()
        rows = [*sorted(times), self.n + kind, self.n + self.uavs.size + kind, *cuts]
        values = [*(float(times[i]) for i in sorted(times)), column.cost, 1.0, *(1.0 for _ in cuts)]
        return np.array(rows, dtype=np.int32), np.array(values)

    def cut_off(self, cuts: Sequence[Cut]) -> None:
        """Add subset-row cuts."""
        paid = pays(incidence([column.tasks for column in self.columns], self.n), cuts)
        for cut, by in zip(cuts, paid.T, strict=True):
            index = (self._first + np.flatnonzero(by)).astype(np.int32)
            self._lp.addRow(-highspy.kHighsInf, 1.0, index.size, index, np.ones(index.size))
            self.cuts.append(cut)

    def solve(self, time_left: Clock = no_limit) -> Optimum | None:
        """Solve the linear programme over the columns known; return None where time was up before that was done."""
        # the limit is one of all runs so far
        self._lp.setOptionValue("time_limit", self._lp.getRunTime() + max(0.0, time_left()))
        self._lp.run()
        if self._lp.getModelStatus() == highspy.HighsModelStatus.kTimeLimit:
            return None
        solution = self._lp.getSolution()
        parts = np.cumsum([self.n, self.uavs.size, self.uavs.size])
        price, sigma, rent, rho = np.split(np.asarray(solution.row_dual), parts)
        sigma, rent, rho = (np.maximum(0.0, -part) for part in (sigma[self._kind], rent[self._kind], rho))
        total = float(sigma.sum())
        sigma = sigma / total * SHY if total > 0 else np.full(self.m, SHY / self.m)
        duals = Duals(price.copy(), sigma, rent, rho, tuple(self.cuts))
        weight = np.asarray(solution.col_value)[self._first :].copy()
        return Optimum(float(self._lp.getInfo().objective_function_value), duals, weight)

    @property
    def any_duals(self) -> Duals:
        """Duals of which nothing can be said but that they are some."""
        return Duals(np.zeros(self.n), np.full(self.m, SHY / self.m), np.zeros(self.m), np.zeros(0))

    def without(self, dropped: Bools, pivots: int) -> float:
        """Return what a few pivots raise the solved master's value to [s] without some columns.

        Columns and basis are back afterwards, so that the next trial starts as near to its optimum as this one.
        """
        lp, basis = self._lp, self._lp.getBasis()
        index = (self._first + np.flatnonzero(dropped)).astype(np.int32)
        zeros = np.zeros(index.size)
        lp.changeColsBounds(index.size, index, zeros, zeros)
        lp.setOptionValue("simplex_iteration_limit", pivots)
        lp.setOptionValue("time_limit", highspy.kHighsInf)
        lp.run()
        value = float(lp.getInfo().objective_function_value)
        lp.setOptionValue("simplex_iteration_limit", highspy.kHighsIInf)
        lp.changeColsBounds(index.size, index, zeros, np.full(index.size, highspy.kHighsInf))
        lp.setBasis(basis)
        return value

    def whole(self, time: float, nodes: int = 100) -> list[Column]:
        """Return the best whole tours among the columns known, by a short branch and bound in HiGHS; none if not found.

        Only a heuristic: the caller checks what the tours visit. Meanwhile no task is cheaply left out, as a box of the
        duals would have it. The linear programme is left as it was.
        """
        lp, index = self._lp, np.arange(self._first, self._first + len(self.columns), dtype=np.int32)
        integer, continuous = (np.full(index.size, kind) for kind in (1, 0))
        slack, dear = np.arange(1, self._first, dtype=np.int32), max((c.cost for c in self.columns), default=1.0)
        lp.changeColsCost(slack.size, slack, np.full(slack.size, dear))
        lp.changeColsIntegrality(index.size, index, integer.astype(np.uint8))
        lp.setOptionValue("time_limit", time)  # of a branch and bound it is its own, not one of all runs
        lp.setOptionValue("mip_max_nodes", nodes)
        lp.run()
        found = lp.getInfo().primal_solution_status == highspy.SolutionStatus.kSolutionStatusFeasible
        weight = np.asarray(lp.getSolution().col_value)[self._first :].copy() if found else np.zeros(0)
        lp.changeColsIntegrality(index.size, index, continuous.astype(np.uint8))
        lp.changeColsCost(slack.size, slack, self.centre + self.half)
        return [self.columns[int(p)] for p in np.flatnonzero(weight > 0.5)]

    @property
    def penalised(self) -> bool:
        """Whether the box of the duals binds: then the value says nothing about the relaxation."""
        return bool((np.asarray(self._lp.getSolution().col_value)[1 : self._first] > 1e-9).any())

    def widen(self, largest: float) -> bool:
        """Open the box of the duals where it binds, up to `largest` either way; return whether it did anywhere.

        After a few times everywhere: where one UAV sets the relaxation alone it would bind at one task after the other.
        """
        slack = np.asarray(self._lp.getSolution().col_value)[1 : self._first]
        held = (slack > 1e-9) & (self.half < largest)
        if not held.any():
            return False
        self._widened += 1
        self.half[held | (self._widened > _ONE_BY_ONE)] *= 2
        self.half = np.minimum(self.half, largest)
        box = np.arange(1, self._first, dtype=np.int32)
        self._lp.changeColsCost(box.size, box, self.centre + self.half)
        return True
