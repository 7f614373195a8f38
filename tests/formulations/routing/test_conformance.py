"""What every registered solver must do, and what those that prove must do besides.

The suite is parametrised over the registry, so it picks up every solver there is. A third party registers its class in
the entry-point group ``mmmdmtsp_workbench.solvers`` of its own distribution, installs that beside this one and runs

    pytest tests/formulations/routing/test_conformance.py -k NAME

Small instances are compared with brute force. Solvers that prove run to their proof; the others run a few of their own
iterations, because a run ended by the clock need not be deterministic. Instances a solver does not accept are skipped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.registry import SOLVERS, make_solver
from formulations.routing.solver import Event, Result, Solver, Status, refusal
from instances import Instance, Routes, check_routes, makespan

Windy = Callable[..., Instance]
Oracle = Callable[[Instance], tuple[float, Routes]]

ITERATIONS = 20
GRACE = 10.0
"""Seconds past its limit after which a solver counts as hung; generous, because test machines are loaded."""
RELATIVE = 1e-9
"""Rounding allowed where one optimum is computed in two ways."""


@pytest.fixture(params=sorted(SOLVERS.targets()))
def solver(request: pytest.FixtureRequest) -> Solver:
    reason = SOLVERS.why_unavailable(request.param)
    if reason:
        pytest.skip(reason)
    return make_solver(request.param)


def conforming(solver: Solver, instance: Instance, result: Result, events: list[Event]) -> None:
    """Check what holds of every result, whatever the limit."""
    assert isinstance(result.status, Status)
    assert result.status in {Status.OPTIMAL, Status.FEASIBLE, Status.NO_SOLUTION, Status.INFEASIBLE}
    assert (result.status in {Status.NO_SOLUTION, Status.INFEASIBLE}) == (result.routes is None)
    assert result.status is not Status.INFEASIBLE or (solver.proves and instance.restricted)
    assert result.stopped_by
    if result.routes is not None and result.objective is not None:
        assert check_routes(instance, result.routes) == []
        assert result.objective == pytest.approx(makespan(instance, result.routes), rel=1e-12, abs=0)
        if result.bound is not None:
            assert result.bound <= result.objective
    if result.status is Status.OPTIMAL:
        assert solver.proves
        assert result.bound is not None
        assert result.objective is not None
        assert result.objective - result.bound <= result.tolerance
    objectives = [event.objective for event in events if event.objective is not None]
    bounds = [event.bound for event in events if event.bound is not None]
    assert all(later <= before for before, later in pairwise(objectives))
    assert all(later >= before for before, later in pairwise(bounds))
    assert all(before.elapsed <= later.elapsed for before, later in pairwise(events))
    streamed = [event.routes for event in events if event.routes is not None]
    if result.routes is not None:
        assert streamed, "the routes of a killed run would be lost"
        assert makespan(instance, streamed[-1]) == result.objective


def run(solver: Solver, instance: Instance, limits: Limits | None = None, **more: object) -> Result:
    """Run a solver, to its proof or for a few iterations, and check what holds of every result."""
    reason = refusal(solver, instance)
    if reason:
        pytest.skip(reason)
    solver.prepare(instance)
    if limits is None:
        limits = Limits(time=60) if solver.proves else Limits(time=60, iterations=ITERATIONS)
    events: list[Event] = []
    result = solver.solve(instance, limits=limits, observe=events.append, **more)  # type: ignore[arg-type]
    conforming(solver, instance, result, events)
    return result


def agrees(solver: Solver, result: Result, optimum: float) -> None:
    """Check a result against the true optimum."""
    assert result.objective is not None
    assert result.objective >= optimum * (1 - RELATIVE)
    if result.bound is not None:
        assert result.bound <= optimum * (1 + 1e-14)
    if solver.proves:
        assert result.status is Status.OPTIMAL
        assert result.objective <= optimum + result.tolerance + RELATIVE * optimum


def all_on_one(instance: Instance) -> Routes:
    """Return poor routes: everything by the last UAV, in descending order."""
    return (*[()] * (instance.n_depots - 1), tuple(reversed(instance.tasks)))


def points_instance(name: str, points: list[tuple[float, float]], n_depots: int) -> Instance:
    xy = np.array(points)
    d = xy[None] - xy[:, None]
    return Instance(name, np.hypot(d[..., 0], d[..., 1]), len(points) - n_depots, n_depots, xy)


def edge_cases(windy: Windy) -> dict[str, Instance]:
    """Return the cases by name, each with its places; where costs have none, the solver must do without."""
    base = windy(6, 2, 0)
    assert base.coordinates is not None
    xy, one_depot = base.coordinates, [0, 1, 2, 3, 4, 5, 6, 6]
    mixed = np.where(np.add.outer(np.arange(8), np.arange(8)) % 3 == 0, base.cost * 1e6, base.cost * 1e-9)
    rough = np.random.default_rng(5).uniform(0, 1, (8, 8)) ** 6  # far from the triangle inequality
    np.fill_diagonal(rough, 0.0)
    depots_apart = base.cost.copy()
    depots_apart[6:, 6:] = 1e12 * (1 - np.eye(2))
    return {
        "one task": windy(1, 1, 0),
        "one task, three UAVs": windy(1, 3, 0),
        "one UAV": windy(6, 1, 0),
        "more UAVs than tasks": windy(2, 5, 0),
        "all tasks in one place": points_instance("heap", [(3.0, 4.0)] * 5 + [(0.0, 0.0), (1.0, 0.0)], 2),
        "everything in one place": points_instance("point", [(1.0, 1.0)] * 6, 2),
        "a depot on a task": points_instance("on", [(0, 0), (4, 1), (2, 5), (7, 7), (0, 0), (6, 3)], 2),
        "two UAVs at one depot": Instance("shared", base.cost[np.ix_(one_depot, one_depot)], 6, 2, xy[one_depot]),
        "costs of 1e-6": Instance("small", base.cost * 1e-9, 6, 2, xy),
        "costs of 1e9": Instance("large", base.cost * 1e6, 6, 2, xy),
        "costs of 1e-6 beside 1e9": Instance("mixed", mixed, 6, 2, xy),
        "no triangle inequality": Instance("rough", rough, 6, 2),
        "dear arcs between depots": Instance("apart", depots_apart, 6, 2, xy),
    }


EDGE_CASES = (
    "one task",
    "one task, three UAVs",
    "one UAV",
    "more UAVs than tasks",
    "all tasks in one place",
    "everything in one place",
    "a depot on a task",
    "two UAVs at one depot",
    "costs of 1e-6",
    "costs of 1e9",
    "costs of 1e-6 beside 1e9",
    "no triangle inequality",
    "dear arcs between depots",
)


@pytest.mark.parametrize("case", EDGE_CASES)
def test_edge_case(solver: Solver, windy: Windy, brute_force: Oracle, case: str) -> None:
    instance = edge_cases(windy)[case]
    agrees(solver, run(solver, instance), brute_force(instance)[0])


@pytest.mark.parametrize(
    ("n", "m", "seed", "wind"), [(5, 2, 0, True), (6, 3, 1, True), (7, 2, 2, True), (6, 2, 3, False)]
)
def test_random_instance(
    solver: Solver, windy: Windy, brute_force: Oracle, n: int, m: int, seed: int, wind: bool
) -> None:
    instance = windy(n, m, seed, wind)
    agrees(solver, run(solver, instance), brute_force(instance)[0])


@pytest.mark.parametrize(("n", "m", "seed"), [(5, 2, 0), (6, 2, 1), (6, 3, 2), (7, 2, 3), (5, 3, 4), (6, 2, 6)])
def test_fleet(solver: Solver, fleets: Windy, brute_force: Oracle, n: int, m: int, seed: int) -> None:
    """UAVs that differ and cannot fly for ever: right optima, and INFEASIBLE exactly where there are no routes."""
    instance = fleets(n, m, seed)
    optimum, _ = brute_force(instance)
    result = run(solver, instance)
    if np.isinf(optimum):
        assert result.status is (Status.INFEASIBLE if solver.proves else Status.NO_SOLUTION)
    else:
        agrees(solver, result, optimum)


@pytest.mark.parametrize(("n", "m", "seed"), [(5, 2, 0), (6, 2, 1), (6, 3, 2), (6, 2, 3), (5, 3, 5)])
def test_costs_that_change_with_time(
    solver: Solver, clocked: Windy, brute_force: Oracle, n: int, m: int, seed: int
) -> None:
    """Clocks, with and without fleets and endurance."""
    instance = clocked(n, m, seed)
    optimum, _ = brute_force(instance)
    result = run(solver, instance)
    if np.isinf(optimum):
        assert result.status is (Status.INFEASIBLE if solver.proves else Status.NO_SOLUTION)
    else:
        agrees(solver, result, optimum)


def test_same_seed_same_answer(solver: Solver, windy: Windy) -> None:
    first, second = (run(solver, windy(8, 2, 4), seed=7) for _ in range(2))
    assert first.routes == second.routes
    assert first.objective == second.objective
    assert first.bound == second.bound


def test_keeps_its_time_limit(solver: Solver, windy: Windy) -> None:
    result = run(solver, windy(45, 3, 0), Limits(time=0.5))
    assert result.elapsed <= 0.5 + GRACE
    assert result.routes is not None


def test_relabelled(solver: Solver, windy: Windy, brute_force: Oracle) -> None:
    """Other numbers for tasks and UAVs change no optimum."""
    instance = windy(6, 3, 5)
    rng = np.random.default_rng(0)
    order = np.concatenate([rng.permutation(6), 6 + rng.permutation(3)])
    assert instance.coordinates is not None
    relabelled = Instance("relabelled", instance.cost[np.ix_(order, order)], 6, 3, instance.coordinates[order])
    agrees(solver, run(solver, relabelled), brute_force(instance)[0])


@pytest.mark.parametrize("factor", [1 / 3, 1000.0])
def test_scaled(solver: Solver, windy: Windy, brute_force: Oracle, factor: float) -> None:
    """Costs in another unit scale the optimum."""
    instance = windy(6, 2, 6)
    result = run(solver, Instance("scaled", instance.cost * factor, 6, 2, instance.coordinates))
    optimum = brute_force(instance)[0] * factor
    assert result.objective is not None
    assert result.objective >= optimum * (1 - RELATIVE)
    if solver.proves:
        assert result.objective == pytest.approx(optimum, rel=RELATIVE, abs=result.tolerance)


@pytest.mark.parametrize("seed", [7, 8])
def test_never_worse_than_its_start(solver: Solver, windy: Windy, brute_force: Oracle, seed: int) -> None:
    instance = windy(7, 2, seed)
    optimum, routes = brute_force(instance)
    perfect = run(solver, instance, start=routes)
    agrees(solver, perfect, optimum)
    assert perfect.objective is not None
    assert perfect.objective <= optimum


@pytest.mark.parametrize("seed", range(4))
def test_a_bad_start_changes_no_proof(solver: Solver, windy: Windy, brute_force: Oracle, seed: int) -> None:
    """Arcs dropped, tours capped and bounds cut by a loose incumbent must not cut off the optimum."""
    instance = windy(7, 2 + seed % 2, 9 + seed)
    result = run(solver, instance, start=all_on_one(instance))
    agrees(solver, result, brute_force(instance)[0])
    assert result.objective is not None
    assert result.objective <= makespan(instance, all_on_one(instance))


def test_the_suite_itself_refuses_false_claims(windy: Windy) -> None:
    """A suite that cannot fail shows nothing: each of these false results is caught."""
    instance = windy(3, 1, 0)
    solver = make_solver("milp")
    routes: Routes = ((0, 1, 2),)
    value = makespan(instance, routes)
    event = Event(0.0, value, None, routes)
    honest = Result(Status.FEASIBLE, value, None, routes=routes, stopped_by="finished")
    conforming(solver, instance, honest, [event])
    false_claims = [
        replace(honest, objective=0.9 * value),
        replace(honest, routes=((0, 1),)),
        replace(honest, bound=1.1 * value),
        replace(honest, status=Status.OPTIMAL, bound=0.5 * value, tolerance=1e-3),
        replace(honest, routes=None),
        replace(honest, stopped_by=""),
    ]
    for result in false_claims:
        with pytest.raises(AssertionError):
            conforming(solver, instance, result, [event])
    with pytest.raises(AssertionError):
        conforming(solver, instance, honest, [event, Event(1.0, 2 * value, None)])
