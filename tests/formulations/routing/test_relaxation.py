"""The linear relaxation: below every optimum, at any duals, with no violated cut left."""

from collections.abc import Callable
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.greedy import greedy_routes
from formulations.routing.relaxation import _Relaxation, relax
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Routes, makespan


def random_instance(n: int, m: int, seed: int) -> Instance:
    cost = np.random.default_rng(seed).uniform(0, 100, (n + m, n + m))
    np.fill_diagonal(cost, 0.0)
    return Instance(f"random-{n}-{m}-{seed}", cost, n, m)


def optimum_of(instance: Instance) -> float:
    objective = SubsetDp().solve(instance, limits=Limits(time=600.0)).objective
    assert objective is not None
    return objective


@settings(max_examples=10, deadline=None)
@given(n=st.integers(1, 7), m=st.integers(1, 3), seed=st.integers(0, 10**6), loose=st.booleans())
def test_no_higher_than_the_optimum_whatever_routes_are_known(n: int, m: int, seed: int, loose: bool) -> None:
    instance = random_instance(n, m, seed)
    optimum = optimum_of(instance)
    upper = 10 * makespan(instance, greedy_routes(instance)) if loose else optimum
    relaxed = relax(instance, upper)
    assert relaxed.complete
    assert 0 < relaxed.bound <= optimum


@pytest.mark.parametrize("seed", range(4))
def test_no_higher_than_the_optimum_of_a_fleet(
    fleets: Callable[..., Instance], held_karp: Callable[[Instance], tuple[float, Routes]], seed: int
) -> None:
    instance = fleets(5, 2, seed)
    optimum = held_karp(instance)[0]
    relaxed = relax(instance, min(optimum, 1e5))
    assert np.isinf(optimum) or (relaxed.complete and 0 < relaxed.bound <= optimum)


def test_endurance_raises_the_relaxation() -> None:
    """Two tasks beside one depot and far from the other, whose UAV alone could fly to both, but not for so long."""
    x = np.array([1.0, 2.0, 0.0, 100.0])
    cost = np.abs(np.subtract.outer(x, x))
    limited = Instance("limited", cost, 2, 2, endurance=[3.0, np.inf])
    assert relax(Instance("unlimited", cost, 2, 2), 1000.0).bound < relax(limited, 1000.0).bound


def test_what_it_leaves_is_a_point_of_the_relaxation() -> None:
    instance = random_instance(6, 2, 1)
    n, theta = 6, (relaxed := relax(instance, makespan(instance, greedy_routes(instance)))).theta
    y = theta[:, :, :n].sum(axis=1)
    assert y.sum(axis=0) == pytest.approx(1.0)  # const1
    assert theta.sum(axis=1) == pytest.approx(theta.sum(axis=2), abs=1e-6)  # const2, const4
    assert (theta[:, n].sum(axis=1) <= 1 + 1e-6).all()  # const3
    for k in range(2):  # const6, every S and v
        for size in range(2, n + 1):
            for S in combinations(range(n), size):
                outside = [i for i in range(n + 1) if i not in S]
                assert theta[k][np.ix_(outside, S)].sum() >= max(y[k, v] for v in S) - 2e-3
    tours = [
        float((theta[k] * instance.cost[np.ix_(at, at)]).sum()) for k in range(2) for at in [[*range(n), n + k]]
    ]  # costsum, const5
    assert relaxed.bound == pytest.approx(max(tours), rel=1e-5)


def test_subtour_cuts_raise_the_bound() -> None:
    """Two pairs of tasks far from the depot: without const6 the pairs are cycles and the UAV stays home."""
    xy = np.array([[0, 1000], [1, 1000], [1000, 0], [1001, 0], [0, 0]], dtype=float)
    instance = Instance("pairs", np.linalg.norm(xy[:, None] - xy[None], axis=-1), 4, 1)
    relaxed = relax(instance, makespan(instance, greedy_routes(instance)))
    assert relaxed.cuts > 0
    assert relaxed.bound == pytest.approx(optimum_of(instance), rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_the_bound_holds_at_any_duals(seed: int) -> None:
    instance = random_instance(6, 2, seed)
    optimum = optimum_of(instance)
    relaxation = _Relaxation(instance, optimum)
    assert relaxation.solve(np.inf).bound <= optimum
    rows = relaxation.constraints
    rng = np.random.default_rng(seed)
    exact = [np.array(row.dual_value) for row in rows]
    bounds = []
    for spread in (0.0, 1e-6, 1e-2, 1.0):
        for row, dual in zip(rows, exact, strict=True):
            row.save_dual_value(dual + rng.normal(0, spread, dual.shape))
        bounds.append(relaxation.lagrangian(rows) * optimum)
    assert max(bounds) <= optimum
    assert bounds[0] == pytest.approx(bounds[1], rel=1e-3)
    assert bounds[3] < bounds[0]


def test_out_of_time_it_claims_nothing() -> None:
    instance = random_instance(6, 2, 0)
    relaxed = relax(instance, makespan(instance, greedy_routes(instance)), time_limit=0.0)
    assert (relaxed.bound, relaxed.rounds, relaxed.complete) == (0.0, 0, False)
