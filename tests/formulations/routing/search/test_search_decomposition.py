"""Decomposition: some tours as an instance of their own, and back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.search import decomposition
from formulations.routing.search import tours as rings
from formulations.routing.search.costs import both_ways
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from formulations.routing.search.randomness import seeded
from instances import check_routes, tour_costs

N, M = 16, 5
NEAR, HOW = NeighbourhoodParameters(), decomposition.DecompositionParameters()
seeds = st.integers(0, 10**6)


def prepared(case):
    instance, routes = case
    data = problem_data(both_ways(instance.cost), instance.n_tasks, NEAR)
    return instance, data, rings.from_routes(data.costs, routes)


@given(seed=seeds, wanted=st.integers(1, M))
@settings(deadline=None, max_examples=40)
def test_the_longest_tour_and_different_others_are_chosen(random_case, seed, wanted):
    _, data, tours = prepared(random_case(seed, N, M))
    uavs = decomposition.around(data.near, tours, int(tours.cost.argmax()), wanted, HOW, seeded(seed))
    assert uavs[0] == np.argmax(tours.cost)
    assert len(set(uavs.tolist())) == len(uavs) <= wanted


def test_a_subproblem_takes_tours_that_touch_before_distant_ones():
    """Two crowds far apart, two UAVs at each: no step leads from one to the other, only a draw from anywhere."""
    x = np.array([0, 1, 2, 3, 1000, 1001, 1002, 1003, 0, 1, 1000, 1001], float)
    cost = np.abs(np.subtract.outer(x, x))
    data = problem_data(both_ways(cost), 8, NEAR)
    near = data.near._replace(tasks=data.near.tasks[:, :3].copy())
    tours = rings.from_routes(data.costs, ((0, 3), (1, 2), (4, 6), (5, 7)))
    partners = [
        int(decomposition.around(near, tours, int(tours.cost.argmax()), 2, HOW, seeded(seed))[1]) for seed in range(200)
    ]
    assert partners.count(1) > 2 * (partners.count(2) + partners.count(3)) > 0


@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_a_subproblem_is_an_instance_with_the_same_tours_and_goes_back_as_found(random_case, seed):
    instance, data, tours = prepared(random_case(seed, N, M))
    uavs = decomposition.around(data.near, tours, int(tours.cost.argmax()), 3, HOW, seeded(seed))
    part = decomposition.subproblem(data, tours, uavs, NEAR)
    assert part.tours.cost == pytest.approx(tours.cost[uavs])
    assert part.data.size == (int(tours.size[uavs].sum()), uavs.size)

    before = rings.to_routes(tours)
    theirs = [v for k in uavs for v in before[k]]
    shuffled = np.random.default_rng(seed).permutation(len(theirs))
    new = tuple(tuple(piece.tolist()) for piece in np.array_split(shuffled, uavs.size))
    found = rings.from_routes(part.data.costs, new)
    decomposition.merge(data.costs, part.nodes, found, tours)
    after = rings.to_routes(tours)
    assert check_routes(instance, after) == []
    assert tours.cost == pytest.approx(tour_costs(instance, after))
    assert tours.cost[uavs] == pytest.approx(found.cost)
    for k in range(M):
        if k in uavs:
            assert after[k] == tuple(theirs[i] for i in new[uavs.tolist().index(k)])
        else:
            assert after[k] == before[k]
