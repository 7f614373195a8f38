"""The capped total: never above the optimum, keeps the arcs of optimal routes, and sees what far places need."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.capped_total import capped_total
from formulations.routing.needs import Needs
from formulations.routing.search.ruin_recreate import RuinRecreate
from formulations.routing.subset_dp import SubsetDp
from formulations.routing.total import total
from instances import Instance, Travel

LIMITS = Limits(time=60.0)


def placed(n: int, m: int, seed: int, *, one_site: bool) -> Instance:
    """Return random places, all UAVs at the last if asked."""
    at = np.random.default_rng(seed).uniform(0.0, 100.0, (n + m, 2))
    at[n:] = at[n] if one_site else at[n:]
    return Instance(f"placed-{n}-{m}-{seed}", np.hypot(*(at[:, None] - at).transpose(2, 0, 1)), n, m)


def one_way(n: int, m: int, seed: int) -> Instance:
    """Return costs that keep to no triangle: ways over other tasks are often cheaper."""
    cost = np.random.default_rng(seed).uniform(0.0, 100.0, (n + m, n + m))
    np.fill_diagonal(cost, 0.0)
    return Instance(f"one-way-{n}-{m}-{seed}", cost, n, m)


def fleet(n: int, m: int, seed: int) -> Instance:
    """Return UAVs of several speeds."""
    cost = placed(n, m, seed, one_site=False).cost
    return Instance.of_travel("fleet", Travel.of_uavs([cost / (1.0 + k) for k in range(m)]), n)


KINDS = {
    "one site": lambda n, m, seed: placed(n, m, seed, one_site=True),
    "several": lambda n, m, seed: placed(n, m, seed, one_site=False),
    "one way": one_way,
    "fleet": fleet,
}


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=12, deadline=None)
@given(n=st.integers(2, 9), m=st.integers(1, 4), seed=st.integers(0, 10**6), slack=st.sampled_from([1.0, 1.1]))
def test_no_routes_are_shorter_and_optimal_ones_keep_their_arcs(
    kind: str, n: int, m: int, seed: int, slack: float
) -> None:
    instance = KINDS[kind](n, m, seed)
    best = SubsetDp().solve(instance, limits=LIMITS)
    assert best.routes is not None
    found = capped_total(instance, slack * best.objective, 60.0)
    assert found.bound <= best.objective * (1 + 1e-9)
    for k, route in enumerate(best.routes):
        flown = [n + k, *route, n + k]
        assert not route or all(found.arcs[i, j] for i, j in pairwise(flown))


def test_two_far_places_need_two_uavs() -> None:
    """Two groups at 100 on either side: one UAV for both would fly 400 and more, so that each group needs its own."""
    at = np.array([[100, 0], [100, 1], [100, 2], [-100, 0], [-100, 1], [-100, 2], [0, 0], [0, 0]], dtype=float)
    instance = Instance("far", np.hypot(*(at[:, None] - at).transpose(2, 0, 1)), 6, 2)
    best = SubsetDp().solve(instance, limits=LIMITS).objective
    found = capped_total(instance, best, 60.0)
    assert found.bound == pytest.approx(best, rel=1e-6)
    assert not found.arcs[:3, 3:6].any()
    assert not found.arcs[3:6, :3].any()


def test_times_and_needs_each_raise_it_by_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """One site, long tours: about 0.71, 0.83 and 0.94 of the routes known."""
    instance = placed(40, 3, 3, one_site=True)
    upper = RuinRecreate().solve(instance, limits=Limits(time=60.0, iterations=20_000)).objective
    assert upper is not None
    with_both = capped_total(instance, upper, 60.0).bound
    monkeypatch.setattr(Needs, "find", lambda *_: (np.zeros((0, 40), np.bool_), np.zeros(0, np.int64)))
    with_times = capped_total(instance, upper, 60.0).bound
    assert upper > with_both > 1.05 * with_times > 1.05**2 * total(instance, upper, 60.0).bound


def test_arcs_of_uavs_that_are_alike_are_left_out_of_all_or_none() -> None:
    instance = placed(20, 3, 5, one_site=True)
    found = capped_total(instance, 1.02 * capped_total(instance, 1e4, 60.0).bound, 60.0)
    assert not found.arcs.all()
    assert (found.arcs[20:, :20] == found.arcs[20, :20]).all()
    assert (found.arcs[:20, 20:] == found.arcs[:20, [20]]).all()


def test_without_time_nothing_is_claimed() -> None:
    found = capped_total(placed(8, 2, 0, one_site=False), 500.0, 0.0)
    assert found.bound == 0.0
    assert not found.complete
    assert found.arcs[:8, :8].sum() == 8 * 7
