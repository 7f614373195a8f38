"""Search over the members of an ensemble: against every routes there are, and what it keeps to."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.clocked.risk import risk_weights, routes_of_less_risk
from instances import Instance, Routes, Travel
from instances.arrays import Floats
from instances.wind_ensemble import cvar

KNOTS = np.linspace(0.0, 2000.0, 5)


def ensemble(n: int, m: int, seed: int, members: int = 3) -> tuple[Instance, Floats]:
    """Return an instance and the costs (1 + members, 5, n + m, n + m) [s] of the forecast planned with and members."""
    rng, size = np.random.default_rng([26, seed]), n + m
    points = rng.uniform(0, 1000, (size, 2))
    far = np.hypot(*(points[:, None] - points).T)
    costs = far * rng.uniform(0.6, 1.6, (1 + members, 5, 1, 1)) * rng.uniform(0.8, 1.25, (1 + members, 5, size, size))
    return Instance("e", costs[0, 0], n, m), costs


def makespans(costs: Floats, n: int, routes: Routes) -> Floats:
    """Return the makespan [s] in every member, by another interpolation than the search's."""
    found = np.zeros(len(costs) - 1)
    for s, cost in enumerate(costs[1:]):
        for k, route in enumerate(routes):
            time, stops = 0.0, [n + k, *route, n + k]
            for i, j in itertools.pairwise(stops if route else []):
                time += float(np.interp(time, KNOTS, cost[:, i, j]))
            found[s] = max(found[s], time)
    return found


def every_span(costs: Floats, n: int) -> Floats:
    """Return the makespans (…, members) of all routes of two UAVs."""
    found = []
    for size in range(n + 1):
        for part in itertools.combinations(range(n), size):
            rest = [v for v in range(n) if v not in part]
            one = [makespans(costs, n, (order, ())) for order in itertools.permutations(part)]
            two = [makespans(costs, n, ((), order)) for order in itertools.permutations(rest)]
            found.append(np.maximum(np.array(one)[:, None], np.array(two)).reshape(-1, len(costs) - 1))
    return np.concatenate(found)


def searched(instance: Instance, costs: Floats, share: float, steps: int, seed: int = 0) -> list[Routes]:
    routes = (tuple(range(instance.n_tasks)), *((),) * (instance.n_depots - 1))
    limits = Limits(time=60, iterations=steps)
    return routes_of_less_risk(instance, KNOTS, costs, share, routes, limits=limits, seed=seed)


@pytest.mark.parametrize("seed", range(4))
def test_it_finds_the_least_risk_of_all_routes(seed: int) -> None:
    n = 4 + seed % 2
    instance, costs = ensemble(n, 2, seed)
    spans = every_span(costs, n)
    for share in (1.0, 0.5, 0.0):
        least = min(float((np.sort(row)[::-1] * risk_weights(3, share)).sum()) for row in spans)
        routes = searched(instance, costs, share, 4000)[-1]
        assert cvar(makespans(costs, n, routes), max(share, 1 / 3)) == pytest.approx(least, rel=1e-9)


@pytest.mark.parametrize("share", [1.0, 0.6, 0.2, 0.0])
def test_its_weights_are_those_of_the_risk(share: float) -> None:
    values = np.array([3.0, 9.0, 1.0, 4.0])
    assert np.sort(values)[::-1] @ risk_weights(4, share) == pytest.approx(cvar(values, max(share, 0.1)))


def test_all_tasks_stay_on_routes_and_none_that_follow_are_of_more_risk() -> None:
    instance, costs = ensemble(30, 3, 1, members=4)
    found = searched(instance, costs, 0.5, 2000, seed=3)
    assert len(found) == 4
    assert found == searched(instance, costs, 0.5, 2000, seed=3), "a function of seed and steps"
    assert all(sorted(sum(routes, ())) == list(range(30)) for routes in found)
    risks = [cvar(makespans(costs, 30, routes), 0.5) for routes in found]
    assert risks == sorted(risks, reverse=True)
    start = (tuple(range(30)), (), ())
    assert risks[-1] < 0.5 * cvar(makespans(costs, 30, start), 0.5)
    assert searched(instance, costs, 0.5, 0) == [start]


def test_endurance_is_kept_in_the_forecast_planned_with() -> None:
    """The members want all tasks flown by UAV 0, whose endurance in that forecast forbids it."""
    plain, costs = ensemble(6, 2, 2)
    costs[1:, :, 7] *= 50.0
    free = searched(plain, costs, 1.0, 3000)[-1]
    assert free[1] == ()
    as_planned = costs[[0, 0]]
    limit = 0.999 * float(makespans(as_planned, 6, free)[0])
    bounded = Instance.of_travel("b", Travel(costs[:1, 0][None], np.zeros(2, np.int64)), 6, endurance=[limit, 1e6])
    limits = Limits(time=60, iterations=3000)
    kept = routes_of_less_risk(bounded, KNOTS, costs, 1.0, ((0,), (1, 2, 3, 4, 5)), limits=limits, seed=0)[-1]
    assert kept != free
    assert makespans(as_planned, 6, (kept[0], ()))[0] <= limit
