"""The restricted master: the linear programme of `duals.py` over the tours known so far, re-solved warm by HiGHS.

A task that must be visited (lo_i = 1) may be missed at a price, so that the programme always has a solution. Its value
is no bound: bounds come from `Duals.bound`, at the duals found here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import highspy
import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.cuts import Cut
from formulations.selection.duals import Column, Duals
from formulations.selection.overestimates import Overestimate
from formulations.selection.worth import Worth
from instances.arrays import Floats

_INFINITY = highspy.kHighsInf


class Optimum(NamedTuple):
    """The master solved: its `value`, `duals`, λ of the columns in `weight`, and `y` (n,)."""

    value: float
    duals: Duals
    weight: Floats
    y: Floats


class Master:
    """A growing linear programme over columns, cuts and overestimates.

    counts : m_g of each group; lo, hi : bounds of y (n,); missing : price of missing a task that must be visited.
    worth : subadditive worth that bounds θ by the tours as well, or None.
    """

    def __init__(
        self, counts: Sequence[int], lo: Floats, hi: Floats, missing: float, worth: Worth | None = None
    ) -> None:
        self.n, self.groups = lo.size, len(counts)
        self.columns: list[Column] = []
        self._known: set[Column] = set()
        self.overestimates: list[Overestimate] = []
        self._cuts: list[Cut] = []
        self._over_rows: list[int] = []
        self._cut_rows: list[int] = []
        self._tour_row: int | None = None
        self._worth = worth
        self._lp = lp = highspy.Highs()
        for option, value in (("output_flag", False), ("threads", 1), ("random_seed", 0)):
            lp.setOptionValue(option, value)
        empty = np.array([], dtype=np.int32), np.array([])
        for _ in range(self.n):
            lp.addRow(0.0, 0.0, 0, *empty)
        for count in counts:
            lp.addRow(-_INFINITY, float(count), 0, *empty)
        lp.addCol(-1.0, -_INFINITY, _INFINITY, 0, *empty)  # θ
        for i in range(self.n):
            lp.addCol(0.0, float(lo[i]), float(hi[i]), 1, np.array([i], dtype=np.int32), np.array([-1.0]))
        for i in range(self.n):
            lp.addCol(missing, 0.0, float(lo[i]), 1, np.array([i], dtype=np.int32), np.array([1.0]))
        self._first = 1 + 2 * self.n
        if worth is not None:
            self._tour_row = lp.getNumRow()
            lp.addRow(-_INFINITY, 0.0, 1, np.array([0], dtype=np.int32), np.ones(1))

    def add(self, columns: Sequence[Column]) -> int:
        """Add those columns that are new; return how many."""
        new = [c for c in dict.fromkeys(columns) if c not in self._known]
        if new:
            self._known.update(new)
            self.columns += new
            rows, values = zip(*(self._entries(column) for column in new), strict=True)
            start = np.cumsum([0] + [part.size for part in rows[:-1]], dtype=np.int32)
            zeros, size = np.zeros(len(new)), int(sum(part.size for part in rows))
            upper, entries = np.full(len(new), _INFINITY), (np.concatenate(rows), np.concatenate(values))
            self._lp.addCols(len(new), zeros, zeros, upper, size, start, *entries)
        return len(new)

    def _entries(self, column: Column) -> tuple[NDArray[np.int32], Floats]:
        held = set(column.tasks)
        paid = [row for cut, row in zip(self._cuts, self._cut_rows, strict=True) if len(held.intersection(cut)) >= 2]
        rows, values = [*sorted(held), self.n + column.group, *paid], [1.0] * (len(held) + 1 + len(paid))
        if self._worth is not None and self._tour_row is not None:
            rows.append(self._tour_row)
            values.append(-self._worth.value(column.tasks))
        return np.array(rows, dtype=np.int32), np.array(values)

    def cut_off(self, cuts: Sequence[Cut]) -> None:
        """Add subset-row cuts."""
        sets = [set(c.tasks) for c in self.columns]
        for cut in cuts:
            index = [self._first + p for p, held in enumerate(sets) if len(held.intersection(cut)) >= 2]
            self._cut_rows.append(self._lp.getNumRow())
            self._lp.addRow(-_INFINITY, 1.0, len(index), np.array(index, dtype=np.int32), np.ones(len(index)))
            self._cuts.append(cut)

    def overestimate(self, overestimates: Sequence[Overestimate]) -> None:
        """Add overestimates of the worth."""
        index = np.arange(1 + self.n, dtype=np.int32)
        for over in overestimates:
            self._over_rows.append(self._lp.getNumRow())
            self._lp.addRow(-_INFINITY, over.constant, index.size, index, np.concatenate([[1.0], -over.slope]))
            self.overestimates.append(over)

    def solve(self) -> Optimum:
        """Solve the linear programme over the columns known."""
        self._lp.run()
        solution = self._lp.getSolution()
        row, col = np.asarray(solution.row_dual), np.asarray(solution.col_value)
        alpha = np.maximum(0.0, -row[self._over_rows])
        rent = np.maximum(0.0, -row[self.n : self.n + self.groups])
        rho = np.maximum(0.0, -row[self._cut_rows]) if self._cut_rows else np.zeros(0)
        beta = 0.0 if self._tour_row is None else max(0.0, -float(row[self._tour_row]))
        total = float(alpha.sum()) + beta
        alpha, beta = (alpha / total, beta / total) if total > 0 else (np.full(alpha.size, 1 / alpha.size), 0.0)
        lists = tuple(self.overestimates), tuple(self._cuts)
        duals = Duals(row[: self.n].copy(), alpha, rent, rho, *lists, beta)
        value = -float(self._lp.getInfo().objective_function_value)
        return Optimum(value, duals, col[self._first :].copy(), col[1 : 1 + self.n].copy())

    @property
    def missed(self) -> bool:
        """Whether a task that must be visited is missed in the last solution."""
        values = np.asarray(self._lp.getSolution().col_value)
        return bool((values[1 + self.n : self._first] > 1e-6).any())
