"""Many UAVs at one site: annealings under a cap, and tours searched beside a trimmed one."""

from dataclasses import replace

import numpy as np
import pytest

from formulations.routing.search import tours as rings
from formulations.routing.search.costs import both_ways
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.energy import energy
from formulations.routing.search.packing import CappedSchedule, Packing
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.stages import next_stages
from formulations.routing.search.strategy import ONE_SITE, SEVERAL_DEPOTS
from formulations.routing.search.trimming import TrimmingParameters, trim
from instances import Instance, check_routes, makespan, tour_costs

NEAR, HOW, MANY = NeighbourhoodParameters(), TrimmingParameters(), Packing().uavs


def at_one_site(n, m, seed, wind=0.2):
    rng = np.random.default_rng(seed)
    xy = np.vstack([rng.uniform(0, 100, (n, 2)), np.full((m, 2), 50.0)])
    leg = xy[None] - xy[:, None]
    cost = np.maximum(np.hypot(leg[..., 0], leg[..., 1]) - wind * leg[..., 0], 0.0)
    return Instance("one site", cost, n, m)


def dealt(instance, seed):
    """Routes with the tasks dealt to the UAVs at random."""
    order = np.random.default_rng(seed).permutation(instance.n_tasks)
    return tuple(tuple(map(int, order[k :: instance.n_depots])) for k in range(instance.n_depots))


def new_population(instance, seed, parameters=None):
    costs = both_ways(instance.cost)
    parameters = parameters or SearchParameters()
    data = problem_data(costs, instance.n_tasks, parameters.neighbourhood)
    return Population(data, Endurance(instance, costs), parameters, seeded(seed), None)


def packed(**changed):
    """Parameters of a search that packs however near the farthest task is."""
    return SearchParameters(one_site=replace(ONE_SITE, packing=Packing(room=np.inf, **changed)))


@pytest.mark.parametrize("done", [0.0, 0.3, 1.0])
def test_a_capped_annealing_lowers_the_total_and_what_exceeds_a_cap_below_the_incumbent(done):
    instance = at_one_site(20, 4, 1)
    tours = rings.from_routes(both_ways(instance.cost), dealt(instance, 1))
    schedule = CappedSchedule(first=1.0, last=0.1, weight=0.02, margin=0.01)
    incumbent = 0.9 * tours.cost.max()
    temperature, objective = schedule.at(done, tours, incumbent, SearchParameters().schedule)
    over = np.maximum(tours.cost - 0.99 * incumbent, 0.0).sum()
    assert energy(tours.cost, objective) == pytest.approx(0.02 * tours.cost.sum() + over)
    assert temperature == pytest.approx(0.02 * 0.1**done * tours.cost.sum() / 24)
    assert schedule.strings == 1.0


def test_on_plateaus_the_cap_is_the_next_longest_tour_that_can_be_had():
    instance = at_one_site(20, 4, 1)
    tours = rings.from_routes(both_ways(instance.cost), dealt(instance, 1))
    _, objective = CappedSchedule(1.0, 0.1, 0.02, 1e-3).at(0.5, tours, 50.0, SearchParameters().schedule, grain=1.0)
    assert objective.measure.cap == 49.0


@pytest.mark.parametrize("seed", range(8))
def test_the_longest_tour_gives_tasks_to_others_until_it_is_short_enough_and_then_the_next(seed):
    instance = at_one_site(30, 5, seed)
    data = problem_data(both_ways(instance.cost), 30, NEAR)
    tours, rng = rings.from_routes(data.costs, dealt(instance, seed)), seeded(seed)
    aside, most = np.zeros(5, np.bool_), 0.8 * tours.cost.max()
    first = int(tours.cost.argmax())
    trim(data.costs, data.near, tours, aside, most, HOW, rng)
    assert np.flatnonzero(aside).tolist() == [first]
    trimmed = rings.to_routes(tours)[first]
    assert tours.cost[first] <= most
    trim(data.costs, data.near, tours, aside, most, HOW, rng)
    assert aside.sum() == 2
    routes = rings.to_routes(tours)
    assert not check_routes(instance, routes)
    assert routes[first] == trimmed
    assert (tours.cost[aside] <= most).all()
    np.testing.assert_allclose(tours.cost, tour_costs(instance, routes))


def test_no_more_is_given_away_than_has_to_be():
    instance = at_one_site(30, 5, 3)
    data = problem_data(both_ways(instance.cost), 30, NEAR)
    tours = rings.from_routes(data.costs, dealt(instance, 3))
    k = int(tours.cost.argmax())
    before = rings.to_routes(tours)
    trim(data.costs, data.near, tours, np.zeros(5, np.bool_), tours.cost[k] - 1e-6, HOW, seeded(0))
    after = rings.to_routes(tours)
    assert len(after[k]) == len(before[k]) - 1
    trim(data.costs, data.near, tours, np.zeros(5, np.bool_), tours.cost.max(), HOW, seeded(0))
    assert rings.to_routes(tours) == after


