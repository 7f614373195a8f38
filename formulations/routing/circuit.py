"""circuit: the MMMDMTSP with CP-SAT's circuit constraint instead of subtour cuts.

**One giant circuit** (the default; the best CP-SAT form measured). All tours in one circuit over tasks and depots,
D_1, tour of UAV 1, D_2, tour of UAV 2, …, back to D_1: the arc into the next depot is the return of the UAV before.

    x_ij ∈ {0, 1}   an arc of the circuit; no UAV index. add_circuit(x): one cycle through every node.
    y_ik ∈ {0, 1}   UAV k visits task i; Σ_k y_ik = 1.
                    x_ij ⇒ y_ik = y_jk (task to task);  x_{D_k} i ⇒ y_ik;  x_{i D_k+1} ⇒ y_ik
    t_i             when task i is reached [scaled s]: x_ij ⇒ t_j ≥ t_i + c_ij;  x_{D_k} i ⇒ t_i ≥ c_ki
    z               x_{i D_k+1} ⇒ z ≥ t_i + c_ik.   Minimise z.
    average         m·z ≥ Σ c_ij x_ij. Implied; the linear relaxation, where the rows of t vanish, needs it.

D_k → D_k+1 (UAV k stays home) is free: no cost between depots is ever used.

Where endurance is limited, x_{i D_k+1} ⇒ t_i + c_ik ≤ L_k. Tours too long by less than integers tell are cut off and
the search begun again.

**One circuit per UAV** (``per_uav``): θ_ijk as in the paper, add_circuit(θ_··k) with a loop at every node UAV k leaves
out, Σ_k y_ik = 1, C_k ≤ z, C_k ≤ L_k. Always so where UAVs differ: x does not say who flies an arc and so what it
costs; rows of t under x and y together prove in minutes what these do in a second (8 tasks, 3 speeds).

Each pair of nodes has one literal, because parallel arcs with time rows make add_multiple_circuit crash.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from ortools.sat.python import cp_model

from formulations.routing import cpsat
from formulations.routing.cpsat import Values
from formulations.routing.model_solver import ModelSolver, cutoff, too_long
from formulations.routing.paper_model import Theta
from formulations.routing.recorder import Recorder
from formulations.routing.scaling import ScaledCosts, scale_costs
from formulations.routing.solver import Result
from formulations.routing.strengthening import fly_one_way
from formulations.routing.subtours import walk
from formulations.routing.symmetries import in_order, is_symmetric, neighbours, used_arcs
from instances import Instance, Routes, as_routes

MOST_LITERALS = 150_000
"""Beyond this building the model alone takes a second and more; the proofs end far below (n ≈ 20)."""


@dataclass(frozen=True)
class Circuit(ModelSolver):
    """CP-SAT with circuit constraints; ``limits.iterations`` counts CP-SAT's conflicts.

    per_uav : one circuit per UAV instead of one giant circuit, also where UAVs are alike.
    symmetry : order UAVs that share a depot by their smallest task; with symmetric costs, fly each tour one way only.
    average : the longest tour is at least the mean of all (giant circuit only; one circuit per UAV implies it).
    """

    proves: ClassVar[bool] = True
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance"})

    per_uav: bool = False
    symmetry: bool = True
    average: bool = True

    def accepts(self, instance: Instance) -> str | None:
        """Return why the instance is too large, or None."""
        size = instance.n_tasks**2 * instance.n_depots
        return f"the model would have {size} clauses; it takes {MOST_LITERALS}" if size > MOST_LITERALS else None

    def improve(self, recorder: Recorder, seed: int) -> Result:
        """Solve in one search, or in several where a tour is too long by less than CP-SAT's integers can tell."""
        instance, limits = recorder.instance, recorder.limits
        scaled = scale_costs(instance, cutoff(recorder))
        apart = self.per_uav or len(scaled.costs) > 1
        form = CircuitPerUav(instance, scaled) if apart else GiantCircuit(instance, scaled, self.average)
        if self.symmetry:
            form.break_symmetry()
        beyond: set[tuple[int, tuple[int, ...]]] = set()

        def on_solution(value: Values) -> None:
            routes = form.routes(value)
            beyond.update((instance.depots[k], routes[k]) for k in too_long(instance, routes))
            recorder.incumbent(routes)

        while True:
            if recorder.routes is not None:
                form.hint(in_order(instance, recorder.routes) if self.symmetry else recorder.routes)
            beyond.clear()
            ending = cpsat.search(form.model, scaled, recorder, seed, on_solution, conflicts=limits.iterations)
            proved = recorder.objective - recorder.bound <= scaled.tolerance
            if ending == "infeasible":
                return recorder.infeasible()
            if proved or ending == "limit" or recorder.remaining == 0:
                break
            for k, tour in sorted(beyond):
                form.never(k, tour)
        limit = "time" if limits.iterations is None or recorder.remaining == 0 else "iterations"
        return recorder.result("proof" if proved else limit, proved=proved, tolerance=scaled.tolerance)


