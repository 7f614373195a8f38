"""Potentials of legs, and what is near under them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from formulations.routing.search.costs import both_ways, fleet_costs
from formulations.routing.search.leg_potentials import PotentialParameters, _balanced, left_of, leg_potentials
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data

N, M = 14, 3
USUAL = PotentialParameters()


def matrix(seed, n=N + M):
    cost = np.random.default_rng(seed).uniform(1.0, 10.0, (n, n))
    np.fill_diagonal(cost, 0.0)
    return cost


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_what_tasks_cost_whichever_leg_is_flown_leaves_nothing(seed):
    cost, extra = matrix(seed), np.random.default_rng(seed + 1).uniform(-5.0, 50.0, (2, N + M))
    dearer = cost + extra[0][:, None] + extra[1]
    np.fill_diagonal(dearer, 0.0)
    left = []
    for legs in (cost, dearer):
        found = _balanced(both_ways(legs), N, 0.5, 400)
        left.append(left_of(both_ways(legs), found, N).out[:N, :N])
    off = ~np.eye(N, dtype=bool)
    assert left[0][off] == pytest.approx(left[1][off], abs=1e-6)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), temperature=st.sampled_from([0.01, 0.1]))
def test_potentials_add_up_to_the_cheapest_assignment_but_for_the_softness(seed, temperature):
    cost = matrix(seed)
    found = _balanced(both_ways(cost), N, temperature, 2000)
    forbidden = cost.copy()
    np.fill_diagonal(forbidden, 1e6)
    forbidden[N:, N:] = 1e6
    cheapest = forbidden[linear_sum_assignment(forbidden)].sum()
    softness = temperature * (N + M) * np.log(N + M)
    assert cheapest - softness <= found.sum() <= cheapest + softness


def test_a_task_dear_to_reach_is_near_those_it_is_dear_to_reach_from_least():
    places = np.arange(20.0)
    cost = np.abs(places[:, None] - places)
    dear = cost.copy()
    dear[:, 5] += 50.0
    dear[5, :] += 30.0
    dear[5, 5] = 0.0
    how = NeighbourhoodParameters(tasks=4)
    plain, found = (problem_data(both_ways(legs), 18, how).near.tasks for legs in (cost, dear))
    assert {4, 6} <= set(found[5].tolist())
    assert 5 in found[4]
    assert 5 in found[6]
    assert set(plain[0].tolist()) == set(found[0].tolist()) == {1, 2, 3, 4}


def test_a_part_is_searched_under_the_potentials_of_the_whole():
    cost, how = both_ways(matrix(3)), NeighbourhoodParameters(tasks=4)
    whole = problem_data(cost, N, how)
    assert whole.potentials.any()
    again = problem_data(cost, N, how, whole.potentials)
    np.testing.assert_array_equal(again.near.tasks, whole.near.tasks)
    plain = problem_data(cost, N, how, np.zeros((2, N + M)))
    assert (plain.near.tasks != whole.near.tasks).any()
    np.testing.assert_array_equal(plain.near.depots, whole.near.depots)


def test_there_are_none_where_costs_are_symmetric_nodes_too_many_or_legs_cost_nothing():
    some, nothing = matrix(1), np.zeros((8, 8))
    nothing[6, 0] = 1.0
    assert leg_potentials(both_ways(some), N, USUAL).any()
    assert not leg_potentials(both_ways(some + some.T), N, USUAL).any()
    assert not leg_potentials(both_ways(nothing), 6, USUAL).any()
    assert not leg_potentials(both_ways(some), N, USUAL._replace(most=N)).any()
    assert not leg_potentials(both_ways(matrix(1, 1)), 0, USUAL).any()


def test_a_fleet_of_symmetric_classes_has_none():
    cost = matrix(2, 8)
    fleet = np.stack([cost + cost.T, 2.0 * (cost + cost.T)])
    data = problem_data(fleet_costs(fleet, np.array([0, 1]), np.ones(2)), 6, NeighbourhoodParameters(tasks=4))
    assert not data.potentials.any()
