"""The total bound: Held and Karp's for one UAV, never above the optimum, and never below the cheapest arcs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.pricing import Duals, Effort, Pricer
from formulations.routing.greedy import greedy_routes
from formulations.routing.relaxation import relax
from formulations.routing.simple_bounds import assignment
from formulations.routing.subset_dp import SubsetDp
from formulations.routing.total import total
from instances import Instance, makespan


def random_instance(n: int, m: int, seed: int, **about: object) -> Instance:
    cost = np.random.default_rng(seed).uniform(0.0, 100.0, (n + m, n + m))
    np.fill_diagonal(cost, 0.0)
    return Instance(f"random-{n}-{m}-{seed}", cost, n, m, **about)


@settings(max_examples=15, deadline=None)
@given(n=st.integers(1, 8), m=st.integers(1, 3), seed=st.integers(0, 10**6))
def test_it_lies_between_the_cheapest_arcs_and_the_optimum(n: int, m: int, seed: int) -> None:
    instance = random_instance(n, m, seed)
    upper = makespan(instance, greedy_routes(instance))
    optimum = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
    value, complete, _ = total(instance, upper, 60.0)
    assert complete
    assert assignment(instance, upper) * (1 - 1e-6) <= value <= optimum


@pytest.mark.parametrize("seed", range(3))
def test_for_one_uav_it_is_the_relaxation_of_the_milp(seed: int) -> None:
    instance = random_instance(14, 1, seed)
    upper = makespan(instance, greedy_routes(instance))
    assert total(instance, upper, 60.0).bound == pytest.approx(relax(instance, upper).bound, rel=1e-6)


def test_tasks_on_a_circle_are_toured_around_it() -> None:
    angle = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)
    at = np.column_stack([np.cos(angle), np.sin(angle)])
    circle = Instance("circle", np.hypot(*(at[:, None] - at).transpose(2, 0, 1)), 11, 1)
    assert total(circle, 20.0, 60.0).bound == pytest.approx(12 * 2 * np.sin(np.pi / 12), rel=1e-6)


def test_without_time_there_is_no_bound() -> None:
    value, complete, price = total(random_instance(6, 2, 0), 500.0, 0.0)
    assert (value, complete) == (0.0, False)
    assert not price.any()


@pytest.mark.parametrize("seed", range(4))
def test_its_prices_are_a_bound_of_tours_as_high_as_it(seed: int) -> None:
    instance = random_instance(9, 2, seed)
    cap = makespan(instance, greedy_routes(instance))
    value, _, price = total(instance, cap, 60.0)
    duals = Duals(price, np.full(2, 0.5), np.zeros(2), np.zeros(0))
    pricer = Pricer(Legs.of(instance).under(cap), cap, Effort(4, 50, 10**6), make_store(9, 10_000))
    least = sum(min(0.0, pricer.price(k, duals, 0.0).least) for k in range(2))
    assert duals.offset + least >= value * (1 - 1e-6)
