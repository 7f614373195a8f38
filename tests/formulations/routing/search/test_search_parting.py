"""Two tasks of the longest tour parted: who may still fly to them, and what such a search brings back."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.search import tours as rings
from formulations.routing.search.costs import both_ways, fleet_costs, leg, leg_into, search_costs
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.parting import PartingParameters, part_two, parted_costs
from formulations.routing.search.place_costs import PlaceCosts
from formulations.routing.search.population import Population
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.stages import next_stages
from formulations.routing.search.strategy import ONE_SITE, SEVERAL_DEPOTS
from instances import Instance, check_routes, makespan, tour_costs

NEAR, HOW = NeighbourhoodParameters(), PartingParameters()
N = 14


def instance_of(sites, seed, wind=0.2):
    """Tasks in a square and UAVs that start at numbered places of it."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, 100, (max(sites) + 1, 2))
    xy = np.vstack([rng.uniform(0, 100, (N, 2)), places[list(sites)]])
    ahead = xy[None] - xy[:, None]
    cost = np.maximum(np.hypot(ahead[..., 0], ahead[..., 1]) - wind * ahead[..., 0], 0.0)
    return Instance("parted", cost, N, len(sites))


def dealt(instance, seed):
    """Routes with the tasks dealt to the UAVs at random."""
    order = np.random.default_rng(seed).permutation(N)
    return tuple(tuple(map(int, order[k :: instance.n_depots])) for k in range(instance.n_depots))


def of_fleet(instance, factors):
    """Costs of a fleet, of classes that differ by a factor."""
    cost = np.stack([factor * instance.cost for factor in factors])
    return fleet_costs(cost, np.arange(instance.n_depots) % len(factors), np.ones(instance.n_depots))


@given(seed=st.integers(0, 10**6), fleet=st.booleans())
@settings(deadline=None, max_examples=30)
def test_a_uav_takes_longer_than_any_tour_to_its_banned_task_and_what_it_took_elsewhere(seed, fleet):
    instance = instance_of((0, 1, 2), seed)
    costs = of_fleet(instance, (1.0, 1.7)) if fleet else both_ways(instance.cost)
    banned = np.array([4, -1, 7])
    parted = parted_costs(costs, banned)
    most = sum(leg(costs, k, u, w) for k in range(3) for u in range(N + 3) for w in range(N + 3)) / (N + 3)
    for k, v in enumerate(banned):
        for u in range(N + 3):
            for w in range(N + 3):
                if u != w and v in (u, w):
                    assert min(leg(parted, k, u, w), leg_into(parted, k, w, u)) > most / 3 > 0.0
                else:
                    assert leg(parted, k, u, w) == leg_into(parted, k, w, u) == leg(costs, k, u, w)


@pytest.mark.parametrize("sites", [(0, 0, 0, 0), (0, 1, 2, 3), (0, 0, 1, 1)])
@pytest.mark.parametrize("seed", range(6))
def test_two_tasks_of_the_longest_tour_are_parted_and_no_uav_of_its_site_may_fly_both(sites, seed):
    instance = instance_of(sites, seed)
    data = problem_data(both_ways(instance.cost), N, NEAR)
    whole = rings.from_routes(data.costs, dealt(instance, seed))
    k, before = int(whole.cost.argmax()), rings.to_routes(whole)
    part = part_two(data, whole, HOW, seeded(seed))
    begun = rings.to_routes(part.best)
    assert not check_routes(instance, begun)
    np.testing.assert_allclose(part.best.cost, tour_costs(instance, begun))
    (left,) = set(before[k]) - set(begun[k])
    together = [
        stays
        for stays in before[k]
        if stays != left
        and all(
            rings.from_routes(part.data.costs, both_on(j, stays, left, len(sites))).cost[j] > instance.cost.sum() / N
            for j in range(len(sites))
            if sites[j] == sites[k]
        )
    ]
    assert len(together) == (1 if sites.count(sites[k]) > 1 else len(before[k]) - 1)
    assert part.tours.cost[k] > part.best.cost.sum()
    assert rings.to_routes(whole) == before


def both_on(j, one, other, m):
    """Routes of UAV j flying two tasks, of m UAVs of which the others stay."""
    return tuple((one, other) if i == j else () for i in range(m))