class Form(ABC):
    """What both forms share: y, its symmetry and its hints."""

    def __init__(self, instance: Instance, scaled: ScaledCosts) -> None:
        self.instance, self.scaled = instance, scaled
        self.model = model = cp_model.CpModel()
        self.y = {(i, k): model.new_bool_var(f"y[{i},{k}]") for i in instance.tasks for k in instance.depots}

    def break_symmetry(self) -> None:
        """Allow only routes as `in_order` has them (``strengthening.symmetry``)."""
        for before, k in neighbours(self.instance):
            for i in self.instance.tasks:
                self.model.add_bool_or(~self.y[i, k], *(self.y[j, before] for j in range(i)))

    def never(self, k: int, tour: Sequence[int]) -> None:
        """Cut off this tour of UAV k: not all of its arcs at once."""
        self.model.add_bool_or(~arc for arc in self.arcs(k, tour))

    @abstractmethod
    def arcs(self, k: int, tour: Sequence[int]) -> Iterable[cp_model.IntVar]:
        """Return the literals of the arcs of UAV k's tour."""

    def hint_visits(self, routes: Routes) -> None:
        """Tell CP-SAT to try the assignment of `routes` first."""
        for (i, k), y in self.y.items():
            self.model.add_hint(y, i in routes[k - self.instance.n_tasks])


class GiantCircuit(Form):
    """The giant circuit of one instance with one class of UAV: x, y, t and z as at the top of this file."""

    def __init__(self, instance: Instance, scaled: ScaledCosts, average: bool) -> None:
        super().__init__(instance, scaled)
        model, T, D = self.model, instance.tasks, instance.depots
        self.following = {k: D[(p + 1) % len(D)] for p, k in enumerate(D)}
        self.t = {i: model.new_int_var(0, scaled.upper, f"t[{i}]") for i in T}
        self.z = model.new_int_var(0, scaled.upper, "z")
        arcs = [(i, j) for i in T for j in T if i != j] + [(k, i) for k in D for i in T]
        arcs += [(i, k) for k in D for i in T] + [(k, after) for k, after in self.following.items() if k != after]
        self.x = {(i, j): model.new_bool_var(f"x[{i},{j}]") for i, j in arcs}
        model.add_circuit([(i, j, x) for (i, j), x in self.x.items()])
        for i in T:
            model.add_exactly_one(self.y[i, k] for k in D)
        self._same_uav()
        self._times()
        if average:
            self._average()
        model.minimize(self.z)

    def _same_uav(self) -> None:
        T, D = self.instance.tasks, self.instance.depots
        for i in T:
            for k in D:
                self.model.add_implication(self.x[k, i], self.y[i, k])
                self.model.add_implication(self.x[i, self.following[k]], self.y[i, k])
                for j in T:
                    if i != j:
                        self.model.add_bool_or(~self.x[i, j], ~self.y[i, k], self.y[j, k])
                        self.model.add_bool_or(~self.x[i, j], self.y[i, k], ~self.y[j, k])

    def _times(self) -> None:
        T, D, cost = self.instance.tasks, self.instance.depots, self.scaled.costs[0]
        for i in T:
            for j in T:
                if i != j:
                    self.model.add(self.t[j] >= self.t[i] + int(cost[i, j])).only_enforce_if(self.x[i, j])
            for k, limit in zip(D, self.scaled.limits.tolist(), strict=True):
                self.model.add(self.t[i] >= int(cost[k, i])).only_enforce_if(self.x[k, i])
                home = self.x[i, self.following[k]]
                self.model.add(self.z >= self.t[i] + int(cost[i, k])).only_enforce_if(home)
                if limit < self.scaled.upper:
                    self.model.add(self.t[i] + int(cost[i, k]) <= limit).only_enforce_if(home)

    def _average(self) -> None:
        T, D, cost = self.instance.tasks, self.instance.depots, self.scaled.costs[0]
        costs = {(i, j): int(cost[i, j]) for i in T for j in T if i != j}
        for i in T:
            for k in D:
                costs[k, i], costs[i, self.following[k]] = int(cost[k, i]), int(cost[i, k])
        total = cp_model.LinearExpr.weighted_sum([self.x[arc] for arc in costs], list(costs.values()))
        self.model.add(total <= len(D) * self.z)

    def break_symmetry(self) -> None:
        """Allow only routes as `in_order` has them (``strengthening.symmetry``)."""
        super().break_symmetry()
        if is_symmetric(self.instance):
            for k, after in self.following.items():
                first = sum(i * self.x[k, i] for i in self.instance.tasks)
                self.model.add(first <= sum(i * self.x[i, after] for i in self.instance.tasks))

    def hint(self, routes: Routes) -> None:
        """Tell CP-SAT to try `routes` first."""
        instance, cost = self.instance, self.scaled.costs[0]
        self.model.clear_hints()
        used = set()
        longest = 0
        for k, route in zip(instance.depots, routes, strict=True):
            used |= set(pairwise([k, *route, self.following[k]]))
            time, at = 0, k
            for i in route:
                time, at = time + int(cost[at, i]), i
                self.model.add_hint(self.t[i], time)
            longest = max(longest, time + int(cost[at, k]) if route else 0)
        for arc, x in self.x.items():
            self.model.add_hint(x, arc in used)
        self.hint_visits(routes)
        self.model.add_hint(self.z, longest)

    def arcs(self, k: int, tour: Sequence[int]) -> Iterable[cp_model.IntVar]:
        """Return the literals of the arcs of UAV k's tour."""
        return [self.x[arc] for arc in pairwise([k, *tour, self.following[k]])]

    def routes(self, value: Values) -> Routes:
        """Return the routes of a solution."""
        first = self.instance.depots[0]
        order = walk([arc for arc, x in self.x.items() if value(x)], first)
        routes: list[list[int]] = []
        for node in order:
            if node in self.instance.depots:
                routes.append([])
            else:
                routes[-1].append(node)
        return as_routes(routes)


