"""Whole-number costs with many ties: what tells solutions of equal longest tours apart, and what pulls."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.search import tours as rings
from formulations.routing.search.costs import both_ways
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.energy import excess, fitness, p_norm
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import NeighbourhoodParameters, grain_of, problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.schedule import Schedule, ScheduleParameters
from formulations.routing.search.strategy import SEVERAL_DEPOTS
from instances import Instance

N, M = 12, 2
FLAT = Instance("flat", 3.0 - 3.0 * np.eye(N + M), N, M)
SCHEDULE = ScheduleParameters()
COLD = Schedule(SCHEDULE.founder, 8.0, SCHEDULE.final)


@pytest.mark.parametrize(
    ("costs", "grain"),
    [([4.0, 6.0], 2.0), ([3.0, 5.0], 1.0), ([0.0, 0.0], 0.0), ([1.0, 2.5], 0.0), ([1.0, 1e20], 0.0)],
)
def test_the_grain_is_the_greatest_common_divisor_of_whole_numbers(costs, grain):
    assert grain_of(both_ways(np.array([costs, costs[::-1]]))) == grain


def level(cost):
    """Return two tours of eight legs in all that cost as much each."""
    tours = rings.empty_tours(6, 2)
    tours.cost[:] = cost
    return tours


def test_a_coarse_grain_lowers_the_cap_to_the_next_tour_and_lets_the_mean_pull():
    _, fine = COLD.at(1.0, level(40.0), 40.0, SCHEDULE)
    temperature, coarse = COLD.at(1.0, level(40.0), 40.0, SCHEDULE, grain=1.0)
    assert fine.measure == excess(40.0 * (1.0 - SCHEDULE.final.margin))
    assert coarse.measure == excess(39.0)
    assert coarse.mean_weight == pytest.approx((SCHEDULE.grain_weight * 1.0 / 10.0) ** 2)
    assert temperature == pytest.approx(SCHEDULE.quiet * coarse.mean_weight * 1.0 / 2)
    assert COLD.at(0.0, level(40.0), 40.0, SCHEDULE, grain=1.0)[0] == COLD.at(0.0, level(40.0), 40.0, SCHEDULE)[0]


@pytest.mark.parametrize("cost", [0.0, 1.0, 1e6])
@pytest.mark.parametrize("done", [0.0, 0.5, 1.0])
def test_no_grain_and_no_length_of_tours_break_the_schedule(cost, done):
    for grain in (0.0, 1.0, 1e6):
        temperature, objective = COLD.at(done, level(cost), cost, SCHEDULE, grain)
        assert 0.0 <= temperature < np.inf
        assert SCHEDULE.mean_weight[1] * 0.99 <= objective.mean_weight <= SCHEDULE.most_weight


@pytest.mark.parametrize("measure", [p_norm(128), excess(10.0), excess(9.0)])
def test_of_equals_the_one_with_the_smaller_total_is_fitter(measure):
    assert fitness(np.array([10.0, 5.0, 4.0]), measure) < fitness(np.array([10.0, 5.0, 5.0]), measure)


def test_where_all_are_equally_near_tasks_have_different_neighbours():
    near = problem_data(both_ways(FLAT.cost), N, NeighbourhoodParameters(tasks=3)).near.tasks
    assert near.tolist() == [[(v + 1) % N, (v + 2) % N, (v + 3) % N] for v in range(N)]


@given(st.permutations(range(N)), st.integers(0, N))
@settings(deadline=None, max_examples=20)
def test_tours_turned_or_flown_by_another_uav_of_the_site_are_the_same(order, cut):
    costs, first, second = both_ways(FLAT.cost), tuple(order[:cut]), tuple(order[cut:])
    tours = rings.from_routes(costs, (first, second))
    together, apart = np.zeros(M, np.int64), np.arange(M)
    same = rings.from_routes(costs, (second[::-1], first))
    assert rings.broken_pairs(tours, same, together) == 0
    assert rings.broken_pairs(tours, same, apart) == len({*first[-1:]}) + len({*second[-1:]})


@pytest.mark.parametrize(
    ("barren", "since_restart", "least", "most"), [(0, 9, 0, 0), (12, 9, 10, 40), (99, 9, 30, 70), (99, 0, 0, 0)]
)
def test_annealings_are_compact_the_more_often_the_longer_nothing_was_new_but_founders_never(
    begun, barren, since_restart, least, most
):
    data = problem_data(both_ways(FLAT.cost), N, NeighbourhoodParameters())
    others = replace(SEVERAL_DEPOTS, compact=0.5, parting=None)  # it has no reheatings
    parameters = replace(SearchParameters(), one_site=others)
    population = Population(data, Endurance(FLAT, data.costs), parameters, seeded(2), None)
    count = sum(each._schedule.compact for each in begun(population, barren, since_restart))
    assert least <= count <= most


def choosing(cost, founders=3, apart=0.3):
    """Return a population of no members, and what gives it routes and says whether they are new and in."""
    data = problem_data(both_ways(cost), N, NeighbourhoodParameters())
    strategy = replace(SEVERAL_DEPOTS, apart=apart, short=None)
    parameters = replace(SearchParameters(), several_depots=strategy, one_site=strategy)
    population = Population(data, Endurance(FLAT, data.costs), parameters, seeded(1), None)
    population.family.founders, population.family.members = founders, []
    return population, lambda *routes: population.select(rings.from_routes(data.costs, routes))


def members(population):
    return [rings.to_routes(member) for member in population.family.members]


LONG, SHORT = (2, 3, 4, 5, 6, 7, 8), (0, 9, 1, 10, 11)


def test_a_population_keeps_equals_that_differ_and_of_copies_the_one_with_the_smaller_total():
    cost = FLAT.cost.copy()
    cost[0, 1] = 2.0
    population, select = choosing(cost)
    assert select(LONG, SHORT)
    assert not select(LONG[::-1], SHORT)
    assert not select(LONG, (9, 0, 1, 10, 11))
    assert members(population) == [(LONG, (9, 0, 1, 10, 11))]
    assert not select(LONG, SHORT)
    assert population.family.members[0].cost.sum() == 3.0 * (N + M) - 1.0
    assert not select((5, 0, 7, 2, 10, 3, 8), (4, 9, 6, 1, 11))
    assert len(population.family.members) == 2
    assert select((2, 0, 1, 3, 4, 5, 6), (7, 8, 9, 10, 11))
    assert len(population.family.members) == 3


def test_a_newcomer_near_members_replaces_all_of_them_or_none():
    cost = FLAT.cost.copy()
    cost[2, 3], cost[2, 4] = 2.0, 1.0
    population, select = choosing(cost, apart=0.5)
    stranger = (5, 0, 7, 2, 10, 3, 8), (4, 9, 6, 1, 11)
    one, other = (LONG, (0, 1, 9, 10, 11)), ((2, 3, 5, 4, 6, 7, 8), (0, 1, 9, 11, 10))
    select(*stranger)
    select(*one)
    population.family.members.append(rings.from_routes(population.data.costs, other))
    assert not select((3, 2, 5, 4, 6, 7, 8), (0, 1, 9, 10, 11))  # near both, and worse than either
    assert len(population.family.members) == 3
    better = (2, 4, 3, 5, 6, 7, 8), (0, 1, 9, 10, 11)
    assert select(*better)
    assert members(population) == [stranger, better]


def test_a_newcomer_near_no_member_replaces_the_worst_of_a_full_population_where_it_is_better():
    population, select = choosing(FLAT.cost, founders=2, apart=0.0)
    worst, better = ((*range(10),), (10, 11)), ((*range(9),), (9, 10, 11))
    assert select(*worst)
    assert select(*better)
    assert not select((*range(11),), (11,))
    assert select((7, 6, 0, 3, 1, 5, 2, 4), (11, 8, 10, 9))
    assert members(population) == [better, ((7, 6, 0, 3, 1, 5, 2, 4), (11, 8, 10, 9))]
