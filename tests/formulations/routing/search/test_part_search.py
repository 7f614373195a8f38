"""Searches of parts: the longest tour with some near it, one part after the other, and when they begin."""

from dataclasses import replace

import numpy as np
import pytest

from formulations.routing.search.chained_search import ChainedSearch
from formulations.routing.search.costs import search_costs
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.growth import Growth
from formulations.routing.search.handover import HandoverParameters
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.part_search import PartParameters, PartSearch
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.tours import from_routes, to_routes
from instances import Instance, check_routes, makespan

FULL = SearchParameters()
HOW = HandoverParameters(uavs=0, many=40, few=5, founder=0.0, early=0.3, each=5, after=0.6)
TURNS = (0.7, 0.8, 0.9, 1.0)


def one_site(n, m, far):
    """Random points, the m UAVs at one of them, and a last task `far` away."""
    points = np.random.default_rng(4).uniform(0.0, 100.0, (n + m, 2))
    points[n:] = points[n]
    points[n - 1] = points[n] + far
    return Instance("one-site", np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1)), n, m)


def population_of(instance, how=HOW, seed=1):
    data, tasks = problem_data(search_costs(instance), instance.n_tasks, FULL.neighbourhood), instance.tasks
    start = from_routes(data.costs, tuple(tuple(tasks[k :: instance.n_depots]) for k in range(instance.n_depots)))
    parameters = replace(FULL, handover=how)
    population = Population(data, Endurance(instance, data.costs), parameters, seeded(seed), start)
    population.plan(1e-5)
    return population


def grown_of(instance, how=HOW, parts=FULL.parts):
    """A population whose tours, where the farthest task decides, have grown anew."""
    population = population_of(instance, how)
    population.parameters = replace(population.parameters, parts=parts)
    population.begin(0.5)
    assert isinstance(population._chained, Growth)
    assert population.end == pytest.approx(0.5 + 0.5 * how.grown)
    return population


@pytest.mark.parametrize(("far", "end"), [(0.0, 1.0), (1000.0, 0.7)])
def test_they_take_turns_with_a_chained_search_that_did_not_begin_hot(far, end):
    instance = one_site(40, 8, far)
    how = replace(HOW, turns=TURNS)
    population = grown_of(instance, how) if far else population_of(instance, how)
    population.begin(0.65)
    assert isinstance(population._chained, ChainedSearch)
    assert population.end == end
    if far:
        for now, kind, until in ((0.7, PartSearch, 0.8), (0.8, ChainedSearch, 0.9), (0.9, PartSearch, 1.0)):
            before = population.incumbent
            population.begin(now)
            assert isinstance(population._chained, kind)
            assert population.end == until
            assert population._chained.longest == pytest.approx(before)
            for i in range(20):
                population.advance(now + (until - now) * i / 20, 400)
            assert population.incumbent <= before
            assert makespan(instance, to_routes(population.best)) == pytest.approx(population.incumbent)


def test_the_search_after_parts_is_not_hot_though_the_longest_tour_changed():
    population = grown_of(one_site(40, 8, 1000.0), replace(HOW, turns=TURNS))
    for now in (0.65, 0.7):
        population.begin(now)
    population.parameters = replace(population.parameters, handover=replace(HOW, turns=TURNS, room=0.0))
    population.begin(0.8)
    assert population._chained._parameters.first == HOW.reheated


def test_where_there_is_no_time_to_prepare_them_the_chained_search_goes_on():
    how = replace(HOW, turns=(0.7, 0.8, 0.99, 1.0))  # 40² pairs, 1e-5 of the limit each
    population = grown_of(one_site(40, 8, 1000.0), how)
    population.parameters = replace(population.parameters, handover=replace(how, pair=0.6))
    population.begin(0.65)
    assert isinstance(population._chained, ChainedSearch)
    assert population.end == 1.0


@pytest.mark.parametrize(("tasks", "end"), [(29, 1.0), (30, 0.7)])  # six tours of 40 / 8 tasks
def test_of_long_tours_there_are_no_parts(tasks, end):
    population = grown_of(one_site(40, 8, 1000.0), replace(HOW, turns=TURNS), PartParameters(tasks=tasks))
    population.begin(0.65)
    assert population.end == end


@pytest.mark.parametrize(("now", "end"), [(0.7, 0.9), (0.85, 0.9), (0.95, 1.0)])
def test_a_chained_search_that_begins_late_has_the_next_turn_there_is(now, end):
    population = grown_of(one_site(40, 8, 1000.0), replace(HOW, turns=TURNS))
    population.begin(now)
    assert population.end == end


@pytest.mark.parametrize("m", [2, 8, 12])
@pytest.mark.parametrize("seed", range(2))
def test_the_longest_tour_only_becomes_shorter_and_much_so(m, seed):
    instance = one_site(72, m, 150.0)
    population = population_of(instance, seed=seed)
    search, first = PartSearch(population, PartParameters(tours=4, parts=3)), population.incumbent
    longest, parts = first, set()
    for i in range(300):
        better = search.advance(i / 300, 250)
        parts.add(search._part.begin)
        assert better == (search.longest < longest)
        longest = search.longest
        if better:
            population.best = search.best()
        assert search._part.of.nodes.size < instance.n_nodes or m <= 4
        assert population.incumbent == pytest.approx(longest)
    assert len(parts) == 3
    routes = to_routes(search.best())
    assert check_routes(instance, routes) == []
    assert makespan(instance, routes) == pytest.approx(longest)
    assert longest < 0.8 * first


def test_the_last_part_goes_on_where_the_limit_is_overrun():
    population = population_of(one_site(72, 8, 150.0))
    search = PartSearch(population, PartParameters(tours=3, parts=2))
    for done in (0.0, 0.6, 1.0, 1.0):
        search.advance(done, 5000)
    assert search._part.begin == 0.6


def test_a_part_is_of_the_best_tours_the_longest_among_them():
    population = population_of(one_site(72, 8, 150.0))
    search = PartSearch(population, PartParameters(tours=3, parts=1))
    search.advance(0.0, 1)
    tours, part = population.best, search._part.of
    assert 72 + int(tours.cost.argmax()) in part.nodes
    assert (part.nodes >= 72).sum() == 3
    served = {int(tours.tour[v]) + 72 for v in part.nodes if v < 72}
    assert served == set(part.nodes[part.nodes >= 72].tolist())


def test_a_crowd_far_out_is_searched_with_tours_from_anywhere():
    rng = np.random.default_rng(0)
    points = np.concatenate([rng.uniform(0, 1, (30, 2)) + 1000.0, rng.uniform(0, 100, (90, 2)), np.zeros((4, 2))])
    instance = Instance("crowd", np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1)), 120, 4)
    population = population_of(instance)
    crowd, others = tuple(range(30)), range(30, 120)
    routes = (crowd, *(tuple(others[k::3]) for k in range(3)))
    population.best = from_routes(population.data.costs, routes)
    search = PartSearch(population, PartParameters(tours=3, parts=1))
    assert (search._part.of.nodes >= 120).sum() == 3
    assert 120 in search._part.of.nodes


def test_nothing_is_handed_over_within_a_part():
    population = population_of(one_site(72, 8, 1000.0), replace(HOW, uavs=7, fewest=1, for_each=0))
    search = PartSearch(population, PartParameters(tours=4, parts=1))
    for i in range(200):
        search.advance(i / 200, 250)
        assert search._part.population._chained is None
