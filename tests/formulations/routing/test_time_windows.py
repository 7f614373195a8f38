"""Legs minimised over time windows: never dearer than flown, and bounds of them below optima by the clock."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.bounds import lower_bounds
from formulations.routing.registry import make_solver
from formulations.routing.time_windows import windowed
from instances import Instance, Routes, tour_costs

Clocked = Callable[..., Instance]
Oracle = Callable[[Instance], tuple[float, Routes]]


@pytest.mark.parametrize("seed", range(30))
def test_no_routes_as_short_as_the_known_ones_take_less(clocked: Clocked, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(2, 8)), int(rng.integers(1, 4))
    instance, uppers = clocked(n, m, seed), []
    for _ in range(40):
        routes = tuple(tuple(p.tolist()) for p in np.split(rng.permutation(n), np.sort(rng.integers(0, n + 1, m - 1))))
        flown = tour_costs(instance, routes)
        if np.isfinite(flown).all():
            uppers.append(flown.max())
            least = tour_costs(windowed(instance, float(flown.max())), routes)
            assert (least <= flown).all()
    assert uppers or instance.restricted


@pytest.mark.parametrize("seed", [0, 3, 6, 9, 12, 15])
def test_bounds_are_below_the_optimum(clocked: Clocked, brute_force: Oracle, seed: int) -> None:
    instance = clocked(6, 2, seed)
    best, _ = brute_force(instance)
    for upper in (best, 1.3 * best):
        relaxed = make_solver("subset-dp").solve(windowed(instance, upper), limits=Limits(time=60)).objective
        assert relaxed is not None
        assert min(relaxed, upper) <= best * (1 + 1e-12)


def test_windows_make_bounds_better_than_the_least_over_all_times() -> None:
    instance = generate("wind-turning", 8, 2, 1)
    solver, limits = make_solver("subset-dp"), Limits(time=60)
    best = solver.solve(instance, limits=limits).objective
    always = solver.solve(Instance("least", instance.cost, 8, 2), limits=limits).objective
    narrow = solver.solve(windowed(instance, best or 0.0), limits=limits).objective
    assert best is not None
    assert always is not None
    assert narrow is not None
    assert always < narrow <= best


def test_every_bound_of_the_command_holds() -> None:
    instance = generate("wind-turning", 7, 2, 0, turning=360)
    best = make_solver("subset-dp").solve(instance, limits=Limits(time=60)).objective
    bounds = list(lower_bounds(instance, time_limit=10.0))
    assert best is not None
    assert {bound.name for bound in bounds} >= {"farthest", "relaxation", "branch-and-price", "destructive"}
    assert all(bound.value <= best * (1 + 1e-9) for bound in bounds)
    assert max(bound.value for bound in bounds) >= 0.75 * best
