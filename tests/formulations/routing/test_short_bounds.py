"""Bounds of seconds: never above the optimum, and left out where they cannot be had."""

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.registry import make_solver
from formulations.routing.short_bounds import short_bounds
from instances import Instance


def instance(seed: int) -> Instance:
    places = np.random.default_rng(seed).uniform(0, 1e3, (10, 2))
    return Instance("square", np.hypot(*(places[:, None] - places).transpose(2, 0, 1)), 8, 2)


@pytest.mark.parametrize("seed", range(4))
def test_no_bound_is_above_the_optimum_and_capped_tours_are_tight(seed):
    optimum = make_solver("subset-dp").solve(instance(seed), limits=Limits(time=30.0)).objective
    bounds = short_bounds(instance(seed), 1.05 * optimum, 30.0)
    assert max(bounds.values()) <= optimum * (1 + 1e-9)
    assert bounds["capped-tours"] >= 0.85 * optimum
    assert bounds == short_bounds(instance(seed), 1.05 * optimum, 30.0)


def test_a_limit_of_0_leaves_the_bounds_of_milliseconds():
    assert set(short_bounds(instance(0), 1e4, 0.0)) == {"farthest", "assignment", "arborescence"}
