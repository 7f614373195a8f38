"""The linear relaxation of the paper's MILP: 0 ≤ θ_ijk ≤ 1 in place of θ_ijk ∈ {0, 1}, solved once, written in cvxpy.

Equations const1–const6 as in ``paper_model.py``. const6, in the stronger depot-linked form Σ_{i∉S,j∈S} θ_ijk ≥ y_vk,
has too many rows to write down: solve, separate (``separation.py``), add what is violated, until nothing is or time is
up.

The bound is not the LP solver's optimal value but the Lagrangian at its duals π, evaluated here:

    C_max ≥ min over 0 ≤ θ ≤ 1, 0 ≤ C_max ≤ U of  C_max + Σ_r π_r (lhs_r − rhs_r)      (const_r: lhs_r ≤ rhs_r or =)

which holds at *any* duals (those of ≤ rows taken as max(π, 0)), so that the solver's tolerances cannot spoil it. What
is left is the rounding of this one sum; 1e-9·U is subtracted for it, many times what it comes to. Arcs that cost more
than the routes known, U, are left out, so a bound above U means only that U is optimal: it is cut off there.

Where UAVs differ, C_k is summed over the costs of UAV k, and where its endurance is limited, C_k ≤ L_k is one row more.

The bound is weak, since a tour may be shared out evenly over the UAVs; the paper's reader expects it all the same.
"""

from __future__ import annotations

import math
import time
import warnings
from dataclasses import dataclass
from typing import Any

import cvxpy
import numpy as np
from cvxpy.constraints.zero import Equality
from scipy.sparse import csr_array, vstack

from formulations.routing.separation import subtours
from formulations.routing.simple_bounds import least_costs
from instances import Instance
from instances.arrays import Floats
from instances.routes import ENDURANCE_ROUNDING

cp: Any = cvxpy  # mypy does not see the names cvxpy makes as it is imported

_LEAST = 1e-3  # violation of a cut worth adding
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Relaxed:
    """The relaxation solved.

    bound [s] : a valid lower bound on the longest tour; 0 where not even the first round ended in time.
    theta : θ_ijk of each UAV, shape (m, n+1, n+1), its depot last.
    rounds, cuts : how often it was solved, and with how many rows of const6 in the end.
    complete : whether no cut is violated any more.
    """

    bound: float
    theta: Floats
    rounds: int
    cuts: int
    complete: bool


def relax(instance: Instance, upper: float, time_limit: float = math.inf) -> Relaxed:
    """Solve the linear relaxation; `upper` [s] > 0 is the cost of routes known, or one that no routes pass."""
    return _Relaxation(instance, upper).solve(time.perf_counter() + time_limit)


class _Relaxation:
    """The relaxation in the paper's symbols; costs in units of `upper`."""

    def __init__(self, instance: Instance, upper: float) -> None:
        self.upper, self.n = upper, instance.n_tasks
        n, self.D = instance.n_tasks, range(instance.n_depots)
        nodes = [np.array([*instance.tasks, n + k]) for k in self.D]
        costs, uavs = least_costs(instance)
        c = [np.minimum(costs[uavs[k]][np.ix_(at, at)] / upper, 2.0) for k, at in enumerate(nodes)]
        L = instance.limits * (1 + ENDURANCE_ROUNDING) / upper
        self.usable = [(c[k] <= 1 + _ROUNDING) & ~np.eye(n + 1, dtype=bool) for k in self.D]

        self.theta = [cp.Variable((n + 1, n + 1), nonneg=True) for _ in self.D]
        self.C_max = cp.Variable(nonneg=True)
        theta, C_max = self.theta, self.C_max
        C = [cp.sum(cp.multiply(c[k], theta[k])) for k in self.D]  # costsum
        y = [cp.sum(theta[k][:, :n], axis=0) for k in self.D]
        self.constraints = [sum(y) == 1]  # const1
        for k in self.D:
            self.constraints += [
                y[k] - cp.sum(theta[k][:n, :], axis=1) == 0,  # const2
                cp.sum(theta[k][n, :n]) <= 1,  # const3
                cp.sum(theta[k][n, :n]) - cp.sum(theta[k][:n, n]) == 0,  # const4
                C[k] <= C_max,  # const5
            ]
        self.constraints += [C[k] <= L[k] for k in self.D if L[k] < 1]
        self.no_loops = [cp.multiply(~self.usable[k], theta[k]) == 0 for k in self.D]
        self.cuts: list[list[csr_array]] = [[] for _ in self.D]

    def solve(self, end: float) -> Relaxed:
        """Solve, separate and solve again until `end` (by the clock of time.perf_counter)."""
        bound, rounds, complete = 0.0, 0, False
        theta = np.zeros((len(self.D), self.n + 1, self.n + 1))
        while not complete and (remaining := end - time.perf_counter()) > 0:
            constraints = self.constraints + self.const6()
            problem = cp.Problem(cp.Minimize(self.C_max), constraints + self.no_loops)
            limit = {"time_limit": remaining} if math.isfinite(remaining) else {}
            try:
                with warnings.catch_warnings(action="ignore"):  # of a limit hit, NaN and all: seen in the status
                    problem.solve(solver=cp.HIGHS, **limit)
            except cp.SolverError:
                break
            if problem.status != cp.OPTIMAL:
                break
            rounds += 1
            theta = np.array([variable.value for variable in self.theta])
            bound = max(bound, self.lagrangian(constraints))
            complete = not self.separate(theta)
        value = min(bound, 1.0) * self.upper
        return Relaxed(value, theta, rounds, sum(map(len, self.cuts)), complete)

    def const6(self) -> list[Any]:
        """Return eq. const6, depot-linked, for the sets found so far: y_vk − Σ_{i∉S,j∈S} θ_ijk ≤ 0."""
        return [vstack(rows) @ cp.vec(self.theta[k], order="C") <= 0 for k, rows in enumerate(self.cuts) if rows]

    def separate(self, theta: Floats) -> bool:
        """Add the cuts that θ violates; return whether there are any."""
        before = sum(map(len, self.cuts))
        for k in self.D:
            sets, visited = subtours(np.maximum(theta[k], 0.0), _LEAST)
            for S, v in zip(np.pad(sets, ((0, 0), (0, 1))), visited, strict=True):
                row = np.zeros((self.n + 1, self.n + 1))
                row[:, v] = 1.0
                row -= np.outer(~S, S)
                self.cuts[k].append(csr_array(row.reshape(1, -1)))
        return sum(map(len, self.cuts)) > before

    def lagrangian(self, constraints: list[Any]) -> float:
        """Return the bound at the duals of `constraints`, in units of `upper`."""
        terms = [self.C_max]
        for row in constraints:
            price = row.dual_value if isinstance(row, Equality) else np.maximum(row.dual_value, 0.0)
            terms.append(cp.sum(cp.multiply(price, row.expr)))
        lagrangian: Any = sum(terms)
        for variable in (*self.theta, self.C_max):
            variable.value = np.zeros(variable.shape)
        slope = lagrangian.grad
        value = float(lagrangian.value) + min(0.0, float(slope[self.C_max].sum()))
        for k in self.D:
            reduced = slope[self.theta[k]].toarray().reshape((self.n + 1, self.n + 1), order="F")
            value += float(np.minimum(reduced, 0.0)[self.usable[k]].sum())
        return value - _ROUNDING
