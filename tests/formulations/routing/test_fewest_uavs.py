"""Fewest UAVs: against every set of UAVs by brute force, like UAVs counted, honest when time is short."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.circuit import Circuit
from formulations.routing.fewest_uavs import fewest_uavs, of_uavs, sets_of
from formulations.routing.milp import Milp
from formulations.routing.solver import Result, Status
from formulations.routing.subset_dp import SubsetDp
from instances import InputError, Instance, Routes, Travel, check_routes

Oracle = Callable[[Instance], tuple[float, Routes]]
LIMITS = Limits(time=60)


def fewest_by_force(instance: Instance, limit: float, oracle: Oracle) -> int | None:
    for size in range(1, instance.n_depots + 1):
        for uavs in combinations(range(instance.n_depots), size):
            part = of_uavs(instance, uavs)
            if oracle(replace(part, endurance=np.minimum(part.limits, limit)))[0] < np.inf:
                return size
    return None


@pytest.mark.parametrize("share", [0.45, 0.7, 1.0, 2.5])
@pytest.mark.parametrize("seed", [0, 1, 3, 5])
def test_against_every_set(fleets: Callable[..., Instance], held_karp: Oracle, seed: int, share: float) -> None:
    instance = fleets(5, 3, seed)
    limit = share * float(instance.cost[:5].max(axis=1).sum()) / 3
    wanted = fewest_by_force(instance, limit, held_karp)
    found = fewest_uavs(instance, limit, SubsetDp(), limits=LIMITS)
    if wanted is None:
        assert (found.status, found.fewest, found.at_least) == (Status.INFEASIBLE, None, 4)
        return
    assert (found.status, found.fewest, found.at_least) == (Status.OPTIMAL, wanted, wanted)
    assert check_routes(replace(instance, endurance=np.minimum(instance.limits, limit)), found.routes or ()) == []


@pytest.mark.parametrize("solver", [Milp(), Circuit()])
def test_any_exact_method_decides(windy: Callable[..., Instance], solver: Milp | Circuit) -> None:
    instance = windy(6, 3, 1)
    answers = {fewest_uavs(instance, 1800.0, method, limits=LIMITS).fewest for method in (SubsetDp(), solver)}
    assert len(answers) == 1


def test_like_uavs_are_counted(windy: Callable[..., Instance]) -> None:
    """Six UAVs at one depot: one set of each size, not C(6, s)."""
    base = windy(6, 1, 0)
    nodes = [*range(6), *[6] * 6]
    instance = Instance("shared", base.cost[np.ix_(nodes, nodes)], 6, 6)
    farthest = max(base.cost[6, i] + base.cost[i, 6] for i in range(6))
    found = fewest_uavs(instance, 1.001 * float(farthest), SubsetDp(), limits=LIMITS)
    assert found.status is Status.OPTIMAL
    assert 1 < (found.fewest or 0) <= 6
    assert found.decided <= 6


def test_a_slow_uav_that_cannot_fly_long_refutes_nothing(windy: Callable[..., Instance], held_karp: Oracle) -> None:
    """Lengths are counted at the fastest UAV's costs: bounds weighted by speed say nothing of the sum of all tours."""
    cost = windy(5, 2, 0).cost
    instance = Instance.of_travel("fleet", Travel.of_uavs([30 * cost, cost]), 5, endurance=[1.0, np.inf])
    alone, _ = held_karp(of_uavs(instance, (1,)))
    found = fewest_uavs(instance, alone, SubsetDp(), limits=LIMITS)
    assert (found.status, found.uavs) == (Status.OPTIMAL, (1,))


def test_sets_take_the_first_of_each_group() -> None:
    assert list(sets_of([[0, 1], [2], [3, 4]], 2)) == [(0, 1), (0, 2), (0, 3), (2, 3), (3, 4)]


def test_without_proofs_the_answer_is_an_interval(
    monkeypatch: pytest.MonkeyPatch, windy: Callable[..., Instance]
) -> None:
    """A method that says nothing unless all UAVs may fly leaves a lower end that lengths alone give."""
    instance = windy(6, 3, 1)
    search = SubsetDp.search

    def undecided(self: SubsetDp, recorder: object, seed: int) -> Result:
        full = recorder.instance.n_depots == 3  # type: ignore[attr-defined]
        return search(self, recorder, seed) if full else Result(Status.NO_SOLUTION)  # type: ignore[arg-type]

    whole = fewest_uavs(instance, 1800.0, SubsetDp(), limits=LIMITS)
    monkeypatch.setattr(SubsetDp, "search", undecided)
    found = fewest_uavs(instance, 1800.0, SubsetDp(), limits=LIMITS)
    assert found.status is Status.FEASIBLE
    assert found.at_least <= (whole.fewest or 0) <= (found.fewest or 0)


def test_bad_limits_are_refused(windy: Callable[..., Instance]) -> None:
    with pytest.raises(InputError, match="limit must be positive"):
        fewest_uavs(windy(3, 1, 0), -1.0, SubsetDp(), limits=LIMITS)
