r"""The linear programme of a case over arcs, solved warm by HiGHS from case to case.

    min z   Σ_k Σ_i θ_ijk + s_j = 1                      every task j                       (paper, const1)
            Σ_i θ_ijk − Σ_i θ_jik = 0                    every task j and UAV k, dual w_k(j)        (const2)
            Σ_i θ_kik − Σ_i θ_ikk = 0                    every UAV k, dual −w_k(k)                  (const4)
            Σ_i θ_kik ≤ 1                                every UAV k, dual u_k                      (const3)
            Σ c_ijk θ_ijk ≤ z,  ≤ L_k                    every UAV k, duals −σ_k, −λ_k     (const5, endurance)
            Σ_{i∉S,j∈S} θ_ijk ≥ Σ_i θ_ivk                cuts (k, S, v), dual μ                     (const6)
            Σ_k Σ_{ij∈e} θ_ijk ≥ 1                       arcs e of which the case needs one, dual ρ
            Σ_k Σ_ij a_ij θ_ijk ≥ b                      cuts of all UAVs, dual ν                   (`joint.py`)

Arcs are priced: the nearest first, then what has a negative reduced cost. s keeps it feasible while arcs are missing,
and one more such column in the rows of needs and of sets to be entered twice. Its value is no bound: that comes of its
duals (`lagrangian.py`).
"""

from __future__ import annotations

import highspy
import numpy as np
from numpy.typing import NDArray

from formulations.routing.arcs.blossoms import blossoms
from formulations.routing.arcs.case import Arcs, Case
from formulations.routing.arcs.crowds import Crowds
from formulations.routing.arcs.joint import Crowd, Joint
from formulations.routing.arcs.lagrangian import ArcPrices, Cuts, bound_at, reduced_costs
from formulations.routing.separation import subtours, two_cycles
from instances.arrays import Bools, Floats, Ints

_NEAREST = 7
"""Arcs into and out of each node to begin with, for each UAV."""
_DEAR, _DEARER, _DEAREST = 10.0, 100.0, 1e5
"""What it costs to leave out a task, or a need, in longest tours; how many times as much where some is; and at most."""
_LEFT_OUT = 1e-9
"""Share of a task, or of a need, that counts as left out."""
_LEAST = 0.02
"""Violation of a cut worth adding."""
_CHEAP = 1e-7
"""Reduced cost below minus which an arc is added."""
_NEW = 2
"""Arcs added at once, for each node."""
_SLACK, _SPARE = 1e-6, 100
"""A cut looser than that, and unpaid, may go; how many of these, and half of all, are kept."""
_PIVOTS = 5000
"""Pivots after which HiGHS begins anew from where it is, as it may stall (one ran 40 s, ended in 0.4 s so); the next
time twice as many, as it may have needed them."""
_INFINITY = highspy.kHighsInf


