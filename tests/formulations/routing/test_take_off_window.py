"""`subset-dp` and bounds where take-off is within a window, against every order of every partition."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice, permutations

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.bounds import lower_bounds
from formulations.routing.fewest_uavs import fewest_uavs
from formulations.routing.registry import SOLVERS, make_solver
from formulations.routing.solver import Status, refusal
from formulations.routing.subset_dp import SubsetDp
from instances import InputError, Instance, Routes, Travel, check_routes, objective, take_offs

Clocked = Callable[..., Instance]


def waiting(instance: Instance, share: float, window: float) -> Instance:
    """Return `instance` with a window of take-off, and endurance a share of its best makespan without one."""
    assert instance.travel is not None
    free = replace(instance, endurance=None)
    best = SubsetDp().solve(free, limits=Limits(time=60.0)).objective
    assert best is not None
    return replace(free, travel=replace(instance.travel, window=window), endurance=np.full(free.n_depots, share * best))


def all_routes(n: int) -> Iterator[Routes]:
    """Yield every pair of routes over n tasks."""
    for order in permutations(range(n)):
        yield from ((order[:cut], order[cut:]) for cut in range(n + 1))


def test_it_equals_every_order_of_every_partition(clocked: Clocked) -> None:
    waited = saved = 0
    for seed in range(12):
        instance = waiting(clocked(4, 2, seed), 0.88 + 0.03 * (seed % 6), 600.0)
        assert "window" in instance.axes
        best = min(objective(instance, routes) for routes in all_routes(4))
        result = SubsetDp().solve(instance, limits=Limits(time=60.0))
        if np.isinf(best):
            assert result.status is Status.INFEASIBLE
            continue
        assert result.status is Status.OPTIMAL
        assert result.routes is not None
        assert result.bound is not None
        assert result.objective == pytest.approx(best, rel=1e-6)
        assert result.bound <= best
        assert check_routes(instance, result.routes) == []
        waited += bool(take_offs(instance, result.routes).any())
        at_once = replace(instance, travel=replace(instance.travel, window=0.0))  # type: ignore[type-var]
        without = SubsetDp().solve(at_once, limits=Limits(time=60.0))
        assert without.objective is None or without.objective >= result.bound
        saved += without.status is Status.INFEASIBLE
        for bound in islice(lower_bounds(instance, time_limit=5.0), 4) if seed == 1 else ():
            assert bound.value <= best * (1 + 1e-9), bound.name
    assert waited >= 3
    assert saved >= 2


def test_others_decline(clocked: Clocked) -> None:
    instance = waiting(clocked(4, 2, 1), 1.1, 60.0)
    for name in SOLVERS.built_in:
        reason = refusal(make_solver(name), instance)
        assert (reason is None) == (name in {"exact", "subset-dp", "memetic", "ruin-recreate", "ga", "greedy"}), name
    assert refusal(make_solver("branch-and-price"), instance) == (
        "the instance has take-off within a window ('window'), which this solver cannot take; "
        "memetic, ruin-recreate, ga, greedy, exact and subset-dp can"
    )
    with pytest.raises(InputError, match="fewest UAVs are not known"):
        fewest_uavs(instance, 1e6, SubsetDp(), limits=Limits(time=1.0))
    large = np.ones((1, 2, 17, 17)) - np.eye(17)
    travel = Travel(large, np.zeros(2, int), np.array([0.0, 9.0]), window=1.0)
    many = Instance.of_travel("many", travel, 15, endurance=[20.0, 20.0])
    for solver in (SubsetDp(), make_solver("exact")):
        assert "at most 14 tasks where take-off is within a window, not 15" in str(refusal(solver, many))
