"""Perturbation: a UAV leaves its tasks and takes over a segment of a long tour, against naive twins on random costs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.search import perturbation
from formulations.routing.search import tours as rings
from formulations.routing.search.costs import both_ways
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.recreate import RecreateParameters
from instances import check_routes, tour_costs

N, M = 14, 4
seeds = st.integers(0, 10**6)


@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_the_relocated_uav_can_get_there_and_the_task_is_not_its_own(random_case, seed):
    instance, routes = random_case(seed, N, M)
    costs = both_ways(instance.cost)
    tours = rings.from_routes(costs, routes)
    h, v = perturbation.draw_relocation(costs, tours, rings.longest(tours.cost), 50, seeded(seed))
    if h >= 0:
        assert v not in routes[h]
        assert instance.cost[N + h, v] + instance.cost[v, N + h] < tour_costs(instance, routes).max()


def test_the_only_uav_is_not_relocated(random_case):
    instance, routes = random_case(3, N, 1)
    costs = both_ways(instance.cost)
    assert perturbation.draw_relocation(costs, rings.from_routes(costs, routes), np.inf, 50, seeded(1)) == (-1, -1)


@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_clearing_and_relocating_to_a_segment(random_case, seed):
    instance, routes = random_case(seed, N, M)
    costs = both_ways(instance.cost)
    rng = np.random.default_rng(seed + 1)
    tours = rings.from_routes(costs, routes)
    h = int(rng.integers(M))
    removed = np.empty(N, np.int32)
    count = rings.clear(costs, tours, h, removed)
    assert tuple(removed[:count].tolist()) == routes[h]
    others = [v for k in range(M) if k != h for v in routes[k]]
    if not others:
        return
    v, limit = int(rng.choice(others)), float(rng.uniform(50, 400))
    perturbation.relocate(costs, tours, h, v, limit)
    k = next(k for k in range(M) if v in routes[k])
    at = routes[k].index(v)
    length = 1
    while at + length < len(routes[k]):
        longer = [
            (),
        ] * M
        longer[h] = routes[k][at : at + length + 1]
        if tour_costs(instance, longer)[h] > limit:
            break
        length += 1
    found = rings.to_routes(tours)
    assert found[h] == routes[k][at : at + length]
    assert found[k] == routes[k][:at] + routes[k][at + length :]


@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_a_uav_that_need_not_come_back_in_time_takes_over_all_the_rest_of_a_tour(random_case, seed):
    instance, routes = random_case(seed, N, M)
    costs = both_ways(instance.cost)
    tours = rings.from_routes(costs, routes)
    how = perturbation.PerturbationParameters(bounded=False)
    count, removed = perturbation.relocate_one(costs, tours, how, seeded(seed))
    if count < 0:
        return
    found = rings.to_routes(tours)
    [h] = [k for k in range(M) if routes[k] and set(routes[k]) == set(removed[:count].tolist())] or [
        k for k in range(M) if not routes[k] and found[k]
    ]
    [k] = [k for k in range(M) if k != h and found[k] != routes[k]]
    assert found[h]
    assert found[k] + found[h] == routes[k]


@given(seed=seeds, bounded=st.booleans())
@settings(deadline=None, max_examples=30)
def test_a_perturbation_keeps_every_task_and_its_books(random_case, seed, bounded):
    instance, routes = random_case(seed, N, M)
    costs = both_ways(instance.cost)
    tours = rings.from_routes(costs, routes)
    data = problem_data(both_ways(instance.cost), N, NeighbourhoodParameters(8, M))
    how = perturbation.PerturbationParameters(bounded=bounded)
    perturbation.perturb(data, tours, how, RecreateParameters(), seeded(seed))
    found = rings.to_routes(tours)
    assert check_routes(instance, found) == []
    assert tours.cost == pytest.approx(tour_costs(instance, found))
    assert tours.size.tolist() == [len(route) for route in found]