class Programme:
    """The programme of the case it was last told of (`enter`).

    cost (m, n + 1, n + 1), limits (m,) : c_ijk, infinite where there is no arc, and L_k, infinite where there is none,
        in units of U; the depot is the last node of each UAV.
    case : that one; cuts : the cuts in the programme; uav, tail, head : its arcs, (a,).
    joint : whether cuts of all UAVs are looked for.
    value : of the programme as last solved, in units of U; theta (m, n + 1, n + 1) : θ of its arcs.
    prices, reduced, bound : its duals, the reduced costs of all arcs at these and the bound of the case, the same.
    """

    def __init__(self, cost: Floats, limits: Floats, *, joint: bool = True) -> None:
        self.cost, self.limits, self.joint = cost, limits, joint
        self.m, self.n = cost.shape[0], cost.shape[1] - 1
        m, n = self.m, self.n
        self.cuts = Cuts.none(n)
        self.uav = self.tail = self.head = np.zeros(0, np.int64)
        self._known = ~np.isfinite(cost)
        self._crowds = Crowds(cost, limits)
        self._lost = np.zeros_like(self._known)
        lp = self._lp = highspy.Highs()
        for option, value in (("output_flag", False), ("threads", 1), ("random_seed", 0)):
            lp.setOptionValue(option, value)
        below = -_INFINITY
        rows = [(1.0, 1.0)] * n + [(0.0, 0.0)] * (m * n + m) + [(below, 1.0)] * m + [(below, 0.0)] * m
        rows += [(below, float(limit) if np.isfinite(limit) else _INFINITY) for limit in limits]
        for low, high in rows:
            lp.addRow(low, high, 0, np.array([], dtype=np.int32), np.array([]))
        self._own = [0, *np.cumsum([n, m * n, m, m, m, m]).tolist()]
        """Where each group of rows begins: entered, left, home, used, tours, endurance; then needs and cuts."""
        self._rows: list[Arcs | Joint | None] = []
        """What each row after these is: arcs of which one is needed, a cut of all UAVs, or the next of `cuts`."""
        lp.addCol(1.0, 0.0, _INFINITY, m, np.arange(self._own[4], self._own[5], dtype=np.int32), -np.ones(m))
        for i in range(n):
            lp.addCol(_DEAR, 0.0, _INFINITY, 1, np.array([i], dtype=np.int32), np.ones(1))
        lp.addCol(_DEAR, 0.0, _INFINITY, 0, np.array([], dtype=np.int32), np.array([]))
        self._first_arc = 2 + n
        self._add(np.argwhere(self._nearest() & ~self._known))
        self.case = Case.root(np.arange(m), n)
        self._dear, self._left_out = _DEAR, 0.0
        self.value, self.bound, self.theta = np.inf, -np.inf, np.zeros_like(cost)

    def _nearest(self) -> Bools:
        """Return the cheapest arcs into and out of each node, (m, n + 1, n + 1)."""
        nearest, nodes = np.zeros(self.cost.shape, np.bool_), np.arange(self.n + 1)
        for cost, part in zip(self.cost, nearest, strict=True):
            part[nodes[:, None], np.argsort(cost, axis=1, kind="stable")[:, :_NEAREST]] = True
            part[np.argsort(cost, axis=0, kind="stable")[:_NEAREST].T, nodes[:, None]] = True
        return nearest

    def _add(self, arcs: Ints) -> None:
        """Add arcs (a, 3): UAV, tail, head."""
        n, own = self.n, self._own
        charged = self._coefficients(*arcs.T)
        lp, rows_after = self._lp, own[-1]
        for (k, i, j), more in zip(arcs.tolist(), charged, strict=True):
            rows, entries = [own[4] + k], [float(self.cost[k, i, j])]
            if np.isfinite(self.limits[k]):
                rows, entries = [*rows, own[5] + k], entries * 2
            rows += [j, own[1] + k * n + j] if j < n else [own[2] + k]
            entries += [1.0, 1.0] if j < n else [-1.0]
            rows += [own[1] + k * n + i] if i < n else [own[2] + k, own[3] + k]
            entries += [-1.0] if i < n else [1.0, 1.0]
            at = np.flatnonzero(more)
            rows += (rows_after + at).tolist()
            entries += more[at].tolist()
            lp.addCol(0.0, 0.0, _INFINITY, len(rows), np.array(rows, dtype=np.int32), np.array(entries))
        self._known[tuple(arcs.T)] = True
        self.uav, self.tail, self.head = (
            np.concatenate(pair) for pair in zip((self.uav, self.tail, self.head), arcs.T, strict=True)
        )

    def _coefficients(self, uav: Ints, tail: Ints, head: Ints) -> Floats:
        """Return the entries of arcs in the rows after the first, (a, rows)."""
        entries = np.zeros((uav.size, len(self._rows)))
        entries[:, self._of_cuts()] = _in_cuts(self.cuts, uav, tail, head)
        for number, row in enumerate(self._rows):
            if row is not None:
                entries[:, number] = _in_row(row, tail, head)
        return entries

    def _of_cuts(self) -> list[bool]:
        """Say which of the rows are those of `cuts`."""
        return [row is None for row in self._rows]

    def _needs(self) -> dict[Arcs, int]:
        """Return arcs of which one is needed, each with its row."""
        return {row: number for number, row in enumerate(self._rows) if isinstance(row, tuple)}

    def _add_row(self, low: float, entries: Floats, row: Arcs | Joint | None) -> None:
        at = np.flatnonzero(entries)
        index, entries = self._first_arc + at, entries[at]
        if isinstance(row, tuple | Crowd):  # arcs alone need not be able to keep to it
            index, entries = np.append(index, self._first_arc - 1), np.append(entries, max(1.0, low))
        self._lp.addRow(low, _INFINITY, index.size, index.astype(np.int32), entries)
        self._rows.append(row)

    def _add_cuts(self, cuts: Cuts) -> None:
        for entries in _in_cuts(cuts, self.uav, self.tail, self.head).T:
            self._add_row(0.0, entries, None)
        self.cuts = self.cuts.and_also(cuts)

    def enter(self, case: Case) -> None:
        """Take up a case."""
        self.case, self._lost = case, case.lost_arcs()
        self._ask(_DEAR)
        index = self._first_arc + np.arange(self.uav.size)
        self._bound_arcs(index, self._lost[self.uav, self.tail, self.head])
        for arcs in case.needed:
            if arcs not in self._rows:
                self._add_row(-_INFINITY, _in_row(arcs, self.tail, self.head), arcs)
        for arcs, number in self._needs().items():
            low = 1.0 if arcs in case.needed else -_INFINITY
            self._lp.changeRowBounds(self._own[-1] + number, low, _INFINITY)

    def insist(self) -> bool:
        """Make it dearer to leave out a task, where some is left out, unless it is dear enough; say whether it was."""
        if self._left_out < _LEFT_OUT or self._dear >= _DEAREST:
            return False
        self._ask(self._dear * _DEARER)
        return True

    def _ask(self, price: float) -> None:
        """Ask a price for leaving out a task."""
        if price != self._dear:
            self._dear, index = price, np.arange(1, self._first_arc, dtype=np.int32)
            self._lp.changeColsCost(index.size, index, np.full(index.size, price))

    def _bound_arcs(self, index: Ints, lost: Bools) -> None:
        upper = np.where(lost, 0.0, _INFINITY)
        self._lp.changeColsBounds(index.size, index.astype(np.int32), np.zeros(index.size), upper)

    def solve(self, time: float = np.inf) -> bool:
        """Solve, and compute the bound at the duals; say whether that was done within `time` [s]."""
        lp, n, m = self._lp, self.n, self.m
        lp.setOptionValue("time_limit", lp.getRunTime() + time)
        pivots, status = _PIVOTS, highspy.HighsModelStatus.kIterationLimit
        while status == highspy.HighsModelStatus.kIterationLimit:
            lp.setOptionValue("simplex_iteration_limit", pivots)
            lp.run()
            pivots, status = min(2 * pivots, highspy.kHighsIInf), lp.getModelStatus()
        if status != highspy.HighsModelStatus.kOptimal:
            return False
        solution = lp.getSolution()
        self.value = float(lp.getInfo().objective_function_value)
        self.theta = np.zeros_like(self.cost)
        values = np.asarray(solution.col_value)
        self.theta[self.uav, self.tail, self.head] = np.maximum(values[self._first_arc :], 0.0)
        self._left_out = float(values[1 : self._first_arc].max())
        self._entered, left, home, used, tours, limited, others = np.split(np.asarray(solution.row_dual), self._own[1:])
        sigma, of_limits = np.maximum(-tours, 0.0), np.maximum(-limited, 0.0) * np.isfinite(self.limits)
        sigma /= max(1.0, float(sigma.sum()) * (1 + 1e-12))
        needs = self._needs()
        rho = np.array([max(others[needs[arcs]], 0.0) for arcs in self.case.needed])
        mu = np.maximum(others[self._of_cuts()], 0.0)
        potential = np.column_stack([left.reshape(m, n), -home])
        paid, of_uavs = mu > 0, (sigma, of_limits, potential, np.minimum(used, 0.0))
        joint = {row: nu for row, nu in zip(self._rows, others, strict=True) if isinstance(row, Joint) and nu > 0}
        nu = np.array(list(joint.values()))
        self.prices = ArcPrices(*of_uavs, self.cuts.of(paid), mu[paid], rho, tuple(joint), nu)
        self.reduced = reduced_costs(self.prices, self.cost, self.case)
        self.bound = bound_at(self.prices, self.reduced, self.limits, self._lost)
        return True

    def grow(self) -> bool:
        """Add arcs of negative reduced cost; say whether there were any."""
        reduced = self.reduced.copy()
        reduced[:, :, : self.n] -= self._entered
        arcs = np.argwhere((reduced < -_CHEAP) & ~self._known & ~self._lost)
        if arcs.size:
            order = np.argsort(reduced[tuple(arcs.T)], kind="stable")
            self._add(arcs[order[: _NEW * (self.n + 1)]])
        return arcs.size > 0

    def cut(self, cap: float) -> int:
        """Add the cuts that θ violates and return how many: of two tasks, else of more, else of all UAVs together.

        cap : what routes may cost that these must not cut off, in units of U.
        """
        found = 0
        for k, theta in enumerate(self.theta):
            sets, visited = two_cycles(theta, _LEAST)
            if not len(sets):
                sets, visited = subtours(theta, _LEAST)
            tasks = np.pad(sets, ((0, 0), (0, 1)))
            self._add_cuts(Cuts(np.full(len(sets), k), tasks, visited.astype(np.int64)))
            found += len(sets)
        if found or not self.joint:
            return found
        together = self.theta.sum(axis=0)
        joint: list[Joint] = [*self._crowds.cuts(together, cap, _LEAST), *blossoms(together, _LEAST)]
        for cut in joint:
            self._add_row(cut.least, _in_row(cut, self.tail, self.head), cut)
        return len(joint)

    def forget(self) -> None:
        """Drop cuts that nothing pays for, and needs that the case does not need, where they have become many."""
        solution = self._lp.getSolution()
        dual, value = (np.asarray(part)[self._own[-1] :] for part in (solution.row_dual, solution.row_value))
        if dual.size != len(self._rows):
            return
        least = np.array([row.least if isinstance(row, Joint) else 0.0 for row in self._rows])
        loose = (dual <= 0) & (value > least + _SLACK)
        spare = [
            row in self.case.needed if isinstance(row, tuple) else not of_row
            for row, of_row in zip(self._rows, loose, strict=True)
        ]
        drop = np.flatnonzero(~np.array(spare, dtype=np.bool_))
        if drop.size <= _SPARE + len(self._rows) / 2:
            return
        self._lp.deleteRows(drop.size, (self._own[-1] + drop).astype(np.int32))
        self.cuts = self.cuts.of(np.array(spare)[self._of_cuts()])
        self._rows = [row for row, kept in zip(self._rows, spare, strict=True) if kept]

    def trial(self, case: Case, pivots: int) -> float:
        """Return what a few pivots raise the value to in a case after this one; leave everything as it was."""
        lp, basis, rows = self._lp, self._lp.getBasis(), len(self._rows)
        arcs = self._lost[self.uav, self.tail, self.head]
        changed = np.flatnonzero(case.lost_arcs()[self.uav, self.tail, self.head] & ~arcs)
        self._bound_arcs(self._first_arc + changed, np.ones(changed.size, np.bool_))
        for needed in case.needed[len(self.case.needed) :]:
            self._add_row(1.0, _in_row(needed, self.tail, self.head), needed)
        lp.setOptionValue("simplex_iteration_limit", pivots)
        lp.setOptionValue("time_limit", _INFINITY)
        lp.run()
        value = float(lp.getInfo().objective_function_value)
        lp.setOptionValue("simplex_iteration_limit", highspy.kHighsIInf)
        self._bound_arcs(self._first_arc + changed, np.zeros(changed.size, np.bool_))
        if len(self._rows) > rows:
            added = np.arange(rows, len(self._rows), dtype=np.int32) + self._own[-1]
            lp.deleteRows(added.size, added.astype(np.int32))
            del self._rows[rows:]
        lp.setBasis(basis)
        return value


def _in_cuts(cuts: Cuts, uav: Ints, tail: Ints, head: Ints) -> Floats:
    """Return the entries of arcs in cuts, (a, c)."""
    entering = cuts.tasks[:, head] & ~cuts.tasks[:, tail]
    entries = entering.astype(float) - (cuts.visited[:, None] == head)
    return np.ascontiguousarray((entries * (cuts.uav[:, None] == uav)).T)


def _in_row(row: Arcs | Joint, tail: Ints, head: Ints) -> NDArray[np.float64]:
    """Return the entries of arcs in the row of those of which one is needed, or of a cut of all UAVs, (a,)."""
    if isinstance(row, tuple):
        return np.any([(tail == i) & (head == j) for i, j in row], axis=0).astype(float)
    return row.entries[tail, head].astype(float)
