"""Integer scaling: the bound is below, the tolerance covers the difference, whatever the unit of the costs."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.scaling import BITS, scale_costs
from instances import Instance, makespan


@st.composite
def tours(draw: st.DrawFn) -> tuple[Instance, tuple[int, ...]]:
    n = draw(st.integers(1, 6))
    magnitude = 10.0 ** draw(st.integers(-6, 9))
    numbers = draw(st.lists(st.floats(0, 1), min_size=(n + 1) ** 2, max_size=(n + 1) ** 2))
    cost = np.array(numbers).reshape(n + 1, n + 1) * magnitude
    np.fill_diagonal(cost, 0.0)
    return Instance("tour", cost, n, 1), tuple(draw(st.permutations(range(n))))


@given(tours(), st.floats(1, 3))
@settings(deadline=None, max_examples=200)
def test_integer_tours_bound_float_tours_from_below(case: tuple[Instance, tuple[int, ...]], slack: float) -> None:
    instance, tour = case
    value = makespan(instance, (tour,))
    if value == 0:
        return
    scaled = scale_costs(instance, slack * value)
    stops = [instance.n_tasks, *tour, instance.n_tasks]
    z = sum(int(scaled.costs[0, i, j]) for i, j in pairwise(stops))
    exact = sum((Fraction(instance.cost[i, j]) for i, j in pairwise(stops)), Fraction(0))
    assert z <= scaled.upper, "routes as good as the incumbent stay feasible"
    assert Fraction(math.ldexp(z, -scaled.exponent)) <= exact
    assert scaled.bound(z) <= value <= scaled.bound(z) + scaled.tolerance


@given(tours())
@settings(deadline=None)
def test_numbers_stay_small_and_the_tolerance_relative(case: tuple[Instance, tuple[int, ...]]) -> None:
    instance, tour = case
    value = makespan(instance, (tour,))
    if value < 2.0**-976:  # the scale ends at 2^1000: see the extreme incumbents below
        return
    scaled = scale_costs(instance, value)
    assert 2 ** (BITS - 1) <= scaled.upper <= 2**BITS
    assert scaled.costs.max() <= scaled.upper + 1
    assert scaled.tolerance <= (instance.n_tasks + 1) * 2.0 ** (2 - BITS) * value


def test_dear_arcs_are_cut_off_above_the_incumbent() -> None:
    instance = Instance("dear", np.array([[0.0, 1e149], [1.0, 0.0]]), 1, 1)
    scaled = scale_costs(instance, 8.0)
    assert scaled.costs[0, 0, 1] == scaled.upper + 1
    assert scaled.costs[0, 1, 0] == math.ldexp(1.0, scaled.exponent)


def test_extreme_incumbents_do_not_overflow() -> None:
    for incumbent in (5e-324, 1e-300, 1e149):
        scaled = scale_costs(Instance("extreme", np.array([[0.0, incumbent], [0.0, 0.0]]), 1, 1), incumbent)
        assert (scaled.costs >= 0).all()
        assert scaled.bound(float(scaled.costs[0, 0, 1])) <= incumbent
