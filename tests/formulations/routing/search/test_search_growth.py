"""Growth: the farthest tasks come first, nearer ones join on their way, and a chained search goes on from there."""

from dataclasses import replace

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.search.chained_search import ChainedSearch
from formulations.routing.search.costs import search_costs
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.growth import Growth, GrowthParameters
from formulations.routing.search.handover import HandoverParameters
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.tours import from_routes, to_routes
from instances import Instance, check_routes, makespan

FULL = SearchParameters()
SOON = HandoverParameters(uavs=0, many=40, few=5, founder=0.0, each=5, room=1e3)


def instance_of(points, m):
    """UAVs at the origin."""
    points = np.vstack([points, np.zeros((m, 2))])
    return Instance("grown", np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1)), len(points) - m, m)


def rays(m, each):
    """Tasks on m rays of one length from the origin: the best longest tour is the trip to the farthest and back."""
    angles, radii = 2.0 * np.pi * np.arange(m) / m, 100.0 * np.arange(1, each + 1) / each
    across = np.array([np.cos(angles), np.sin(angles)]).T
    return instance_of((across[:, None] * radii[None, :, None]).reshape(-1, 2), m)


def scattered(n, m, seed):
    return instance_of(np.random.default_rng(seed).uniform(-100.0, 100.0, (n, 2)), m)


def growth_of(instance, parameters=FULL.growth, seed=1):
    data = problem_data(search_costs(instance), instance.n_tasks, FULL.neighbourhood)
    return Growth(data, parameters, FULL.annealing, FULL.neighbourhood, seeded(seed))


def joined(growth):
    """The tasks that are on tours, by the numbers of the instance."""
    return {int(growth._nodes[v]) for route in to_routes(growth._tours) for v in route}


def trips(instance):
    n = instance.n_tasks
    return instance.cost[n, :n] + instance.cost[:n, n]


@pytest.mark.parametrize("seed", range(3))
def test_at_each_level_just_the_tasks_beyond_it_have_joined(seed):
    instance = scattered(60, 4, seed)
    growth, far = growth_of(instance), trips(instance) / trips(instance).max()
    for i, share in enumerate((*FULL.growth.levels, -1.0)):
        assert not growth.advance((i + 0.5) / 5, 50) or share < 0.0
        assert joined(growth) == set(np.flatnonzero(far > share).tolist())
        costs = growth._data.costs
        assert growth._tours.cost == pytest.approx(from_routes(costs, to_routes(growth._tours)).cost)
        assert (growth.longest < np.inf) == (share < 0.0)
    assert check_routes(instance, to_routes(growth.best())) == []
    assert makespan(instance, to_routes(growth.best())) == pytest.approx(growth.longest)


def test_tasks_that_join_leave_the_order_of_the_others_as_it_is():
    growth = growth_of(scattered(60, 4, 0))
    growth.advance(0.1, 200)
    numbers = growth._nodes
    before = [[int(numbers[v]) for v in route] for route in to_routes(growth._tours)]
    growth._next_level()
    then = [[int(growth._nodes[v]) for v in route] for route in to_routes(growth._tours)]
    old = {v for route in before for v in route}
    assert [[v for v in route if v in old] for route in then] == before
    assert sum(map(len, then)) > len(old)


@pytest.mark.parametrize("done", [0.0, 0.5, 1.0])
def test_all_tasks_join_though_there_were_no_steps_for_some_levels(done):
    instance = scattered(50, 3, 2)
    growth = growth_of(instance)
    growth.advance(done, 10)
    assert check_routes(instance, to_routes(growth.grown())) == []


def test_levels_without_tasks_of_their_own_and_tasks_at_the_depot_are_no_matter():
    instance = instance_of(np.array([[100.0, 0.0]] * 3 + [[0.0, 0.0]] * 2), 2)
    growth = growth_of(instance, GrowthParameters(levels=(1.0, 0.9, 0.5)))
    for done in (0.1, 0.4, 0.6, 0.9):
        growth.advance(done, 20)
    assert check_routes(instance, to_routes(growth.grown())) == []
    assert growth.longest == pytest.approx(200.0)


@pytest.mark.parametrize(("m", "each"), [(3, 8), (6, 6), (10, 5)])
def test_tours_along_rays_take_all_that_is_on_their_way(m, each):
    instance = rays(m, each)
    growth = growth_of(instance)
    for i in range(50):
        growth.advance(i / 50, 200)
    assert growth.longest == pytest.approx(200.0)


def test_the_cap_is_the_mean_tour_where_no_tour_can_be_as_short_as_the_farthest_trip():
    instance = scattered(120, 3, 5)
    growth = growth_of(instance)
    for i in range(50):
        growth.advance(i / 50, 200)
    cost = growth._tours.cost
    assert cost.mean() > 1.2 * trips(instance).max()
    assert cost.max() < 1.15 * cost.mean()  # under a cap no tour can keep the total alone would count


def population_of(instance):
    data = problem_data(search_costs(instance), instance.n_tasks, FULL.neighbourhood)
    start = from_routes(
        data.costs, tuple(tuple(instance.tasks[k :: instance.n_depots]) for k in range(instance.n_depots))
    )
    parameters = replace(FULL, handover=SOON)
    population = Population(data, Endurance(instance, data.costs), parameters, seeded(1), start)
    population.plan(1e-5)
    return population


def test_a_chained_search_goes_on_from_the_grown_tours_though_better_ones_are_known():
    instance = scattered(60, 6, 3)
    population = population_of(instance)
    better = Memetic().solve(instance, limits=Limits(time=60.0, iterations=20_000)).routes
    population.begin(0.1)
    growth = population._chained
    assert isinstance(growth, Growth)
    population.advance(0.1, 10)
    population.best = from_routes(population.data.costs, better)
    population.begin(population.end)
    assert isinstance(population._chained, ChainedSearch)
    assert population._chained.longest == pytest.approx(growth.grown().cost.max())
    assert population._chained.longest > population.incumbent
    assert population.incumbent == pytest.approx(makespan(instance, better))


def test_better_tours_are_told_of_as_soon_as_all_tasks_have_joined():
    instance = rays(6, 10)
    population = population_of(instance)
    before = population.incumbent
    population.begin(0.1)
    for i in range(40):
        population.advance(0.1 + (population.end - 0.1) * i / 40, 200)
    assert population.incumbent < before
    assert check_routes(instance, to_routes(population.best)) == []


def test_a_search_whose_farthest_task_decides_grows_tours_and_is_repeatable():
    class Soon(Memetic):
        parameters = replace(FULL, handover=SOON)

    instance, limits = rays(8, 12), Limits(time=60.0, iterations=60_000)
    runs = [Soon().solve(instance, limits=limits, seed=3) for _ in range(2)]
    assert runs[0].routes == runs[1].routes
    assert makespan(instance, runs[0].routes) == pytest.approx(200.0)
