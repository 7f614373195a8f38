"""subset-dp against plain enumeration, and the laws that any exact method obeys."""

from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.solver import Status
from formulations.routing.subset_dp import LARGEST, SubsetDp, cheapest_order, tour_table
from instances import Instance, check_routes, makespan, tour_costs

SOLVER = SubsetDp()
LIMITS = Limits(time=600.0)


def random_instance(n: int, m: int, seed: int, whole: bool = False) -> Instance:
    """Costs without triangle inequality or symmetry; whole numbers make many ties."""
    rng = np.random.default_rng(seed)
    cost = rng.integers(0, 9, (n + m, n + m)).astype(float) if whole else rng.uniform(0, 100, (n + m, n + m))
    np.fill_diagonal(cost, 0.0)
    return Instance(f"random-{n}-{m}-{seed}", cost, n, m)


def enumerated(instance: Instance) -> float:
    """The optimum by trying every assignment and every order."""
    best = np.inf
    cheapest = {}
    for k in range(instance.n_depots):
        for bits in range(1 << instance.n_tasks):
            tasks = [i for i in instance.tasks if bits >> i & 1]
            alone = [()] * instance.n_depots
            cheapest[k, bits] = min(
                tour_costs(instance, [*alone[:k], order, *alone[k + 1 :]])[k] for order in permutations(tasks)
            )
    for owner in product(range(instance.n_depots), repeat=instance.n_tasks):
        parts = [sum(1 << i for i, o in enumerate(owner) if o == k) for k in range(instance.n_depots)]
        best = min(best, max(cheapest[k, part] for k, part in enumerate(parts)))
    return best


@settings(max_examples=40, deadline=None)
@given(n=st.integers(1, 5), m=st.integers(1, 4), seed=st.integers(0, 10**6), whole=st.booleans())
def test_equals_enumeration(n: int, m: int, seed: int, whole: bool) -> None:
    instance = random_instance(n, m, seed, whole)
    result = SOLVER.solve(instance, limits=LIMITS)
    assert result.status is Status.OPTIMAL
    assert result.routes is not None
    assert not check_routes(instance, result.routes)
    assert result.objective == pytest.approx(makespan(instance, result.routes), abs=0)
    assert result.objective == pytest.approx(enumerated(instance), rel=1e-12)
    assert result.bound is not None
    assert result.objective - result.bound <= result.tolerance


@settings(max_examples=20, deadline=None)
@given(n=st.integers(6, 10), m=st.integers(1, 4), seed=st.integers(0, 10**6))
def test_relabelling_tasks_and_uavs_keeps_the_optimum_and_scaling_scales_it(n: int, m: int, seed: int) -> None:
    instance = random_instance(n, m, seed)
    rng = np.random.default_rng(seed)
    order = np.concatenate([rng.permutation(n), n + rng.permutation(m)])
    relabelled = Instance("relabelled", 3.0 * instance.cost[np.ix_(order, order)], n, m)
    first, second = (SOLVER.solve(i, limits=LIMITS).objective for i in (instance, relabelled))
    assert second == pytest.approx(3.0 * first, rel=1e-12)


@settings(max_examples=20, deadline=None)
@given(n=st.integers(1, 9), m=st.integers(1, 3), seed=st.integers(0, 10**6))
def test_any_start_leaves_the_optimum_alone(n: int, m: int, seed: int) -> None:
    instance = random_instance(n, m, seed, whole=True)
    best = SOLVER.solve(instance, limits=LIMITS)
    everything_to_one = [tuple(instance.tasks)] + [()] * (m - 1)
    for start in (everything_to_one, best.routes):
        again = SOLVER.solve(instance, limits=LIMITS, start=start)
        assert again.objective == best.objective
        assert again.status is Status.OPTIMAL


def test_more_uavs_than_tasks() -> None:
    instance = random_instance(2, 4, 3)
    result = SOLVER.solve(instance, limits=LIMITS)
    assert result.objective == pytest.approx(enumerated(instance))


def test_tour_table_and_order_agree() -> None:
    instance = random_instance(9, 2, 11)
    table = tour_table(instance, 1)
    tasks = [0, 2, 3, 5, 7, 8]
    order = cheapest_order(instance, 1, tasks)
    assert sorted(order) == tasks
    assert tour_costs(instance, [(), order])[1] == pytest.approx(table[sum(1 << i for i in tasks)], rel=1e-13)


def test_refuses_what_does_not_fit() -> None:
    assert SOLVER.accepts(random_instance(LARGEST, 2, 0)) is None
    reason = SOLVER.accepts(random_instance(LARGEST + 1, 2, 0))
    assert reason is not None
    assert "22 tasks, not 23" in reason


def test_out_of_time_returns_routes_without_a_claim() -> None:
    instance = random_instance(12, 3, 5)
    result = SOLVER.solve(instance, limits=Limits(time=1e-9))
    assert result.status is Status.FEASIBLE
    assert result.stopped_by == "time"
    assert result.routes is not None
    assert not check_routes(instance, result.routes)
