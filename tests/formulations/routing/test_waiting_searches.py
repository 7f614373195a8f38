"""Searches where take-off is within a window: their price of a tour, and the optima they reach."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.clocked.problem import ClockedProblem
from formulations.routing.clocked.waiting import BEYOND
from formulations.routing.registry import make_solver
from formulations.routing.search.problem_data import NeighbourhoodParameters
from formulations.routing.solver import Status
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, check_routes, take_offs, tour_costs
from instances.routes import past_endurance

Clocked = Callable[..., Instance]


def waiting(instance: Instance, share: float, window: float = 1800.0) -> Instance:
    """Return `instance` with a window of take-off, and endurance a share of its least makespan without one."""
    least = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
    assert least is not None
    assert instance.travel is not None
    limits = np.full(instance.n_depots, share * least)
    return replace(instance, travel=replace(instance.travel, window=window), endurance=limits)


def test_a_tour_costs_what_it_lands_at_from_its_best_take_off(clocked: Clocked) -> None:
    """Against the walk along every line of A, tour by tour; those that cannot be flown cost more than `beyond`."""
    waited = never = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        free = replace(clocked(7, 2, seed), endurance=None)
        cut, order = int(rng.integers(1, 7)), rng.permutation(7).tolist()
        routes = tuple(order[:cut]), tuple(order[cut:])
        at_once = tour_costs(free, routes)
        if np.isinf(at_once).any():
            continue
        assert free.travel is not None
        travel, limits = replace(free.travel, window=900.0), rng.uniform(0.85, 1.02, 2) * at_once
        instance = replace(free, travel=travel, endurance=limits)
        problem = ClockedProblem(instance, NeighbourhoodParameters())
        costs, waits = tour_costs(instance, routes), take_offs(instance, routes)
        past = past_endurance(instance, costs - waits)
        priced = problem.tours(routes).cost
        assert priced[~past] == pytest.approx(costs[~past], rel=1e-9)
        assert (priced[past] > problem.waits.table[past, BEYOND]).all()
        waited, never = waited + int((waits[~past] > 0).sum()), never + int(past.sum())
    assert waited >= 5
    assert never >= 5


@pytest.mark.parametrize("name", ["memetic", "ruin-recreate", "ga"])
def test_searches_find_the_optima_that_waiting_makes_flyable(name: str) -> None:
    """In winds that turn 90° an hour; nothing of the first three can be flown at once, nothing at all of the last."""
    solver = make_solver(name, {"population": 60} if name == "ga" else {})
    for n, m, seed in ((8, 2, 0), (8, 2, 4), (8, 2, 5), (8, 2, 3)):
        instance = waiting(generate("wind-turning", n, m, seed), 0.95)
        proved = SubsetDp().solve(instance, limits=Limits(time=60.0))
        assert (proved.status is Status.INFEASIBLE) == (seed == 3)
        solver.prepare(instance)
        iterations = 60 if name == "ga" else 4000
        found = solver.solve(instance, limits=Limits(time=60.0, iterations=iterations), seed=1)
        assert found.objective == (None if proved.objective is None else pytest.approx(proved.objective, rel=1e-6))
        if found.routes is not None:
            assert check_routes(instance, found.routes) == []
            assert take_offs(instance, found.routes).any()


def test_endurance_that_suffices_at_once_leaves_what_is_found_alone() -> None:
    """To the bit: who need not wait is priced as where nobody may."""
    free = generate("wind-turning", 9, 2, 1)
    for name in ("memetic", "ruin-recreate", "greedy"):
        solver, limits = make_solver(name), Limits(time=60.0, iterations=500)
        without = solver.solve(free, limits=limits, seed=2)
        found = solver.solve(waiting(free, 10.0), limits=limits, seed=2)
        assert (found.objective, found.routes) == (without.objective, without.routes), name
