"""The search in parts: it keeps what is no part, never makes routes longer, and leads out of a plain trap."""

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.recorder import Recorder
from formulations.routing.search_in_parts import improve_in_parts, search_of_part
from formulations.routing.solver import Status, ignore
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Travel, check_routes, makespan

N = 9


def plane(m, seed, n=N):
    xy = np.random.default_rng(seed).uniform(0, 100, (n + m, 2))
    return Instance("plane", np.hypot(*(xy[:, None] - xy).transpose(2, 0, 1)), n, m)


def all_to_the_first(m, n=N):
    return (tuple(range(n)), *[()] * (m - 1))


def improved(instance, routes, seed=0):
    recorder = Recorder(instance, Limits(time=60.0), ignore, routes)
    steps = improve_in_parts(recorder, seed)
    return recorder, steps


@pytest.mark.parametrize("seed", range(6))
def test_routes_get_no_longer_and_from_the_worst_ones_near_the_optimum(seed):
    instance = plane(4, seed)
    best = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
    recorder, steps = improved(instance, all_to_the_first(4))
    assert not check_routes(instance, recorder.routes)
    assert best * (1 - 1e-9) <= recorder.objective == makespan(instance, recorder.routes) <= 1.5 * best
    assert steps > 3 * N**2
    assert improved(instance, all_to_the_first(4))[0].routes == recorder.routes
    assert improved(instance, recorder.routes, seed=1)[0].objective <= recorder.objective


@pytest.mark.parametrize("m", [1, 2])
def test_where_a_part_would_be_all_there_is_nothing_to_do(m):
    recorder, steps = improved(plane(m, 0), all_to_the_first(m))
    assert steps == 0
    assert recorder.routes == all_to_the_first(m)


def test_routes_that_cost_nothing_are_left_as_they_are():
    instance = Instance("nothing", np.zeros((N + 4, N + 4)), N, 4)
    routes = ((), tuple(range(N)), (), ())
    recorder, steps = improved(instance, routes)
    assert (steps, recorder.routes) == (0, routes)
    assert BranchAndPrice(starts=1).solve(instance, limits=Limits(time=60.0)).status is Status.OPTIMAL


def test_nothing_is_done_without_routes_or_time():
    instance = plane(4, 0)
    assert improve_in_parts(Recorder(instance, Limits(time=60.0), ignore), 0) == 0
    late = Recorder(instance, Limits(time=1e-9), ignore, all_to_the_first(4))
    assert improve_in_parts(late, 0) == 0


@pytest.mark.parametrize("goes_on", [True, False])
def test_the_tours_of_the_others_stay_and_the_part_takes_what_they_leave(goes_on):
    instance, routes = plane(4, 1), ((0, 1, 2, 3, 4), (5,), (6, 7), (8,))
    found = search_of_part(instance, routes, [0, 2], Limits(time=60.0, iterations=500), 0, goes_on=goes_on)
    assert not check_routes(instance, found)
    assert (found[1], found[3]) == (routes[1], routes[3])
    assert makespan(instance, found) <= makespan(instance, routes)


@pytest.mark.parametrize("uavs", [[], [1]])
def test_a_part_without_uavs_or_tasks_has_no_routes(uavs):
    routes = ((0, 1, 2, 3, 4, 5, 6, 7, 8), (), ())
    assert search_of_part(plane(3, 0), routes, uavs, Limits(time=60.0, iterations=50), 0, goes_on=True) is None


def test_a_fleet_keeps_its_costs_and_endurance():
    plain = plane(4, 2)
    travel = Travel(np.stack([plain.cost, 2 * plain.cost])[:, None], np.array([0, 1, 1, 0]))
    limits = np.array([400.0, 300.0, 300.0, 150.0])
    instance = Instance.of_travel("fleet", travel, N, endurance=limits)
    routes = ((0, 1, 2, 3, 4, 5), (6,), (7,), (8,))
    assert not check_routes(instance, routes)
    recorder, _ = improved(instance, routes)
    assert not check_routes(instance, recorder.routes)
    assert recorder.objective <= makespan(instance, routes)
