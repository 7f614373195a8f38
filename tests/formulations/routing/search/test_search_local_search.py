"""The search for one tour's order: moves against naive twins, and the result against the optimum."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.search import local_search
from formulations.routing.search import tours as rings
from formulations.routing.search.costs import both_ways
from formulations.routing.search.local_search import intensify
from formulations.routing.search.randomness import seeded
from formulations.routing.subset_dp import SubsetDp
from instances import tour_costs

L = 11
HOW = local_search.LocalSearchParameters()
seeds = st.integers(0, 10**6)


def random_tour(seed):
    """A tour over random asymmetric costs, its nodes in a random local_search."""
    rng = np.random.default_rng(seed)
    tour = local_search.closed_tour(rng.uniform(1.0, 100.0, (L + 1, L + 1)), HOW)
    tour.segments.nodes[1:-1] = 1 + rng.permutation(L)
    local_search.book(tour, 1)
    return tour, rng


def length(tour, nodes):
    return float(tour.costs.out[nodes[:-1], nodes[1:]].sum())


def assert_booked(tour):
    """Places and prefix sums are those of the local_search."""
    nodes = tour.segments.nodes
    assert sorted(nodes[:-1]) == list(range(L + 1))
    assert nodes[-1] == 0
    assert all(nodes[tour.position[v]] == v for v in range(L + 1))
    assert tour.segments.forward[1:] == pytest.approx(np.cumsum(tour.costs.out[nodes[:-1], nodes[1:]]))
    assert tour.segments.backward[1:] == pytest.approx(np.cumsum(tour.costs.out[nodes[1:], nodes[:-1]]))


@given(seed=seeds)
@settings(max_examples=60, deadline=None)
def test_a_reversal_gains_what_it_says(seed):
    tour, rng = random_tour(seed)
    i, j = sorted(int(x) for x in rng.integers(1, L + 1, 2))
    before, gain = tour.segments.nodes.copy(), local_search.reversal_gain(tour, i, j)
    local_search.reverse(tour, i, j)
    assert list(tour.segments.nodes) == [*before[:i], *before[i : j + 1][::-1], *before[j + 1 :]]
    assert gain == pytest.approx(length(tour, before) - length(tour, tour.segments.nodes))
    assert_booked(tour)


@given(seed=seeds)
@settings(max_examples=60, deadline=None)
def test_an_exchange_gains_what_it_says(seed):
    tour, rng = random_tour(seed)
    p, q, r = sorted(int(x) for x in rng.choice(L + 1, 3, replace=False))
    before, gain = tour.segments.nodes.copy(), local_search.exchange_gain(tour, p, q, r)
    local_search.exchange(tour, p, q, r)
    assert list(tour.segments.nodes) == [
        *before[: p + 1],
        *before[q + 1 : r + 1],
        *before[p + 1 : q + 1],
        *before[r + 1 :],
    ]
    assert gain == pytest.approx(length(tour, before) - length(tour, tour.segments.nodes))
    assert_booked(tour)


@given(seed=seeds, kicks=st.integers(0, 30))
@settings(max_examples=60, deadline=None)
def test_an_improved_tour_is_a_tour_and_no_longer(seed, kicks):
    tour, _ = random_tour(seed)
    before = length(tour, tour.segments.nodes)
    local_search.improve(tour, seeded(seed), kicks)
    assert_booked(tour)
    assert tour.segments.forward[-1] <= before
    assert tour.ring[1] == 0
    assert not tour.queued.any()


@pytest.mark.parametrize("seed", range(12))
def test_enough_kicks_find_the_best_order(seed, random_case):
    instance, _ = random_case(seed, 9, 1)
    optimum = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
    nodes = [9, *range(9)]
    tour = local_search.closed_tour(np.ascontiguousarray(instance.cost[np.ix_(nodes, nodes)]), HOW)
    local_search.improve(tour, seeded(seed), 300)
    assert tour.segments.forward[-1] == pytest.approx(optimum)


@given(seed=seeds)
@settings(max_examples=30, deadline=None)
def test_intensified_tours_keep_their_tasks_and_none_is_longer(seed, random_case):
    instance, routes = random_case(seed, 40, 3)
    costs = both_ways(instance.cost)
    tours = rings.from_routes(costs, routes)
    intensify(costs, tours, seeded(seed), 1.0, HOW)
    found = rings.to_routes(tours)
    assert [sorted(tour) for tour in found] == [sorted(tour) for tour in routes]
    assert tours.cost == pytest.approx(tour_costs(instance, found))
    assert (tours.cost <= tour_costs(instance, routes) * (1 + 1e-12)).all()
    assert tours.size.tolist() == [len(tour) for tour in routes]
    assert tours.cost.sum() < 0.9 * tour_costs(instance, routes).sum()  # random orders are far from good


def test_tours_of_too_few_or_too_many_tasks_stay_as_they_are(random_case):
    instance, routes = random_case(1, 40, 3)
    tours = rings.from_routes(both_ways(instance.cost), routes)
    few, many = sorted(map(len, routes))[0], sorted(map(len, routes))[2]
    how = HOW._replace(fewest=few + 1, most=many - 1)
    intensify(both_ways(instance.cost), tours, seeded(1), 1.0, how)
    for before, after in zip(routes, rings.to_routes(tours), strict=True):
        assert (before == after) == (len(before) in (few, many))


def test_two_tasks_and_costs_of_zero() -> None:
    tour = local_search.closed_tour(np.zeros((3, 3)), HOW)
    local_search.improve(tour, seeded(1), 10)
    assert sorted(tour.segments.nodes[:-1]) == [0, 1, 2]
