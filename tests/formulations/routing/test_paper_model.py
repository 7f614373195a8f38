"""The paper's equations, the cuts, the strengthening and the repair, each against a naive count."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, pairwise

import numpy as np
import pytest
from ortools.sat.python import cp_model

from formulations.limits import Limits
from formulations.routing.paper_model import PaperModel
from formulations.routing.registry import make_solver
from formulations.routing.scaling import scale_costs
from formulations.routing.solver import Status
from formulations.routing.strengthening import shortest_ways
from formulations.routing.subtours import find_subtours, repair, walk
from formulations.routing.symmetries import in_order, is_symmetric, shared_depots, used_arcs
from instances import Instance, Routes, Travel, check_routes, makespan
from instances.arrays import Floats

Windy = Callable[..., Instance]
Oracle = Callable[[Instance], tuple[float, Routes]]


def solutions(paper: PaperModel) -> set[frozenset[tuple[int, int, int]]]:
    """Return every assignment of θ that satisfies the model."""
    found: set[frozenset[tuple[int, int, int]]] = set()

    class Collect(cp_model.CpSolverSolutionCallback):
        def on_solution_callback(self) -> None:
            found.add(frozenset(key for key, theta in paper.theta.items() if self.value(theta)))

    paper.model.clear_objective()
    paper.model.add(paper.C_max == paper.scaled.upper)  # else every C_max above the longest tour counts anew
    solver = cp_model.CpSolver()
    solver.parameters.enumerate_all_solutions = True
    solver.parameters.num_workers = 1
    solver.solve(paper.model, Collect())
    return found


def all_routes(instance: Instance) -> set[frozenset[tuple[int, int, int]]]:
    """Return the θ of every possible routes, by insertion of one task after the other."""
    every: set[Routes] = {((),) * instance.n_depots}
    for task in instance.tasks:
        every = {
            (*routes[:k], (*route[:at], task, *route[at:]), *routes[k + 1 :])
            for routes in every
            for k, route in enumerate(routes)
            for at in range(len(route) + 1)
        }
    return {frozenset(used_arcs(instance, routes)) for routes in every}


@pytest.mark.parametrize("linked", [False, True])
def test_the_equations_allow_all_routes_and_no_others(windy: Windy, linked: bool) -> None:
    """const1–const5 with const6 for every S ⊆ T, |S| = 2 … n, are exactly the routes; so is the depot-linked form."""
    instance = windy(4, 2, 0)
    paper = PaperModel(instance, scale_costs(instance, 1e6))
    for size in range(2, 5):
        for S in combinations(instance.tasks, size):
            (paper.const6_depot_linked if linked else paper.const6)(S)
    assert solutions(paper) == all_routes(instance)


def test_a_cycle_through_all_tasks_needs_const6_for_n_tasks(windy: Windy) -> None:
    """With |S| ≤ n − 1 as printed in the paper, a UAV may fly all tasks in a circle and never see its depot."""
    instance = windy(3, 1, 0)
    paper = PaperModel(instance, scale_costs(instance, 1e6))
    for S in combinations(instance.tasks, 2):
        paper.const6(S)
    assert frozenset({(0, 1, 3), (1, 2, 3), (2, 0, 3)}) in solutions(paper)


def test_objective_is_the_longest_scaled_tour(windy: Windy, brute_force: Oracle) -> None:
    instance = windy(4, 2, 1)
    optimum, routes = brute_force(instance)
    paper = PaperModel(instance, scale_costs(instance, optimum))
    for key, theta in paper.theta.items():
        paper.model.add(theta == (key in used_arcs(instance, routes)))
    solver = cp_model.CpSolver()
    assert solver.solve(paper.model) == cp_model.OPTIMAL
    bound = paper.scaled.bound(solver.objective_value)
    assert bound <= optimum <= bound + paper.scaled.tolerance


def test_subtours_are_found_and_repaired(windy: Windy) -> None:
    instance = windy(6, 2, 0)
    first = [(6, 0), (0, 6), (1, 2), (2, 3), (3, 1)]
    second = [(4, 5), (5, 4)]
    assert find_subtours(first, 6, 6) == [[1, 2, 3]]
    assert find_subtours(second, 7, 6) == [[4, 5]]
    assert find_subtours([], 7, 6) == []
    assert walk(first, 1) == [1, 2, 3]
    assert walk(second, 7) == [7]
    routes = repair(instance, [first, second])
    assert check_routes(instance, routes) == []
    flown = [(i, j) for k, route in enumerate(routes) for i, j in pairwise([6 + k, *route, 6 + k])]
    assert sum(arc in flown for arc in [(1, 2), (2, 3), (3, 1)]) == 2, "a subtour is opened at one arc"


def test_repair_keeps_routes_without_subtours(windy: Windy) -> None:
    instance = windy(4, 2, 0)
    arcs = [[(4, 2), (2, 0), (0, 4)], [(5, 1), (1, 3), (3, 5)]]
    assert repair(instance, arcs) == ((2, 0), (1, 3))


def test_shortest_ways_undercut_a_dear_direct_arc() -> None:
    costs = np.array([[0, 1, 9], [1, 0, 0], [2, 0, 0]])  # task 0, task 1, depot 2
    out, back = shortest_ways(costs, 2, 2)
    assert out[0] <= 1
    assert back[0] <= 1
    assert out[1] == 0


def test_in_order_sorts_shared_depots_and_turns_symmetric_tours() -> None:
    points = np.array([[0.0, 0], [1, 0], [2, 1], [5, 5], [9, 9], [9, 9]])
    d = points[:, None] - points[None]
    instance = Instance("shared", np.hypot(d[..., 0], d[..., 1]), 4, 2)
    assert in_order(instance, ((), (3, 1, 0, 2))) == ((2, 0, 1, 3), ())
    assert in_order(instance, ((1, 2), (3, 0))) == ((0, 3), (1, 2))


def test_uavs_that_differ_share_no_depot() -> None:
    """Exchanging their tours would change costs, or pass an endurance."""
    points = np.array([[0.0, 0], [1, 0], [2, 1], [9, 9], [9, 9], [9, 9]])
    cost = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    one_way = cost.copy()
    one_way[0, 1] = np.inf

    def fleet(costs: list[Floats], endurance: list[float] | None = None) -> Instance:
        return Instance.of_travel("fleet", Travel.of_uavs(costs), 3, endurance=endurance)

    assert shared_depots(fleet([cost] * 3)) == [[3, 4, 5]]
    assert shared_depots(fleet([cost, 2 * cost, cost])) == [[3, 5], [4]]
    assert shared_depots(fleet([cost] * 3, [50, np.inf, 50])) == [[3, 5], [4]]
    assert is_symmetric(fleet([cost, 2 * cost, cost]))
    assert not is_symmetric(fleet([cost, one_way, cost]))


@pytest.mark.parametrize(
    "options",
    [
        {},
        dict.fromkeys(("depot_linked", "two_cycles", "every_solution", "symmetry", "reach", "hint"), False),
        {"depot_linked": False},
        {"two_cycles": False, "symmetry": False},
        {"every_solution": False, "hint": False},
    ],
)
@pytest.mark.parametrize("wind", [True, False])
def test_milp_agrees_with_brute_force_under_every_option(
    windy: Windy, brute_force: Oracle, options: dict[str, bool], wind: bool
) -> None:
    for seed in range(2):
        instance = windy(5, 2 + seed, seed, wind)
        result = make_solver("milp", options).solve(instance, limits=Limits(time=60))
        optimum, _ = brute_force(instance)
        assert result.status is Status.OPTIMAL
        assert result.objective == pytest.approx(optimum, rel=1e-12, abs=result.tolerance)
        assert result.bound is not None
        assert result.bound <= optimum


@pytest.mark.parametrize("per_uav", [False, True])
@pytest.mark.parametrize("symmetry", [False, True])
@pytest.mark.parametrize("shared", [False, True])
def test_circuit_agrees_with_brute_force_under_every_option(
    windy: Windy, brute_force: Oracle, per_uav: bool, symmetry: bool, shared: bool
) -> None:
    for wind in (False, True):
        base = windy(5, 3, 4, wind)
        nodes = [0, 1, 2, 3, 4, 5, 5, 7] if shared else list(range(8))
        instance = Instance("case", base.cost[np.ix_(nodes, nodes)], 5, 3)
        solver = make_solver("circuit", {"per_uav": per_uav, "symmetry": symmetry, "average": symmetry})
        result = solver.solve(instance, limits=Limits(time=60))
        assert result.status is Status.OPTIMAL
        assert result.objective == pytest.approx(brute_force(instance)[0], rel=1e-12, abs=result.tolerance)


def test_milp_stops_after_its_rounds_with_routes_and_a_bound(windy: Windy) -> None:
    instance = windy(9, 2, 0)
    result = make_solver("milp", {"two_cycles": False, "reach": False}).solve(
        instance, limits=Limits(time=60, iterations=1)
    )
    assert result.stopped_by == "iterations"
    assert result.status is Status.FEASIBLE
    assert result.routes is not None
    assert result.bound is not None
    assert 0 < result.bound < makespan(instance, result.routes)


def test_milp_says_what_is_too_large_for_it() -> None:
    assert make_solver("milp").accepts(Instance("large", np.zeros((63, 63)), 60, 3)) is None
    reason = make_solver("milp").accepts(Instance("larger", np.zeros((410, 410)), 400, 10))
    assert reason is not None
    assert "variables" in reason


def test_brute_force_and_held_karp_agree(windy: Windy, brute_force: Oracle, held_karp: Oracle) -> None:
    for seed in range(6):
        instance = windy(2 + seed % 5, 1 + seed % 3, seed, wind=seed % 2 == 0)
        assert brute_force(instance)[0] == pytest.approx(held_karp(instance)[0], rel=1e-12)
