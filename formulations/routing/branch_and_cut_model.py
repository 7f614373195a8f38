"""The paper's MILP in SCIP: θ, C_max and eqs. const1–const5, all but the subtour cuts (const6).

The equations stand in ``paper_model.py``. As there, θ_ijk exists only for arcs that UAV k can use, and y_ik, 1 where
UAV k visits task i, is a variable, so that SCIP can branch on it and cuts can be written in it.

Costs are multiplied by a power of two, which is exact, so that the routes known cost between 512 and 1024: SCIP's
tolerances are meant for numbers of that size. An arc that costs more than those routes alone is left out, and so is
one that its UAV cannot fly. Where endurance is limited there is a row C_k ≤ L_k, looser than that by twice SCIP's own
tolerance: no tour that UAV k can fly is cut off, and no proof that there are no routes hangs by it. The tours between
are refused by the constraint handler.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from pyscipopt import Model, Variable, quicksum
from pyscipopt.scip import Solution

from formulations.routing.simple_bounds import ways_between_tasks, ways_from_depot
from formulations.routing.subtours import Arc
from formulations.routing.symmetries import in_order, is_symmetric, neighbours, used_arcs
from instances import Instance, Routes, makespan
from instances.arrays import Bools
from instances.routes import ENDURANCE_ROUNDING

_BITS = 10  # the incumbent costs less than 2^10 in SCIP's unit
_ROUNDING = 1e-9
FEASTOL, DUALFEASTOL = 1e-6, 1e-7


class ScipModel:
    """θ, y, C_max and eqs. const1–const5 of one instance below the cost of routes known.

    scip : the model.
    limits : the longest tour of each UAV in SCIP's unit, (m,): `upper`, or what its endurance allows and a little.
    theta : per UAV (0..m−1), arc → θ_ijk; node numbers as in the instance.
    slack : by how much SCIP's dual bound can be too high, in its unit (``branch_and_cut.py``).
    y : ``y[i, k]``, UAV k (node number) visits task i.
    exponent : a cost in SCIP is 2^exponent times that in seconds.
    """

    def __init__(self, instance: Instance, incumbent: float, *, reach: bool, arcs: Bools | None = None) -> None:
        self.instance = instance
        self.exponent = min(_BITS - math.frexp(incumbent)[1], 1000)
        self.upper = math.ldexp(incumbent, self.exponent) * (1 + _ROUNDING)
        self.slack = FEASTOL * self.upper + (instance.n_nodes + 1) * DUALFEASTOL
        costs = np.ldexp(np.minimum(instance.class_costs, 2.0 * incumbent), self.exponent)
        self.T, self.D = instance.tasks, instance.depots
        self.cost = {k: costs[g] for k, g in zip(self.D, instance.classes, strict=True)}
        endurance = np.minimum(instance.limits * (1 + ENDURANCE_ROUNDING), 2.0 * incumbent)
        self.limits = np.minimum(np.ldexp(endurance, self.exponent) + 2 * self.slack, self.upper)
        self.scip = Model("MMMDMTSP")
        self.scip.hideOutput()
        between = [ways_between_tasks(cost, instance.n_tasks) for cost in costs]
        self.ways = {
            k: ways_from_depot(self.cost[k], between[g], k) for k, g in zip(self.D, instance.classes, strict=True)
        }
        self.theta: list[dict[Arc, Variable]] = [
            {(i, j): self.scip.addVar(f"theta_{i}_{j}_{k}", "B") for i, j in self.edges(k, reach, arcs)} for k in self.D
        ]
        self.y = {(i, k): self.scip.addVar(f"y_{i}_{k}", "B") for i in self.T for k in self.D}
        self.C_max = self.scip.addVar("C_max", lb=0.0, ub=self.upper)
        self.scip.setObjective(self.C_max)
        for k, theta in zip(self.D, self.theta, strict=True):
            out, back = self.sum_theta(k, ((k, i) for i in self.T)), self.sum_theta(k, ((i, k) for i in self.T))
            self.scip.addCons(out <= 1, "const3")
            self.scip.addCons(out - back == 0, "const4")
            tour = quicksum(self.cost[k][arc] * v for arc, v in theta.items())
            self.scip.addCons(tour <= self.C_max, "const5")
            if self.limit(k) < self.upper:
                self.scip.addCons(tour <= self.limit(k), "endurance")
            for i in self.T:
                self.const2(i, k)
        for i in self.T:
            self.scip.addCons(quicksum(self.y[i, k] for k in self.D) == 1, "const1")
        if reach:
            self.reach()

    def edges(self, k: int, reach: bool, arcs: Bools | None) -> list[Arc]:
        """Return the arcs of E that UAV k can use within the cost of the routes known and its endurance.

        reach : count the cheapest ways to the arc and back too, not the arc alone; arcs (N, N) : those to choose from.
        """
        n = self.instance.n_tasks
        out, back = (np.append(way, 0.0) if reach else np.zeros(n + 1) for way in self.ways[k])
        nodes = np.array([*self.T, k])
        length = out[:, None] + self.cost[k][np.ix_(nodes, nodes)] + back[None, :]
        np.fill_diagonal(length, np.inf)
        used = length <= self.limit(k)
        if arcs is not None:
            used &= arcs[np.ix_(nodes, nodes)]
        return [(int(nodes[i]), int(nodes[j])) for i, j in np.argwhere(used)]

    def limit(self, k: int) -> float:
        """Return the longest tour of the UAV at depot k in SCIP's unit."""
        return float(self.limits[k - self.instance.n_tasks])

    def sum_theta(self, k: int, arcs: Iterable[Arc]) -> Variable:
        """Return Σ θ_ijk over those of `arcs` that exist."""
        theta = self.theta[k - self.instance.n_tasks]
        return quicksum(theta[arc] for arc in arcs if arc in theta)

    def const2(self, i: int, k: int) -> None:
        """Eq. const2: a UAV leaves every task it enters; both are y_ik."""
        others = [k, *(j for j in self.T if j != i)]
        self.scip.addCons(self.sum_theta(k, ((j, i) for j in others)) == self.y[i, k], "visit")
        self.scip.addCons(self.sum_theta(k, ((i, j) for j in others)) == self.y[i, k], "const2")

    def reach(self) -> None:
        """C_max is at least the cheapest way to a task and back, of the UAV that visits it."""
        for i in self.T:
            away = quicksum((self.ways[k][0][i] + self.ways[k][1][i]) * self.y[i, k] for k in self.D)
            self.scip.addCons(away <= self.C_max, "reach")

    def symmetry(self) -> None:
        """Only routes as `in_order` has them: UAVs of one depot by their smallest task, symmetric tours one way."""
        for before, k in neighbours(self.instance):
            for i in self.T:
                self.scip.addCons(self.y[i, k] <= quicksum(self.y[j, before] for j in range(i)), "symmetry")
        if is_symmetric(self.instance):
            for k, theta in zip(self.D, self.theta, strict=True):
                ends = quicksum(i * v for (h, i), v in theta.items() if h == k)
                self.scip.addCons(ends <= quicksum(i * v for (i, h), v in theta.items() if h == k), "symmetry")

    def fill(self, solution: Solution, routes: Routes) -> None:
        """Write `routes` into a SCIP solution; raises KeyError where they use an arc that is left out."""
        n = self.instance.n_tasks
        routes = in_order(self.instance, routes)
        for i, j, k in used_arcs(self.instance, routes):
            self.scip.setSolVal(solution, self.theta[k - n][i, j], 1.0)
            if j != k:
                self.scip.setSolVal(solution, self.y[j, k], 1.0)
        longest = math.ldexp(makespan(self.instance, routes), self.exponent)
        self.scip.setSolVal(solution, self.C_max, min(longest * (1 + _ROUNDING / 2), self.upper))

    def seconds(self, cost: float) -> float:
        """Return a cost in SCIP in seconds."""
        return math.ldexp(cost, -self.exponent)