def test_of_some_tasks_drawn_the_farthest_are_parted():
    """Tasks on a line from the site: of a tour of many the nearest are hardly ever what is parted."""
    x = np.array([*range(1, N + 1), 0.0, 0.0])
    instance = Instance("line", np.abs(np.subtract.outer(x, x)), N, 2)
    data = problem_data(both_ways(instance.cost), N, NEAR)
    whole = rings.from_routes(data.costs, (tuple(range(N)), ()))
    left = [rings.to_routes(part_two(data, whole, HOW, seeded(seed)).best)[1][0] for seed in range(200)]
    assert np.mean(left) > 1.2 * (N - 1) / 2


def test_a_longest_tour_of_one_task_has_none_to_part():
    instance = instance_of((0, 0), 3)
    data = problem_data(both_ways(instance.cost), N, NEAR)
    whole = rings.empty_tours(N, 2)
    rings.fill(data.costs, whole, 0, np.array([5], np.int32))
    rings.sum_costs(whole)
    assert part_two(data, whole, HOW, seeded(1)) is None


def test_one_uav_long_tours_many_tasks_or_classes_and_costs_without_a_matrix_part_none():
    two = problem_data(both_ways(instance_of((0, 0), 1).cost), N, NEAR)
    assert HOW.suits(two)
    assert HOW._replace(tasks=N // 2).suits(two)
    assert not HOW._replace(tasks=N // 2 - 1).suits(two)
    assert not HOW.suits(problem_data(both_ways(instance_of((0,), 1).cost), N, NEAR))
    assert HOW._replace(entries=3 * (N + 2) ** 2).suits(two)
    assert not HOW._replace(entries=3 * (N + 2) ** 2 - 1).suits(two)
    fleet = problem_data(of_fleet(instance_of((0, 0), 1), (1.0, 1.7)), N, NEAR)
    assert HOW._replace(entries=4 * (N + 2) ** 2).suits(fleet)
    assert not HOW._replace(entries=4 * (N + 2) ** 2 - 1).suits(fleet)
    metric = {"metric": "euclidean"}
    places = np.random.default_rng(1).uniform(0, 9, (N + 2, 2))
    costs = search_costs(Instance.of_metric("places", metric, places, N, 2))
    assert isinstance(costs, PlaceCosts)
    assert not HOW.suits(problem_data(costs, N, NEAR))


@pytest.mark.parametrize(("sites", "fleet"), [((0, 0, 0, 0), False), ((0, 1, 2, 3), False), ((0, 1, 1, 2), True)])
def test_where_nothing_is_new_stages_part_tasks_and_bring_back_routes_of_the_whole(sites, fleet):
    instance = instance_of(sites, 5)
    always = PartingParameters(share=1.0)
    parameters = SearchParameters(
        one_site=replace(ONE_SITE, parting=always), several_depots=replace(SEVERAL_DEPOTS, parting=always)
    )
    costs = of_fleet(instance, (1.0, 1.0)) if fleet else both_ways(instance.cost)
    data = problem_data(costs, N, parameters.neighbourhood)
    population = Population(data, Endurance(instance, costs), parameters, seeded(5), None)
    population.plan(2e-6)
    now, parted = 0.0, 0
    while now < 1.0:
        population.advance(now, 20)
        now = population.end
        next_stages([population], now)
        part = population._newcomer.subproblem
        parted += part is not None and part.nodes.size == N + len(sites)
        for tours in (population.best, *population.family.members):
            routes = rings.to_routes(tours)
            assert not check_routes(instance, routes)
            np.testing.assert_allclose(tours.cost, tour_costs(instance, routes))
    assert parted > 5
    assert makespan(instance, rings.to_routes(population.best)) == pytest.approx(population.incumbent)


@pytest.mark.parametrize(("barren", "since_restart", "least", "most"), [(0, 9, 10, 35), (99, 9, 60, 80), (99, 0, 0, 0)])
def test_stages_part_tasks_the_more_often_the_longer_nothing_was_new_but_founders_never(
    begun, barren, since_restart, least, most
):
    instance = instance_of((0, 1, 2), 3)
    data = problem_data(both_ways(instance.cost), N, NEAR)
    population = Population(data, Endurance(instance, data.costs), SearchParameters(), seeded(2), None)
    stages = begun(population, barren, since_restart)
    parted = sum(each._newcomer.subproblem is not None for each in stages)
    assert least <= parted <= most
