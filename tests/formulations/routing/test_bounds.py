"""Lower bounds: closed forms, brute force of their parts, and never above the optimum."""

from collections.abc import Callable
from dataclasses import replace
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing import bounds
from formulations.routing.bounds import lower_bounds
from formulations.routing.greedy import greedy_routes
from formulations.routing.simple_bounds import (
    SIMPLE,
    arborescence,
    assignment,
    cheapest_arborescence,
    farthest,
    least_sum,
    ways_between_tasks,
    ways_from_depot,
    worst_makespan,
)
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Routes, Travel, makespan, tour_costs

Fleets = Callable[..., Instance]
Oracle = Callable[[Instance], tuple[float, Routes]]


def random_instance(n: int, m: int, seed: int, rough: float = 1.0) -> Instance:
    cost = 100 * np.random.default_rng(seed).uniform(0, 1, (n + m, n + m)) ** rough
    np.fill_diagonal(cost, 0.0)
    return Instance(f"random-{n}-{m}-{seed}", cost, n, m)


@settings(max_examples=60, deadline=None)
@given(n=st.integers(1, 8), m=st.integers(1, 3), seed=st.integers(0, 10**6), rough=st.sampled_from([0.1, 1.0, 8.0]))
def test_no_simple_bound_is_above_the_optimum(n: int, m: int, seed: int, rough: float) -> None:
    instance = random_instance(n, m, seed, rough)
    optimum = SubsetDp().solve(instance, limits=Limits(time=600.0)).objective
    assert optimum is not None
    for upper in (optimum, makespan(instance, greedy_routes(instance))):
        for name, bound in SIMPLE.items():
            assert 0 <= bound(instance, upper) <= optimum, name


def test_one_uav_one_task_is_out_and_back() -> None:
    instance = Instance("one", np.array([[0.0, 3.0], [4.0, 0.0]]), 1, 1)
    for bound in SIMPLE.values():
        assert bound(instance, 7.0) == pytest.approx(7.0, rel=1e-12)


def test_farthest_takes_detours_and_the_nearest_depot() -> None:
    """Task 1 is reached from depot 2 over task 0 (1 + 1, back 5), from depot 3 directly (4, back 4)."""
    cost = np.full((4, 4), 9.0)
    cost[2, 0], cost[0, 1], cost[1, 2] = 1.0, 1.0, 5.0
    cost[3, 1], cost[1, 3] = 4.0, 4.0
    np.fill_diagonal(cost, 0.0)
    assert farthest(Instance("detour", cost, 2, 2), 100.0) == pytest.approx(7.0, rel=1e-12)


@settings(max_examples=25, deadline=None)
@given(n=st.integers(1, 5), seed=st.integers(0, 10**6))
def test_cheapest_ways_equal_every_way_tried(n: int, seed: int) -> None:
    instance = random_instance(n, 1, seed, rough=4.0)
    out, back = ways_from_depot(instance.cost, ways_between_tasks(instance.cost, n), n)
    for i in range(n):
        middles = [way for size in range(n) for way in permutations([j for j in range(n) if j != i], size)]
        there = min(sum(instance.cost[a, b] for a, b in zip((n, *way), (*way, i), strict=True)) for way in middles)
        home = min(sum(instance.cost[a, b] for a, b in zip((i, *way), (*way, n), strict=True)) for way in middles)
        assert out[i] == pytest.approx(there, rel=1e-12)
        assert back[i] == pytest.approx(home, rel=1e-12)
        assert out[i] <= there
        assert back[i] <= home


@settings(max_examples=40, deadline=None)
@given(n=st.integers(1, 5), seed=st.integers(0, 10**6), whole=st.booleans())
def test_cheapest_arborescence_equals_enumeration(n: int, seed: int, whole: bool) -> None:
    rng = np.random.default_rng(seed)
    cost = rng.integers(0, 5, (n + 1, n + 1)).astype(float) if whole else rng.uniform(0, 1, (n + 1, n + 1))
    best = np.inf
    for parents in product(range(n + 1), repeat=n):
        reached, grown = {n}, True
        while grown:
            more = {j for j in range(n) if parents[j] in reached} - reached
            reached |= more
            grown = bool(more)
        if len(reached) == n + 1:
            best = min(best, sum(cost[parents[j], j] for j in range(n)))
    assert cheapest_arborescence(cost) == pytest.approx(best, rel=1e-12, abs=1e-12)


@settings(max_examples=25, deadline=None)
@given(n=st.integers(2, 5), seed=st.integers(0, 10**6))
def test_assignment_equals_enumeration_for_one_uav(n: int, seed: int) -> None:
    """One UAV: the cheapest successor of every node, where only the depot may be its own."""
    instance = random_instance(n, 1, seed)
    best = min(
        sum(instance.cost[i, j] for i, j in enumerate(successor))
        for successor in permutations(range(n + 1))
        if all(successor[i] != i for i in range(n))
    )
    assert assignment(instance, 1e6) == pytest.approx(best, rel=1e-9)


