"""The destructive bound: never past the optimum, never below the plain capped relaxation, whatever the routes known."""

import itertools

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.columns.destructive import destructive_bounds
from formulations.routing.subset_dp import SubsetDp
from formulations.routing.total import total
from instances import Instance


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("looseness", [1.0, 1.5, 4.0])
def test_rises_and_stays_below_the_optimum(seed: int, looseness: float) -> None:
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(3, 10)), int(rng.integers(1, 4))
    cost = rng.uniform(0, 100, (n + m, n + m))
    np.fill_diagonal(cost, 0.0)
    instance = Instance("any", cost, n, m)
    optimum = SubsetDp().solve(instance, limits=Limits(time=600.0)).objective
    assert optimum is not None
    upper = looseness * optimum
    price = total(instance, upper, 60.0).price if seed % 2 else None
    bounds = list(destructive_bounds(instance, 0.0, upper, lambda: np.inf, price=price))
    assert bounds
    assert all(a < b for a, b in itertools.pairwise(bounds))
    assert bounds[-1] <= optimum * (1 + 1e-12)


def test_loose_routes_cost_little() -> None:
    """Bisection gets from routes twice too long nearly the bound that the best routes give at once."""
    rng = np.random.default_rng(5)
    points = rng.uniform(0, 100, (12, 2))
    cost = np.hypot(*(points[None, :, :] - points[:, None, :]).transpose(2, 0, 1))
    instance = Instance("plane", cost, 10, 2)
    optimum = SubsetDp().solve(instance, limits=Limits(time=600.0)).objective
    assert optimum is not None
    tight, loose = (list(destructive_bounds(instance, 0.0, f * optimum, lambda: np.inf)) for f in (1.0, 2.0))
    assert loose[-1] >= tight[0] - 5e-3 * optimum


def test_out_of_time_yields_nothing_false() -> None:
    instance = Instance("line", np.abs(np.subtract.outer(np.arange(6.0), np.arange(6.0))), 5, 1)
    assert list(destructive_bounds(instance, 0.0, 10.0, lambda: 0.0)) == []
