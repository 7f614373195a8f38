"""When a population gives way to edge assembly or a chained search, and what that makes of its tours."""

from dataclasses import replace

import numpy as np
import pytest

from formulations.routing.search.chained_search import ChainedSearch
from formulations.routing.search.costs import both_ways, search_costs
from formulations.routing.search.edge_assembly import EdgeAssembly
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.handover import HandoverParameters
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.tours import to_routes
from instances import Instance, check_routes

FULL = SearchParameters()
HOW = HandoverParameters(uavs=0, many=40, few=10, founder=0.0, early=0.3, each=10, after=0.6)


def one_site(n, m):
    """Random points, the m UAVs at one of them."""
    points = np.random.default_rng(9).uniform(0.0, 100.0, (n + m, 2))
    points[n:] = points[n]
    return Instance("one-site", np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1)), n, m)


def population_of(instance, how):
    """A population of some members that knows how long founders are."""
    data = problem_data(search_costs(instance), instance.n_tasks, FULL.neighbourhood)
    population = Population(data, Endurance(instance, data.costs), replace(FULL, handover=how), seeded(1), None)
    population.plan(1e-5)
    population.family.members = [population.best, population.best]
    return population


@pytest.mark.parametrize(
    ("changed", "now", "first"),
    [
        ({}, 0.4, 2.0 * 4 * 40**0.5),
        ({"heat": 0.0}, 0.4, FULL.chain.first),
        ({}, 0.2, None),
        ({"each": 11}, 0.7, 0.2),
        ({"each": 11}, 0.5, None),
        ({"each": 11, "after": 0.5}, 0.5, 0.2),
        ({"many": 41}, 0.9, None),
        ({"few": 11}, 0.9, None),
        ({"founder": 0.9}, 0.9, None),
    ],
)
def test_a_chained_search_takes_over_early_and_hot_where_tours_are_long(changed, now, first):
    how = replace(HOW, heat=2.0) if not changed else replace(HOW, **changed)
    instance = one_site(40, 4)
    population = population_of(instance, how)
    population.begin(now)
    search, before = population._chained, population.incumbent
    assert (search is not None) == (first is not None)
    if first is not None:
        assert isinstance(search, ChainedSearch)
        assert search._parameters.first == first
        assert search.longest == pytest.approx(before)
        population.advance(0.9, 400)
        assert population.incumbent <= before
        population.grow_up()
        population.take_in()
        assert check_routes(instance, to_routes(population.best)) == []


def test_where_founders_are_as_long_as_the_limit_it_begins_soon():
    population = population_of(one_site(40, 4), HOW)
    population.family.founder = 1.0
    population.plan(5e-5)
    assert population.end == pytest.approx(HOW.begin)
    population.begin(HOW.begin)
    assert isinstance(population._chained, ChainedSearch)
    assert population._chained._parameters.last == HOW.last
    short = population_of(one_site(40, 4), replace(HOW, each=11))
    short.family.founder = 1.0
    short.plan(5e-5)
    assert short.end > HOW.begin


@pytest.mark.parametrize(("pair", "fits"), [(9.0, True), (60.0, False)])  # 40² pairs, 1e-5 of the limit each step
@pytest.mark.parametrize("how", [HOW, HandoverParameters(fewest=10, for_each=0)])
def test_where_candidate_legs_take_too_long_the_population_goes_on(how, pair, fits):
    population = population_of(one_site(40, 4), replace(how, pair=pair, most=0.5))
    population.begin(0.7)
    assert (population._chained is not None) == fits


def test_few_uavs_are_edge_assemblys():
    population = population_of(one_site(40, 4), HandoverParameters(fewest=10, for_each=0))
    assert population.end == pytest.approx(HandoverParameters().begin)
    population.begin(0.05)
    assert isinstance(population._chained, EdgeAssembly)


def test_long_tours_from_one_site_are_edge_assemblys():
    instance = one_site(30, 2)
    costs = search_costs(instance)

    def suited(costs, fewest, for_each=0, uavs=2):
        return HandoverParameters(uavs=uavs, fewest=fewest, for_each=for_each).assembles(costs, instance.n_tasks)

    assert suited(costs, 15)
    assert HandoverParameters(fewest=15, for_each=0).ever(costs, instance.n_tasks)
    assert not HandoverParameters(fewest=16).ever(costs, instance.n_tasks)
    assert not suited(costs, 16)
    assert suited(costs, 1, for_each=7)
    assert not suited(costs, 1, for_each=8)
    assert not suited(costs, 15, uavs=1)
    windy = instance.cost * np.random.default_rng(0).uniform(1.0, 1.2, instance.cost.shape)
    assert not suited(both_ways(windy), 15)
    apart = np.array(instance.cost)
    apart[-1, :-1] = apart[:-1, -1] = 50.0
    assert not suited(both_ways(apart), 15)