class CircuitPerUav(Form):
    """One circuit per UAV: θ, y and z as at the top of this file."""

    def __init__(self, instance: Instance, scaled: ScaledCosts) -> None:
        super().__init__(instance, scaled)
        model, T, D = self.model, instance.tasks, instance.depots
        self.z = model.new_int_var(0, scaled.upper, "z")
        self.theta: Theta = {}
        for i in T:
            model.add_exactly_one(self.y[i, k] for k in D)
        for k in D:
            arcs = [(i, j) for i in (*T, k) for j in (*T, k) if i != j]
            self.theta |= {(i, j, k): model.new_bool_var(f"theta[{i},{j},{k}]") for i, j in arcs}
            flies = model.new_bool_var(f"flies[{k}]")
            loops = [(i, i, ~self.y[i, k]) for i in T]
            model.add_circuit([*((i, j, self.theta[i, j, k]) for i, j in arcs), *loops, (k, k, ~flies)])
            for i in T:  # else the circuit could leave the depot out
                model.add_implication(self.y[i, k], flies)
            cost, limit = scaled.uav_cost(D.index(k)), int(scaled.limits[D.index(k)])
            costs = [int(cost[i, j]) for i, j in arcs]
            tour = cp_model.LinearExpr.weighted_sum([self.theta[i, j, k] for i, j in arcs], costs)
            model.add(tour <= self.z)
            if limit < scaled.upper:
                model.add(tour <= limit)
        model.minimize(self.z)

    def break_symmetry(self) -> None:
        """Allow only routes as `in_order` has them (``strengthening.symmetry``)."""
        super().break_symmetry()
        if is_symmetric(self.instance):
            fly_one_way(self.model, self.theta, self.instance)

    def hint(self, routes: Routes) -> None:
        """Tell CP-SAT to try `routes` first."""
        self.model.clear_hints()
        used = used_arcs(self.instance, routes)
        for key, theta in self.theta.items():
            self.model.add_hint(theta, key in used)
        self.hint_visits(routes)

    def arcs(self, k: int, tour: Sequence[int]) -> Iterable[cp_model.IntVar]:
        """Return the literals of the arcs of UAV k's tour."""
        return [self.theta[i, j, k] for i, j in pairwise([k, *tour, k])]

    def routes(self, value: Values) -> Routes:
        """Return the routes of a solution."""
        routes = []
        for k in self.instance.depots:
            arcs = [(i, j) for (i, j, of), theta in self.theta.items() if of == k and value(theta)]
            routes.append(walk(arcs, k)[1:])
        return as_routes(routes)
