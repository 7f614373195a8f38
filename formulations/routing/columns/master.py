"""The restricted master: the linear programme over the tours known so far, re-solved warm by HiGHS.

    min z + Σ_i w_i (s_i + t_i)
    Σ_k Σ_p a_ip λ_p + s_i − t_i = 1        task i        dual π_i, held within ±w_i
    Σ_p c_p λ_p − z ≤ 0                     UAV k         dual −σ_k
    Σ_p λ_p ≤ 1                             UAV k         dual −μ_k
    Σ_k Σ_p ⌊|S ∩ p|/2⌋ λ_p ≤ 1             cut S         dual −ρ_S

(paper, eqs. c_max, const1, const3 and const5 with whole tours as variables). s and t keep it feasible, and the duals of
a poor set of columns in a box, which `widen` opens where it binds (du Merle et al. 1999). Its value is no bound: bounds
come from `pricing`, at the duals found here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import highspy
import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.cuts import Cut
from formulations.routing.columns.pricing import Column, Duals
from instances.arrays import Bools, Floats

_SIMPLEX = 0  # primal where the basis is primal feasible, as it is after new columns: thrice as fast as always dual
_SHY = 1 - 1e-14  # keeps Σσ ≤ 1 in exact arithmetic


class Optimum(NamedTuple):
    """The master solved: its `value` [s], the `duals` (σ ≥ 0 scaled to Σσ = 1) and `weight`, λ of the columns."""

    value: float
    duals: Duals
    weight: Floats


class Master:
    """A growing linear programme over columns and cuts.

    penalty : half width of the box the duals of the tasks begin in [s], one for all or (n,).
    """

    def __init__(self, n_tasks: int, n_uavs: int, penalty: float | Floats, cuts: Sequence[Cut] = ()) -> None:
        self.n, self.m = n_tasks, n_uavs
        self.columns: list[Column] = []
        self.cuts: list[Cut] = []
        self.penalty = np.tile(np.broadcast_to(penalty, n_tasks), 2)
        self._known: dict[tuple[int, frozenset[int]], int] = {}
        self._first = 1 + 2 * n_tasks
        self._lp = lp = highspy.Highs()
        settings = (("output_flag", False), ("threads", 1), ("random_seed", 0), ("simplex_strategy", _SIMPLEX))
        for option, value in settings:
            lp.setOptionValue(option, value)
        empty = np.array([], dtype=np.int32), np.array([])
        for row in range(n_tasks + 2 * n_uavs):
            lower = 1.0 if row < n_tasks else -highspy.kHighsInf
            upper = 0.0 if n_tasks <= row < n_tasks + n_uavs else 1.0
            lp.addRow(lower, upper, 0, *empty)
        costs = np.arange(n_tasks, n_tasks + n_uavs, dtype=np.int32)
        lp.addCol(1.0, 0.0, highspy.kHighsInf, n_uavs, costs, np.full(n_uavs, -1.0))
        for i in range(2 * n_tasks):
            sign = np.array([1.0 if i < n_tasks else -1.0])
            lp.addCol(float(self.penalty[i]), 0.0, highspy.kHighsInf, 1, np.array([i % n_tasks], dtype=np.int32), sign)
        self.cut_off(cuts)

    def add(self, columns: Sequence[Column]) -> int:
        """Add those columns that are new, or cheaper than the known one over the same tasks; return how many."""
        new = []
        for column in columns:
            key = (column.uav, frozenset(column.tasks))
            known = self._known.get(key)
            if known is None or column.cost < self.columns[known].cost:
                self._known[key] = len(self.columns)
                self.columns.append(column)
                new.append(column)
        if new:
            rows, values = zip(*(self._entries(c) for c in new), strict=True)
            start = np.cumsum([0] + [part.size for part in rows[:-1]], dtype=np.int32)
            zeros, size = np.zeros(len(new)), int(sum(part.size for part in rows))
            self._lp.addCols(
                len(new), zeros, zeros, np.full(len(new), highspy.kHighsInf), size, start,
                np.concatenate(rows), np.concatenate(values),
            )  # fmt: skip
        return len(new)

    def _entries(self, column: Column) -> tuple[NDArray[np.int32], Floats]:
        rows = [*sorted(column.tasks), self.n + column.uav, self.n + self.m + column.uav]
        values = [1.0] * len(column.tasks) + [column.cost, 1.0]
        held = set(column.tasks)
        for q, cut in enumerate(self.cuts):
            if len(held.intersection(cut)) >= 2:
                rows.append(self.n + 2 * self.m + q)
                values.append(1.0)
        return np.array(rows, dtype=np.int32), np.array(values)

    def cut_off(self, cuts: Sequence[Cut]) -> None:
        """Add subset-row cuts."""
        sets = [set(c.tasks) for c in self.columns]
        for cut in cuts:
            index = [self._first + p for p, held in enumerate(sets) if len(held.intersection(cut)) >= 2]
            self._lp.addRow(-highspy.kHighsInf, 1.0, len(index), np.array(index, dtype=np.int32), np.ones(len(index)))
            self.cuts.append(cut)

    def solve(self) -> Optimum:
        """Solve the linear programme over the columns known."""
        self._lp.run()
        solution = self._lp.getSolution()
        price, sigma, rent, rho = np.split(np.asarray(solution.row_dual), np.cumsum([self.n, self.m, self.m]))
        sigma, rent, rho = np.maximum(0.0, -sigma), np.maximum(0.0, -rent), np.maximum(0.0, -rho)
        total = float(sigma.sum())
        sigma = sigma / total * _SHY if total > 0 else np.full(self.m, _SHY / self.m)
        duals = Duals(price.copy(), sigma, rent, rho, tuple(self.cuts))
        weight = np.asarray(solution.col_value)[self._first :].copy()
        return Optimum(float(self._lp.getInfo().objective_function_value), duals, weight)

    def without(self, dropped: Bools, pivots: int) -> float:
        """Return what a few pivots raise the solved master's value to [s] without some columns.

        Columns and basis are back afterwards, so that the next trial starts as near to its optimum as this one.
        """
        lp, basis = self._lp, self._lp.getBasis()
        index = (self._first + np.flatnonzero(dropped)).astype(np.int32)
        zeros = np.zeros(index.size)
        lp.changeColsBounds(index.size, index, zeros, zeros)
        lp.setOptionValue("simplex_iteration_limit", pivots)
        lp.run()
        value = float(lp.getInfo().objective_function_value)
        lp.setOptionValue("simplex_iteration_limit", highspy.kHighsIInf)
        lp.changeColsBounds(index.size, index, zeros, np.full(index.size, highspy.kHighsInf))
        lp.setBasis(basis)
        return value

    def whole(self, time: float, nodes: int = 100) -> list[Column]:
        """Return the best whole tours among the columns known, by a short branch and bound in HiGHS; none if not found.

        Only a heuristic: the caller checks what the tours visit. The linear programme is left as it was.
        """
        lp, index = self._lp, np.arange(self._first, self._first + len(self.columns), dtype=np.int32)
        integer, continuous = (np.full(index.size, kind) for kind in (1, 0))
        lp.changeColsIntegrality(index.size, index, integer.astype(np.uint8))
        lp.setOptionValue("time_limit", time)
        lp.setOptionValue("mip_max_nodes", nodes)
        lp.run()
        found = lp.getInfo().primal_solution_status == highspy.SolutionStatus.kSolutionStatusFeasible
        weight = np.asarray(lp.getSolution().col_value)[self._first :].copy() if found else np.zeros(0)
        lp.changeColsIntegrality(index.size, index, continuous.astype(np.uint8))
        lp.setOptionValue("time_limit", highspy.kHighsInf)
        return [self.columns[int(p)] for p in np.flatnonzero(weight > 0.5)]

    @property
    def penalised(self) -> bool:
        """Whether the box of the duals binds: then the value says nothing about the relaxation."""
        return bool((np.asarray(self._lp.getSolution().col_value)[1 : self._first] > 1e-9).any())

    def widen(self, largest: float) -> bool:
        """Open the box of the duals where it binds, up to ±`largest`; return whether it did anywhere."""
        slack = np.asarray(self._lp.getSolution().col_value)[1 : self._first]
        held = np.flatnonzero((slack > 1e-9) & (self.penalty < largest))
        self.penalty[held] = np.minimum(2 * self.penalty[held], largest)
        for i in held:
            self._lp.changeColCost(1 + int(i), float(self.penalty[i]))
        return held.size > 0
