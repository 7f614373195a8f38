"""Searches by the clock: their bookings, the directions of tours, and the optima they reach."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.clocked.annealing import anneal_by_clock
from formulations.routing.clocked.bookings import empty_bookings, insertion, reverse
from formulations.routing.clocked.problem import ClockedProblem
from formulations.routing.clocked.recreate import BEND, BEYOND, LINEAR, SQUARE, expand
from formulations.routing.registry import make_solver
from formulations.routing.search.annealing import AnnealingParameters
from formulations.routing.search.energy import Measure, Objective, excess, p_norm
from formulations.routing.search.problem_data import NeighbourhoodParameters
from formulations.routing.search.randomness import seeded
from formulations.routing.search.recreate import GUIDES, growth
from formulations.routing.search.tours import duplicate, to_routes
from instances import Instance, Routes, makespan, tour_costs
from instances.frozen import frozen, in_better_directions, judged

Clocked = Callable[..., Instance]


def routes_of(n: int, m: int, seed: int) -> Routes:
    rng = np.random.default_rng(seed)
    cuts = np.sort(rng.integers(0, n + 1, m - 1))
    return tuple(tuple(part.tolist()) for part in np.split(rng.permutation(n), cuts))


@pytest.mark.parametrize("seed", range(4))
def test_bookings_are_what_tours_take(clocked: Clocked, seed: int) -> None:
    instance, routes = clocked(9, 3, 6 * seed), routes_of(9, 3, seed)
    problem = ClockedProblem(instance, NeighbourhoodParameters())
    tours = problem.tours(routes)
    assert tours.cost / problem.scale == pytest.approx(tour_costs(instance, routes), rel=1e-12)


def test_first_order_changes_are_nearly_those_of_tours_flown_anew() -> None:
    """In a wind that turns 90° an hour, against the exact change of every insertion of one task."""
    instance = generate("wind-turning", 12, 1, 0)
    problem = ClockedProblem(instance, NeighbourhoodParameters())
    order = list(range(1, 12))
    tours = problem.tours((tuple(order),))
    search = problem.search(tours, 1)
    for place, u in enumerate([12, *order]):
        flown = tour_costs(instance, ((*order[:place], 0, *order[place:]),))[0] - tours.cost[0]
        change = insertion(search.clocks, tours, search.bookings, 0, u)[0]
        assert change == pytest.approx(flown, rel=0.08, abs=5.0)


@pytest.mark.parametrize("guide", [*GUIDES, excess(0.7)])
def test_guides_grow_to_second_order_as_they_are_expanded(guide: Measure) -> None:
    """Exactly where they are lines or squares, tours longer than a cap growing; else but for terms of third order."""
    bookings, scale = empty_bookings(1, np.array([1.25]), np.zeros((1, 3))), 1 / 2000
    expand(guide, 1600.0, scale, 1e-4, bookings, 0)
    row, length = bookings.growth[0], 1600.0 * scale
    for change in (0.0, 1.0, 10.0, 400.0):
        rise = change * (row[LINEAR] + change * row[SQUARE]) + row[BEYOND] * max(0.0, change - row[BEND])
        share = change * bookings.scale[0] * scale
        third = guide.p**3 * share**3 * (length + share) ** max(0, guide.p - 3) if guide.p > 2 else 0.0
        assert rise == pytest.approx(growth(length, share, guide, 1e-4), rel=1e-12, abs=third)


@pytest.mark.parametrize("seed", range(3))
def test_whatever_steps_undo_tours_are_booked_as_they_are_flown(clocked: Clocked, seed: int) -> None:
    """Steps that put all back, that are refused unflown, and refused or kept after: links, costs and bookings agree."""
    instance, how, energy = clocked(9, 3, 2 * seed), AnnealingParameters(), Objective(p_norm(8), 0.1)
    problem = ClockedProblem(instance, NeighbourhoodParameters())
    tours, rng = problem.tours(routes_of(9, 3, seed)), seeded(seed)
    best, fittest, search = duplicate(tours), duplicate(tours), problem.search(tours, how.removals)
    for temperature in (300.0, 30.0, 3.0):
        anneal_by_clock(search, best, fittest, rng, 500, temperature, energy, p_norm(8), how)
        for some in (tours, best, fittest):
            assert sorted(i for route in to_routes(some) for i in route) == list(range(9))
            again = duplicate(some)
            problem.book(again)
            assert some.cost == pytest.approx(again.cost, rel=1e-12)
        booked = problem.search(duplicate(tours), 1).bookings
        on_tour = [u for u in range(12) if u < 9 or tours.after[u] != u]
        assert search.bookings.times[on_tour] == pytest.approx(booked.times[on_tour])


def test_turning_a_tour_round_twice_changes_nothing() -> None:
    problem = ClockedProblem(generate("wind-turning", 9, 2, 1), NeighbourhoodParameters())
    tours = problem.tours(routes_of(9, 2, 3))
    before = duplicate(tours)
    reverse(tours, 0)
    assert to_routes(tours)[0] == to_routes(before)[0][::-1]
    costs = problem.data.costs.out
    assert tours.arc == pytest.approx([costs[u, w] for u, w in enumerate(tours.after)])
    reverse(tours, 0)
    for now, then in zip(tours, before, strict=True):
        assert np.array_equal(now, then)


def test_a_stopped_clock_is_the_matrix_of_that_time(clocked: Clocked) -> None:
    instance = clocked(5, 2, 0)
    assert instance.travel is not None
    knots, cost = instance.travel.departures, instance.travel.cost[0]
    for time, expected in (
        (0.0, cost[0]),
        (knots[1], cost[1]),
        (1e9, cost[-1]),
        (knots[1] / 2, (cost[0] + cost[1]) / 2),
    ):
        assert frozen(instance, float(time)).cost == pytest.approx(expected)


def test_better_directions_are_never_worse() -> None:
    instance = generate("wind-turning", 12, 3, 0, turning=360)
    for seed in range(10):
        plan = judged(instance, routes_of(12, 3, seed))
        assert plan.directed <= plan.taken
        assert plan.directed == makespan(instance, plan.routes)
        assert plan.routes == in_better_directions(instance, plan.routes)


@pytest.mark.parametrize("name", ["memetic", "ruin-recreate", "ga", "greedy"])
def test_searches_by_the_clock_repeat_themselves(name: str) -> None:
    solver, instance = make_solver(name), generate("wind-turning", 15, 3, 0)
    limits = Limits(time=60, iterations=300)
    solver.prepare(instance)
    first, second = (solver.solve(instance, limits=limits, seed=3) for _ in range(2))
    assert first.routes == second.routes
    assert first.objective == second.objective


def test_a_static_plan_is_that_of_the_costs_of_take_off() -> None:
    instance, limits = generate("wind-turning", 12, 2, 3, turning=360), Limits(time=60, iterations=2000)
    still = make_solver("memetic").solve(frozen(instance), limits=limits, seed=1)
    plan = make_solver("memetic", {"static": True}).solve(instance, limits=limits, seed=1)
    assert plan.routes == still.routes
    assert plan.objective == makespan(instance, plan.routes or ()) != still.objective


@pytest.mark.slow
def test_memetic_reaches_the_optima_of_20_instances() -> None:
    """Up to 14 tasks, turning and passing fronts among them, within 5 s."""
    for seed in range(20):
        rng = np.random.default_rng([3, seed])
        n, m = int(rng.integers(8, 15)), int(rng.integers(2, 4))
        instance = generate("wind-turning", n, m, seed, turning=(90, 360)[seed % 2])
        best = make_solver("subset-dp").solve(instance, limits=Limits(time=60)).objective
        found = make_solver("memetic").solve(instance, limits=Limits(time=5), seed=seed).objective
        assert found == pytest.approx(best, rel=1e-12), instance.name
