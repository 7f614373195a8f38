"""The search over states: tours cost what their routes cost, proved optima are found, decoupled plans never win."""

from __future__ import annotations

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.moving_cost.turns.headings import headings
from formulations.moving_cost.turns.travel import Turns, turning_instance
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.states.costs import state_costs
from formulations.routing.search.states.searching import straight_legs
from formulations.routing.search.states.tours import from_routes, insert, rekeep, to_routes, with_task
from formulations.routing.solver import refusal
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Travel, check_routes, objective, tour_costs


def dense(n_tasks: int, n_depots: int, seed: int, spacing: float, uniform: int = 12) -> Instance:
    """Tasks `spacing` turning radii apart, in a square of 20 km."""
    places = np.random.default_rng(seed).uniform(0, 20000, (n_tasks + n_depots, 2))
    radius = 20000 / n_tasks**0.5 / spacing
    return turning_instance("dense", places, n_tasks, Turns(radius, 20.0), headings(places, n_tasks, uniform=uniform))


def lawless(seed: int, *, closed: bool = False) -> Instance:
    """Six tasks, two depots and two classes; one to four states a node, costs without any law."""
    rng = np.random.default_rng(seed)
    nodes = np.repeat(np.arange(8), rng.integers(1, 5, 8))
    cost = rng.uniform(0, 100, (2, 1, len(nodes), len(nodes)))
    return Instance.of_travel("lawless", Travel(cost, np.array([1, 0]), nodes=nodes, closed=closed), 6)


@pytest.mark.parametrize("closed", [False, True])
def test_tours_cost_what_their_routes_cost(closed: bool) -> None:
    for seed in range(5):
        instance = lawless(seed, closed=closed)
        costs, unit = state_costs(instance), instance.travel.cost.max()  # type: ignore[union-attr]
        tours = from_routes(costs, ((4, 0, 2), (5,)))
        assert tours.cost * unit == pytest.approx(tour_costs(instance, ((4, 0, 2), (5,))), rel=1e-5)
        room = np.empty((2, tours.prefix.shape[1]), np.float32)
        for task, place in ((1, 1), (3, 0)):
            foretold = with_task(costs, tours, 0, task, place, room)
            insert(costs, tours, 0, task, place)
            assert tours.cost[0] == pytest.approx(foretold, rel=1e-5)
        if closed:
            rekeep(costs, tours, 0)
        assert to_routes(tours) == ((3, 4, 1, 0, 2), (5,))
        assert tours.cost * unit == pytest.approx(tour_costs(instance, to_routes(tours)), rel=1e-5)


@pytest.mark.parametrize("closed", [False, True])
def test_lawless_costs_are_solved(closed: bool) -> None:
    for seed in range(3):
        instance = lawless(seed, closed=closed)
        proved = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
        found = Memetic().solve(instance, limits=Limits(time=60.0, iterations=6000))
        assert found.objective == pytest.approx(proved, rel=1e-9)
        assert check_routes(instance, found.routes or ()) == []


def test_proved_optima_are_found() -> None:
    for seed, spacing in ((0, 2.0), (1, 4.0)):
        instance = dense(8, 2, seed, spacing)
        proved = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
        found = Memetic().solve(instance, limits=Limits(time=60.0, iterations=8000), seed=seed)
        assert found.objective == pytest.approx(proved, rel=1e-9)


@pytest.mark.slow
def test_proved_optima_are_found_in_nineteen_of_twenty() -> None:
    hits = 0
    for seed in range(20):
        instance = dense(8 + seed % 5, 2 + seed % 2, seed, 1.5 + seed % 6, uniform=16)
        proved = SubsetDp().solve(instance, limits=Limits(time=600.0)).objective or 0.0
        found = Memetic().solve(instance, limits=Limits(time=60.0, iterations=20_000), seed=seed)
        hits += (found.objective or np.inf) <= proved * (1 + 1e-9)
    assert hits >= 19


def test_the_plan_that_ignores_turns_is_never_better_and_mostly_much_worse() -> None:
    instance = dense(20, 3, 0, 1.5, uniform=8)
    straight = Memetic().solve(straight_legs(instance), limits=Limits(time=60.0, iterations=3000))
    assert straight.routes is not None
    coupled = Memetic().solve(instance, limits=Limits(time=60.0, iterations=3000))
    assert coupled.objective is not None
    assert coupled.objective < 0.8 * objective(instance, straight.routes)
    hurried = Memetic().solve(instance, limits=Limits(time=60.0, iterations=1), start=straight.routes)
    assert (hurried.objective or np.inf) <= objective(instance, straight.routes)


def test_a_seed_makes_the_same_search() -> None:
    instance = dense(10, 2, 3, 2.0, uniform=8)
    first, second = (Memetic().solve(instance, limits=Limits(time=60.0, iterations=300), seed=5) for _ in range(2))
    assert first.routes == second.routes
    assert first.statistics == second.statistics


def test_states_with_endurance_are_refused() -> None:
    travel = lawless(0).travel
    assert travel is not None
    limited = Instance.of_travel("limited", travel, 6, endurance=np.array([50.0, 60.0]))
    assert refusal(Memetic(), limited) == "memetic takes states without endurance"


def test_decoupled_routes_are_those_of_straight_legs() -> None:
    instance = generate("dense-survey", 12, 2, 1, spacing=1.5, headings=8)
    plan = Memetic(decoupled=True).solve(instance, limits=Limits(time=60.0, iterations=5000), seed=0)
    assert plan.routes is not None
    straight = Memetic().solve(straight_legs(instance), limits=Limits(time=60.0, iterations=5000), seed=0)
    assert straight.routes is not None
    assert {frozenset(route) for route in plan.routes} == {frozenset(route) for route in straight.routes}
    coupled = Memetic().solve(instance, limits=Limits(time=60.0, iterations=2000), seed=0, start=plan.routes)
    assert (coupled.objective or 0.0) < 0.95 * (plan.objective or 0.0)