def test_arborescence_of_a_one_way_street() -> None:
    """Depot → 0 → 1 → … at 1 each, everything else dear, the way home from the last at 5: both bounds are exact."""
    cost = np.full((5, 5), 50.0)
    for a, b in ((4, 0), (0, 1), (1, 2), (2, 3)):
        cost[a, b] = 1.0
    cost[3, 4] = 5.0
    np.fill_diagonal(cost, 0.0)
    assert arborescence(Instance("street", cost, 4, 1), 1000.0) == pytest.approx(9.0, rel=1e-9)


def test_all_bounds_in_order_and_below_the_optimum(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, "ROOTS", ("branch-and-cut",))
    instance = random_instance(10, 2, 4)
    optimum = SubsetDp().solve(instance, limits=Limits(time=600.0)).objective
    assert optimum is not None
    found = list(lower_bounds(instance, time_limit=60.0))
    assert [bound.name for bound in found] == [
        *SIMPLE,
        "total",
        "relaxation",
        "branch-and-cut",
        "capped-total",
        "capped-tours",
        "destructive",
    ]
    assert all(0 < bound.value <= optimum and bound.elapsed >= 0 for bound in found)
    assert max(found, key=lambda bound: bound.value).value > 0.5 * optimum


@pytest.mark.parametrize("seed", range(12))
def test_no_simple_bound_of_a_fleet_is_above_its_optimum(fleets: Fleets, held_karp: Oracle, seed: int) -> None:
    instance = fleets(3 + seed % 4, 1 + seed % 3, seed)
    optimum = min(held_karp(instance)[0], most := worst_makespan(instance))
    for upper in (optimum, most):
        for name, bound in SIMPLE.items():
            assert 0 <= bound(instance, upper) <= optimum, name
    routes = held_karp(instance)[1]
    assert not routes or (optimum < most and least_sum(instance, 10 * most) <= tour_costs(instance, routes).sum())


def test_of_uavs_that_differ_in_speed_alone_the_length_is_shared_by_speed() -> None:
    length, speeds = random_instance(7, 2, 3).cost, (20.0, 30.0)
    fleet = Instance.of_travel("fleet", Travel.of_uavs([length / speed for speed in speeds]), 7)
    for bound in (assignment, arborescence):
        of_length = 2 * bound(Instance("length", length, 7, 2), 1e5)
        assert bound(fleet, 1e4) == pytest.approx(of_length / sum(speeds), rel=1e-9)
    by_the_fastest = assignment(Instance("length", length, 7, 2), 1e5) * 2 / max(speeds)
    assert least_sum(fleet, 1e4) == pytest.approx(by_the_fastest, rel=1e-9)


@pytest.mark.parametrize("share", [1.0, 0.9])
def test_all_bounds_of_a_fleet(
    monkeypatch: pytest.MonkeyPatch, fleets: Fleets, held_karp: Oracle, share: float
) -> None:
    """They hold of routes that the UAVs can fly; where there are none, it is said."""
    monkeypatch.setattr(bounds, "ROOTS", ("branch-and-price",))
    instance = fleets(6, 2, 0)
    optimum = held_karp(instance)[0]
    limited = replace(instance, endurance=np.minimum(instance.limits, share * optimum))
    found = {bound.name: bound for bound in lower_bounds(limited, time_limit=60.0)}
    assert list(found) == [
        *SIMPLE,
        "total",
        "relaxation",
        "branch-and-price",
        "capped-total",
        "capped-tours",
        "destructive",
    ]
    assert (found["branch-and-price"].message == "proved that there are no routes") == (share < 1.0)
    if share == 1.0:
        assert 0.9 * optimum < max(bound.value for bound in found.values()) <= optimum


def test_what_is_too_large_is_said() -> None:
    instance = random_instance(150, 3, 0)
    relaxation = bounds._relaxation(instance, 1.0, 1.0)
    assert relaxation.value == 0.0
    assert "68403 variables" in relaxation.message


def test_routes_that_cost_nothing_need_no_more() -> None:
    found = list(lower_bounds(Instance("nothing", np.zeros((3, 3)), 2, 1)))
    assert [bound.name for bound in found] == list(SIMPLE)
    assert all(bound.value == 0 for bound in found)


def test_bounds_without_a_matrix_are_below_the_optimum_and_farthest_is_that_of_the_matrix() -> None:
    xy = np.random.default_rng(4).uniform(0.0, 100.0, (9, 2))
    places = Instance.of_metric("places", {"metric": "euclidean"}, xy, 7, 2)
    matrix = Instance("matrix", places.cost[:, :], 7, 2)
    optimum = SubsetDp().solve(matrix, limits=Limits(time=60.0)).objective
    found = {bound.name: bound for bound in lower_bounds(places)}
    assert found["farthest"].value == pytest.approx(farthest(matrix, 1e4), rel=1e-9)
    assert optimum is not None
    assert 0.5 * optimum < found["nearest-two"].value <= optimum
    rounded = Instance.of_metric("rounded", {"metric": "euclidean", "rounding": "nearest"}, xy, 7, 2)
    assert "no metric" in next(iter(lower_bounds(rounded))).message