def test_tasks_near_trimmed_tours_alone_go_to_a_uav_that_is_not_set_aside():
    instance = at_one_site(6, 3, 2)
    data = problem_data(both_ways(instance.cost), 6, NEAR)
    tours = rings.from_routes(data.costs, ((0, 1, 2), (3, 4, 5), ()))
    aside = np.array([False, True, False])
    trim(data.costs, data.near, tours, aside, 0.0, HOW, seeded(1))
    routes = rings.to_routes(tours)
    assert (routes[0], routes[1], sorted(routes[2])) == ((), (3, 4, 5), [0, 1, 2])


@pytest.mark.parametrize(("m", "strategy", "packs"), [(MANY, ONE_SITE, True), (MANY - 1, ONE_SITE, False)])
def test_only_many_uavs_at_one_site_pack(m, strategy, packs):
    assert (new_population(at_one_site(24, m, 1), 1).strategy.packing is not None) == packs
    assert strategy.packing is not None
    assert SEVERAL_DEPOTS.packing is None


def test_they_pack_where_the_farthest_task_leaves_little_time_for_others():
    instance = at_one_site(24, MANY, 1)
    data = problem_data(both_ways(instance.cost), 24, NEAR)
    farthest = max(instance.cost[24, v] + instance.cost[v, 24] for v in range(24))
    packing = Packing(room=1.05)
    assert packing.leaves_little(1.05 * farthest - 1e-9, data)
    assert not packing.leaves_little(1.05 * farthest + 1e-9, data)
    never = SearchParameters(one_site=replace(ONE_SITE, packing=Packing(room=0.0)))
    for newcomer, schedule in stages(new_population(instance, 5, never), 2e-6):
        assert newcomer.aside is None
        assert not isinstance(schedule, CappedSchedule)


def stages(population, step):
    """The newcomers and schedules of the stages of a search of steps that take so much of the limit each."""
    population.plan(step)
    now = 0.0
    while now < 1.0:
        population.advance(now, 20)
        now = population.end
        next_stages([population], now)
        yield population._newcomer, population._schedule


def test_stages_are_capped_or_reheat_or_search_the_tours_beside_a_trimmed_one():
    instance = at_one_site(24, MANY, 5)
    population = new_population(instance, 5, packed())
    capped = trimmed = reheated = 0
    for newcomer, schedule in stages(population, 5e-7):
        capped += isinstance(schedule, CappedSchedule)
        reheated += newcomer.first == ONE_SITE.reheating.first and schedule.final == ONE_SITE.fine
        if newcomer.aside is not None:
            trimmed += 1
            part = newcomer.subproblem
            assert newcomer.tours.cost.size == MANY - newcomer.aside.sum()
            flown = {v for k in np.flatnonzero(newcomer.aside) for v in rings.to_routes(part.whole)[k]}
            assert flown.isdisjoint(part.nodes.tolist())
            assert (part.whole.cost[newcomer.aside] < population.incumbent).all()
    assert min(capped, trimmed, reheated) > 5
    assert not check_routes(instance, rings.to_routes(population.best))
    assert makespan(instance, rings.to_routes(population.best)) == pytest.approx(population.incumbent)


def test_capped_founders_are_the_fewer_the_seldomer_they_are_new():
    how = Packing(founders=0.4, seldom=0.05)
    assert [how.share_of_founders(rate) for rate in (1.0, 0.5, 0.2, 0.0)] == pytest.approx([0.4, 0.4, 0.2, 0.04])
    population = new_population(at_one_site(24, MANY, 5), 5, packed(reheated=0.0))
    rates = [population.family.packed.rate for _ in stages(population, 5e-7)]
    assert min(rates) < 0.3


@pytest.mark.parametrize(("over", "follows"), [(0.5 * HOW.near, True), (2.0 * HOW.near, False), (0.0, False)])
def test_a_second_tour_is_trimmed_where_the_others_nearly_fit(over, follows):
    parameters = packed(trimming=HOW._replace(share=0.0), reheated=0.0, founders=0.0, others=0.0)
    instance = at_one_site(24, MANY, 6)
    population = new_population(instance, 6, parameters)
    population.plan(1e-6)
    population.family.members = [population.best] * 8
    population.family.since_restart = 8
    aside = np.zeros(MANY, np.bool_)
    aside[int(population.best.cost.argmin())] = True
    tours = rings.duplicate(population.best)
    tours.cost[int(tours.cost.argmax())] *= 1.0 + over
    population._newcomer = replace(population._newcomer, tours=tours, aside=aside)
    population.begin(0.5)
    now = population._newcomer.aside
    assert (now is not None) == follows
    assert not follows or (now.sum() == 2 and now[aside].all())
