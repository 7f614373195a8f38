"""Costs of a fleet as the kernels read them, and endurance kept by scaling them."""

from dataclasses import replace

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.registry import make_solver
from formulations.routing.search import tours as rings
from formulations.routing.search.costs import (
    FleetCosts,
    forbidden,
    kinds,
    least,
    leg,
    leg_into,
    part_of,
    search_costs,
)
from formulations.routing.search.endurance import Endurance
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from instances import Instance, Travel, objective, tour_costs

N, M = 8, 3
INF = float("inf")


def fleet(seed=0, endurance=None):
    """UAVs 0 and 2 are alike; UAV 1 is slower and cannot fly to task 3."""
    fast = np.random.default_rng(seed).uniform(1.0, 100.0, (N + M, N + M)) * (1.0 - np.eye(N + M))
    slow = 1.5 * fast
    slow[:N, 3] = slow[N:, 3] = np.inf
    slow[3, 3] = 0.0
    return Instance.of_travel("fleet", Travel.of_uavs([fast, slow, fast]), N, endurance=endurance)


def routes_of(seed):
    routes = [[] for _ in range(M)]
    rng = np.random.default_rng(seed)
    for v in rng.permutation(N):
        routes[rng.choice([0, 2] if v == 3 else range(M))].append(int(v))
    return tuple(map(tuple, routes))


def test_legs_are_those_of_the_uav_and_those_it_cannot_fly_outlast_any_tour():
    instance = fleet()
    costs = search_costs(instance)
    for k in range(M):
        own = np.where(np.isfinite(instance.uav_cost(k)), instance.uav_cost(k), forbidden(instance))
        assert [[leg(costs, k, u, w) for w in range(N + M)] for u in range(N + M)] == own.tolist()
        assert [[leg_into(costs, k, w, u) for w in range(N + M)] for u in range(N + M)] == own.tolist()
    flown = instance.class_costs[np.isfinite(instance.class_costs)]
    assert forbidden(instance) > (N + 1) * flown.max()


@pytest.mark.parametrize("seed", range(5))
def test_rings_know_what_each_uav_takes(seed):
    instance, routes = fleet(seed), routes_of(seed)
    tours = rings.from_routes(search_costs(instance), routes)
    assert tours.cost == pytest.approx(tour_costs(instance, routes))
    assert rings.to_routes(tours) == routes


def test_some_of_a_fleet_keep_their_classes_and_scales():
    endurance = Endurance(fleet(endurance=(INF, 50.0, 80.0)), search_costs(fleet()))
    endurance.refer(200.0)
    part = part_of(endurance.costs, np.array([1, 4, N + 2, N + 1]), np.array([2, 1]))
    assert isinstance(part, FleetCosts)
    for own, k in enumerate((2, 1)):
        assert leg(part, own, 0, 1) == leg(endurance.costs, k, 1, 4)
        assert leg(part, own, 2 + own, 0) == leg(endurance.costs, k, N + k, 1)


def test_near_is_what_the_fastest_flies_and_from_a_depot_its_own_uav():
    instance = fleet()
    anyones, slow = least(search_costs(instance)), instance.uav_cost(1)
    assert anyones.out[0, 1] == instance.uav_cost(0)[0, 1]
    assert anyones.out[N + 1, 0] == slow[N + 1, 0]
    assert anyones.into[N + 1, 0] == slow[0, N + 1]


def test_uavs_are_exchanged_only_with_those_of_the_same_place_class_and_endurance():
    place = [*range(N), N, N, N]
    fast = fleet().uav_cost(0)[np.ix_(place, place)]
    near = NeighbourhoodParameters()
    for speeds, limits, site in (
        ((1.0, 1.0, 1.0), None, [0, 0, 0]),
        ((1.0, 1.5, 1.0), None, [0, 1, 0]),
        ((1.0, 1.0, 1.0), (INF, 60.0, INF), [0, 1, 0]),
    ):
        travel = Travel.of_uavs([fast * speed for speed in speeds])
        instance = Instance.of_travel("one place", travel, N, endurance=limits)
        endurance = Endurance(instance, search_costs(instance))
        endurance.refer(endurance.most)
        assert problem_data(endurance.costs, N, near).site.tolist() == site
    assert kinds(search_costs(instance), M).tolist() == [0, 0, 0]


@pytest.mark.parametrize("seed", range(20))
def test_scaled_tours_within_the_reference_are_those_within_it_and_endurance(seed):
    routes, rng = routes_of(seed), np.random.default_rng(seed)
    lengths = tour_costs(fleet(seed), routes)
    limits = np.maximum(lengths, 1.0) * rng.choice([0.7, 0.999, 1.0, 1.001, 3.0, INF], M)
    instance = fleet(seed, limits)
    endurance = Endurance(instance, search_costs(instance))
    for reference in (lengths.max() * 0.99, lengths.max(), lengths.max() * 1.5, endurance.most):
        endurance.refer(reference)
        scaled = rings.from_routes(endurance.costs, routes).cost.max()
        within = objective(instance, routes) <= reference
        assert (scaled <= reference * (1 + 1e-12)) == within


def test_the_reference_falls_to_routes_that_can_be_flown_and_tours_are_priced_anew():
    routes = routes_of(1)
    lengths = tour_costs(fleet(1), routes)
    instance = fleet(1, np.array([INF, 2.0 * lengths[1] + 1.0, 0.5 * lengths[2]]))
    endurance = Endurance(instance, search_costs(instance))
    endurance.refer(endurance.most)
    tours = rings.from_routes(endurance.costs, routes)
    assert not endurance.follow(tours.cost)
    assert endurance.reference == endurance.most
    generous = Endurance(fleet(1, 1.1 * lengths + 1.0), search_costs(instance))
    generous.refer(generous.most)
    tours = rings.from_routes(generous.costs, routes)
    assert generous.follow(tours.cost)
    assert generous.reference == pytest.approx(lengths.max())
    rings.reprice(generous.costs, tours)
    assert tours.cost == pytest.approx(rings.from_routes(generous.costs, routes).cost)
    assert tours.cost.max() <= lengths.max() * (1 + 1e-12)
    assert not generous.follow(tours.cost)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.slow
def test_memetic_finds_a_proved_optimum_under_endurance(threads):
    """Speeds 20 and 30 m/s, 12 tasks: subset-dp proves it, and that batteries of a third of it leave no routes."""
    places = np.random.default_rng(3).uniform(0, 20000, (14, 2))
    legs = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    free = Instance.of_travel("free", Travel.of_uavs([legs / 20, legs / 30]), 12)
    exact, search = make_solver("subset-dp"), make_solver("memetic")
    optimum = exact.solve(free, limits=Limits(time=600)).objective
    for limits in ((INF, 0.9 * optimum), (optimum / 3, optimum / 3)):
        instance = replace(free, endurance=np.array(limits))
        proof = exact.solve(instance, limits=Limits(time=600)).objective
        found = search.solve(instance, limits=Limits(time=600, iterations=40_000, threads=threads)).objective
        assert found == (proof and pytest.approx(proof))
        assert (proof is None) == (limits[0] < optimum)
