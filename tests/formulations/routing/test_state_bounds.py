"""Bounds of instances between headings: below the proved optimum, and near it where many sectors are tried."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing import bounds, state_bounds
from formulations.routing.bounds import lower_bounds
from formulations.routing.simple_bounds import SIMPLE
from formulations.routing.state_bounds import heading_bounds, straight_bound
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Travel, objective


def optimum(instance: Instance) -> float:
    return SubsetDp().solve(instance, limits=Limits(time=600.0)).objective or 0.0


def test_no_bound_is_above_the_optimum(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, "straight_bound", lambda *given: 0.0)  # compiles branch-and-price: the next test
    monkeypatch.setattr(state_bounds, "LAST", 64)
    instance = generate("dense-survey", 6, 2, 0, spacing=6.0, headings=32)
    best, found = optimum(instance), {each.name: each for each in lower_bounds(instance, time_limit=10.0)}
    assert list(found) == [*SIMPLE, "total", "relaxation", "straight", "headings"]
    assert max(each.value for each in found.values()) == found["headings"].value
    assert 0.95 * best < found["headings"].value <= best
    assert "sectors a task" in found["headings"].message


@pytest.mark.slow
@pytest.mark.parametrize("wind", ["none", "uniform"])
def test_straight_legs_are_a_bound_of_any_size(wind: str) -> None:
    small = generate("dense-survey", 8, 2, 0, spacing=6.0, headings=8, wind=wind)
    assert 0.8 * optimum(small) < straight_bound(small, 1e9, 20.0, 0) <= optimum(small)


@pytest.mark.slow
def test_nine_of_ten_are_certified_within_one_and_a_half_percent() -> None:
    close = 0
    for seed in range(10):
        instance = generate("dense-survey", 8 + seed % 5, 2 + seed % 2, seed, spacing=3.5 + seed % 3, headings=64)
        best = optimum(instance)
        *_, (_, bound) = heading_bounds(instance, best, 60.0)
        close += best <= bound * 1.015
    assert close >= 9


@pytest.mark.slow
def test_more_sectors_are_tried_while_there_is_time_and_none_where_nobody_says_how_uavs_turn() -> None:
    instance = generate("dense-survey", 5, 2, 0, headings=8)
    counts, values = zip(*heading_bounds(instance, 1e9, 5.0), strict=True)
    assert list(counts) == sorted(counts)
    assert len(counts) > 1
    assert list(values) == sorted(values)
    nodes = np.repeat(np.arange(4), 2)
    nameless = Instance.of_travel("x", Travel(np.ones((1, 1, 8, 8)), np.zeros(1, dtype=np.int64), nodes=nodes), 3)
    assert list(heading_bounds(nameless, 9.0, 1.0)) == []
    assert straight_bound(nameless, 9.0, 1.0, 0) == 0.0


def test_many_tasks_are_bounded_by_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    instance = generate("dense-survey", 7, 2, 3, spacing=4.0, headings=16)
    monkeypatch.setattr(state_bounds, "LAST", 32)
    *_, (_, exact) = heading_bounds(instance, 1e9, 600.0)
    monkeypatch.setattr(state_bounds, "FEW", 6)
    monkeypatch.setattr(state_bounds, "LAST_OF_MANY", 32)
    monkeypatch.setattr(state_bounds, "_SEARCH_MOST", 0.5)
    *_, (count, value) = heading_bounds(instance, 1e9, 600.0)
    assert count == 32
    assert 0.97 * optimum(instance) < value <= optimum(instance)
    assert value == pytest.approx(exact, rel=1e-6)
    monkeypatch.setattr(state_bounds, "MOST_SECTORS", 100)
    assert list(heading_bounds(instance, 1e9, 20.0)) == []


def test_clock_and_states_together_are_bounded_at_the_least_of_all_states() -> None:
    rng = np.random.default_rng(1)
    nodes = np.repeat(np.arange(5), [2, 2, 2, 1, 1])
    cost = 30.0 + rng.uniform(0.0, 9.0, (3, 8, 8))[None]
    both = Travel(cost, np.zeros(2, dtype=np.int64), np.array([0.0, 40.0, 80.0]), nodes)
    instance = Instance.of_travel("both", both, 3)
    assert instance.axes == {"time", "states"}
    by_hand = min(
        objective(instance, (order[:cut], order[cut:])) for order in permutations(range(3)) for cut in range(4)
    )
    found = list(lower_bounds(instance, time_limit=5.0))
    assert 0.8 * by_hand < max(each.value for each in found) <= by_hand
