"""Numbering of the tasks of a large search, and the costs by it."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.search.costs import both_ways, part_of
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.numbering import numbering
from instances import Instance, makespan

N, M = 12, 3


@pytest.mark.parametrize("symmetric", [True, False])
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_routes_cost_by_the_numbers_of_a_search_what_they_cost_by_those_of_the_instance(random_case, symmetric, seed):
    instance, routes = random_case(seed, N, M)
    cost = instance.cost + instance.cost.T if symmetric else instance.cost
    instance = Instance("as it was", cost, N, M)
    numbers = numbering(instance, 0, 1.0)
    by_search, there = numbers.costs(instance), numbers.of_search(routes)
    assert sorted(numbers.order) == list(range(N))
    assert numbers.of_instance(there) == routes
    assert (by_search.out is by_search.into) == symmetric
    for matrix in (by_search.out, by_search.into.T):
        renumbered = Instance("renumbered", matrix, N, M)
        assert makespan(renumbered, there) == pytest.approx(makespan(instance, routes))


def test_each_task_is_followed_by_the_nearest_that_is_left():
    places = np.array([0.0, 7.0, 1.0, 6.0, 3.0, 100.0, 100.0])
    instance = Instance("line", np.abs(places[:, None] - places), 5, 2)
    assert numbering(instance, 0, 1.0).order.tolist() == [0, 2, 4, 3, 1]


def test_few_tasks_those_of_a_fleet_and_those_of_a_hurried_search_keep_their_numbers():
    cost = np.abs(np.subtract.outer(*2 * [np.random.default_rng(0).uniform(size=N + M)]))
    few = Instance("few", cost, N, M)
    fleet = Instance("fleet", cost, N, M, endurance=np.full(M, 1.5 * cost.sum()))
    assert numbering(few, N, 1.0).order.tolist() != list(range(N))
    for instance, many, limit in ((few, N + 1, 1.0), (few, N, 1e-6), (fleet, 0, 1.0)):
        numbers = numbering(instance, many, limit)
        assert numbers.order.tolist() == list(range(N))
        assert np.array_equal(np.squeeze(numbers.costs(instance).out), cost)


@settings(max_examples=20, deadline=None)
@given(size=st.integers(1, 600), seed=st.integers(0, 10**6))
@example(size=600, seed=0)
@example(size=256, seed=1)
@example(size=257, seed=2)
def test_costs_are_symmetric_unless_a_single_one_differs(size, seed):
    rng = np.random.default_rng(seed)
    cost = rng.uniform(size=(size, size))
    cost += cost.T
    assert both_ways(cost).out is both_ways(cost).into
    i, j = rng.integers(size, size=2)
    cost[i, j] += float(i != j)
    assert (both_ways(cost).out is both_ways(cost).into) == (i == j)


def test_costs_of_a_part_are_those_between_its_nodes(random_case):
    cost, nodes = random_case(0, N, M)[0].cost, np.array([7, 2, 13])
    part = part_of(both_ways(cost), nodes, np.array([1]))
    assert np.array_equal(part.out, cost[np.ix_(nodes, nodes)])
    assert np.array_equal(part.into, part.out.T)


def test_a_search_of_many_tasks_begins_from_the_routes_given_and_tells_of_its_own_by_the_instances_numbers():
    places = np.random.default_rng(1).permutation(1000.0 + np.arange(1002))
    instance = Instance("line", np.abs(places[:, None] - places), 1000, 2)
    order = np.argsort(places[:1000])
    start = tuple(tuple(part.tolist()) for part in (order[:500], order[500:]))
    found = Memetic().solve(instance, limits=Limits(time=3600.0, iterations=1), start=start)
    assert found.routes is not None
    assert makespan(instance, found.routes) <= makespan(instance, start)
    own = Memetic().solve(instance, limits=Limits(time=3600.0, iterations=2000), seed=3)
    assert own.routes is not None
    assert sorted(v for route in own.routes for v in route) == list(range(1000))
    assert makespan(instance, own.routes) < 20 * np.ptp(places)  # told by the numbers of the search: 181 times
