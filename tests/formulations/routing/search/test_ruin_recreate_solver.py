"""What `ruin-recreate` promises as a solver."""

import itertools

import numpy as np
import pytest

from formulations.registry import make_solver
from formulations.solver import Limits, Status
from instances import InputError, Instance, check_routes, makespan


def random_instance(seed, n, m):
    cost = np.random.default_rng(seed).uniform(1.0, 100.0, (n + m, n + m))
    np.fill_diagonal(cost, 0.0)
    return Instance(f"random {seed}", cost, n, m)


def brute_force(instance):
    best = np.inf
    for order in itertools.permutations(instance.tasks):
        for cut in range(instance.n_tasks + 1):
            best = min(best, makespan(instance, (order[:cut], order[cut:])))
    return best


def test_finds_the_brute_force_optimum():
    instance = random_instance(1, 6, 2)
    result = make_solver("ruin-recreate").solve(instance, limits=Limits(time=60, iterations=3000))
    assert result.objective == pytest.approx(brute_force(instance))
    assert result.status == Status.FEASIBLE
    assert result.stopped_by == "iterations"


@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 4), (3, 7), (9, 1), (30, 4)])
def test_feasible_routes_and_honest_events_for_every_shape(n, m):
    instance = random_instance(n, n, m)
    events = []
    result = make_solver("ruin-recreate").solve(
        instance, limits=Limits(time=60, iterations=200), seed=1, observe=events.append
    )
    assert check_routes(instance, result.routes) == []
    assert result.objective == makespan(instance, result.routes)
    assert events[-1].routes == result.routes
    values = [event.objective for event in events]
    assert values == sorted(values, reverse=True)


def test_same_seed_same_answer_other_seed_other_way():
    instance = random_instance(3, 40, 4)
    solver, limits = make_solver("ruin-recreate"), Limits(time=600, iterations=300)
    first, again, other = (solver.solve(instance, limits=limits, seed=s) for s in (7, 7, 8))
    assert first.routes == again.routes
    assert first.routes != other.routes


def test_never_worse_than_its_start():
    instance = random_instance(4, 25, 3)
    solver = make_solver("ruin-recreate")
    good = solver.solve(instance, limits=Limits(time=60, iterations=5000)).routes
    result = solver.solve(instance, limits=Limits(time=60, iterations=1), start=good)
    assert result.objective <= makespan(instance, good)


@pytest.mark.parametrize("options", [{"removals": 0}, {"hot": 0.001, "cold": 0.1}, {"peaked": 0.0}, {"removal": 3}])
def test_options_that_cannot_be_used_are_named(options):
    with pytest.raises(InputError, match=next(iter(options))):
        make_solver("ruin-recreate", options)
