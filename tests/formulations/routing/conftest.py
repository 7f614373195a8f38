"""Oracles and random instances for every test of routing: brute force and Held–Karp for n ≤ 8."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from itertools import permutations

import numpy as np
import pytest

from instances import Instance, Routes, Travel, objective

Oracle = Callable[[Instance], tuple[float, Routes]]


def best_partition(instance: Instance, tours: list[dict[int, tuple[float, tuple[int, ...]]]]) -> tuple[float, Routes]:
    """Hand the tasks to the UAVs in every possible way; ``tours[k][mask]`` is UAV k's best tour of those tasks.

    Sets of tasks that a UAV cannot fly are missing; +inf and no routes where nothing is left.
    """
    everything = 2**instance.n_tasks - 1
    reached: dict[int, tuple[float, Routes]] = {0: (0.0, ())}
    for best in tours:
        after: dict[int, tuple[float, Routes]] = {}
        for mask, (longest, routes) in reached.items():
            rest = everything ^ mask
            part = rest
            while True:
                length, tour = best.get(part, (np.inf, ()))
                value = max(longest, length)
                if value < after.get(mask | part, (np.inf, ()))[0]:
                    after[mask | part] = value, (*routes, tour)
                if part == 0:
                    break
                part = (part - 1) & rest
        reached = after
    if everything not in reached:
        return np.inf, ()
    routes = reached[everything][1]
    return objective(instance, routes), routes


def clocked_tours(instance: Instance, depot: int) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Try every order of every set of tasks, leg after leg, where costs change with time."""
    assert instance.travel is not None
    k, knots = depot - instance.n_tasks, instance.travel.departures.tolist()
    legs = instance.travel.cost[instance.travel.classes[k]].transpose(1, 2, 0).tolist()
    limit = float(instance.limits[k]) * (1 + 1e-9)
    best: dict[int, tuple[float, tuple[int, ...]]] = {0: (0.0, ())}

    def arrive(i: int, j: int, time: float) -> float:
        q = bisect_right(knots, time) - 1
        if q + 1 == len(knots) or time == knots[q]:
            return time + legs[i][j][q]
        share = (time - knots[q]) / (knots[q + 1] - knots[q])
        return time + (1 - share) * legs[i][j][q] + share * legs[i][j][q + 1]

    def fly_on(mask: int, order: tuple[int, ...], time: float) -> None:
        for i in instance.tasks:
            there = np.inf if mask >> i & 1 else arrive(order[-1] if order else depot, i, time)
            if there < np.inf:
                home, now = arrive(i, depot, there), mask | 1 << i
                if home <= limit and home < best.get(now, (np.inf, ()))[0]:
                    best[now] = home, (*order, i)
                fly_on(now, (*order, i), there)

    fly_on(0, (), 0.0)
    return best


def enumerated_tours(instance: Instance, depot: int) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Try every order of every set of tasks."""
    cost, limit = uav_of(instance, depot)
    best: dict[int, tuple[float, tuple[int, ...]]] = {0: (0.0, ())}
    for size in range(1, instance.n_tasks + 1):
        for tour in permutations(instance.tasks, size):
            length, at, mask = 0.0, depot, 0
            for task in tour:
                length, at, mask = length + cost[at][task], task, mask | 1 << task
            length += cost[at][depot]
            if length <= limit and length < best.get(mask, (np.inf, ()))[0]:
                best[mask] = length, tour
    return best


def uav_of(instance: Instance, depot: int) -> tuple[list[list[float]], float]:
    """Return the costs of the UAV at `depot` and how long it can fly [s]."""
    uav = depot - instance.n_tasks
    limit = np.inf if instance.endurance is None else instance.endurance[uav] * (1 + 1e-9)
    return instance.uav_cost(uav).tolist(), limit


def held_karp_tours(instance: Instance, depot: int) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Held and Karp's dynamic programme over (set of tasks, last task)."""
    cost, limit = uav_of(instance, depot)
    ways: dict[tuple[int, int], tuple[float, tuple[int, ...]]] = {
        (1 << i, i): (cost[depot][i], (i,)) for i in instance.tasks
    }
    best: dict[int, tuple[float, tuple[int, ...]]] = {0: (0.0, ())}
    for mask in range(1, 2**instance.n_tasks):
        for last in instance.tasks:
            if not mask >> last & 1:
                continue
            length, tour = ways.get((mask, last), (np.inf, ()))
            if length + cost[last][depot] <= limit and length + cost[last][depot] < best.get(mask, (np.inf, ()))[0]:
                best[mask] = length + cost[last][depot], tour
            for i in instance.tasks:
                if not mask >> i & 1:
                    longer = length + cost[last][i]
                    if longer < ways.get((mask | 1 << i, i), (np.inf, ()))[0]:
                        ways[mask | 1 << i, i] = longer, (*tour, i)
    return best


@pytest.fixture(scope="session")
def brute_force() -> Oracle:
    """Return the optimum [s] and optimal routes by enumeration; seconds from n = 8 on."""

    def best(instance: Instance) -> tuple[float, Routes]:
        tours = clocked_tours if "time" in instance.axes else enumerated_tours
        return best_partition(instance, [tours(instance, k) for k in instance.depots])

    return best


@pytest.fixture(scope="session")
def held_karp() -> Oracle:
    """Return the optimum [s] and optimal routes by Held–Karp per depot, then every partition."""
    return lambda instance: best_partition(instance, [held_karp_tours(instance, k) for k in instance.depots])


@pytest.fixture(scope="session")
def windy() -> Callable[..., Instance]:
    """Return random instances: points in a 20 km square, 20 m/s airspeed, straight legs in uniform wind and a rotation.

    ``windy(n, m, seed, wind=True)``, with coordinates; without wind the costs are symmetric. Closed form:
    |d|/v − w·d/v² for uniform wind w, less the rotation's circulation along the leg.
    """

    def make(n: int, m: int, seed: int, wind: bool = True) -> Instance:
        points = np.random.default_rng(1000 * n + 100 * m + seed).uniform(0, 20000, (n + m, 2)) - 10000
        d = points[None] - points[:, None]
        cost = np.hypot(d[..., 0], d[..., 1]) / 20
        if wind:
            x, y = points.T
            cost -= (4 * d[..., 0] - 2 * d[..., 1] + 5e-4 * (np.outer(x, y) - np.outer(y, x))) / 400
        np.fill_diagonal(cost, 0.0)
        return Instance(f"windy-{n}-{m}-{seed}", cost, n, m, points)

    return make


@pytest.fixture(scope="session")
def fleets(windy: Callable[..., Instance]) -> Callable[..., Instance]:
    """Return random instances whose UAVs differ in speed, in what they can serve and in how long they can fly.

    ``fleets(n, m, seed)``: speeds 20, 25 or 30 m/s, each task forbidden to a UAV with probability 0.1, and three in
    four UAVs with an endurance around an even share of one UAV's tour of everything; some have no routes.
    """

    def make(n: int, m: int, seed: int) -> Instance:
        rng = np.random.default_rng([n, m, seed])
        base = windy(n, m, seed)
        assert base.coordinates is not None
        straight = np.hypot(*(base.coordinates[None] - base.coordinates[:, None]).transpose(2, 0, 1)) / 20
        costs = []
        for speed in rng.choice([1.0, 1.25, 1.5], m):
            cost = straight / speed - (straight - base.cost) / speed**2  # the paper's cost at another speed
            for task in np.flatnonzero(rng.uniform(size=n) < 0.1):
                cost[task, :] = cost[:, task] = np.inf
            np.fill_diagonal(cost, 0.0)
            costs.append(np.maximum(cost, 0.0))
        share = base.cost[np.arange(n), np.roll(np.arange(n), -1)].sum() / m
        limits = np.where(rng.uniform(size=m) < 0.75, rng.uniform(0.5, 2.0, m) * share + 600, np.inf)
        travel = Travel.of_uavs(costs)
        return Instance.of_travel(f"fleet-{n}-{m}-{seed}", travel, n, coordinates=base.coordinates, endurance=limits)

    return make


@pytest.fixture(scope="session")
def clocked(fleets: Callable[..., Instance]) -> Callable[..., Instance]:
    """Return random instances whose costs change with time, first in, first out, at knots that are not evenly spread.

    ``clocked(n, m, seed)``: the UAVs of `fleets`, alike for even seeds, every leg with a course of its own; it rises
    steeply or falls nearly as fast as it may. Every third is without endurance, every fifth begins with equal knots.
    """

    def make(n: int, m: int, seed: int) -> Instance:
        rng, base = np.random.default_rng([n, m, seed, 1]), fleets(n, m, seed)
        legs = base.cost[None] if seed % 2 == 0 else base.class_costs
        classes = np.zeros(m, dtype=np.int64) if seed % 2 == 0 else base.classes
        gaps = rng.uniform(50, 900, int(rng.integers(1, 6)))
        knots = np.concatenate([[0.0], np.cumsum(gaps)])
        cost = np.empty((len(legs), len(knots), n + m, n + m))
        cost[:, 0] = legs
        for q, gap in enumerate(gaps):
            wanted = cost[:, q] * rng.uniform(0.5, 1.7, legs.shape) if q or seed % 5 else cost[:, q]
            cost[:, q + 1] = np.maximum(wanted, cost[:, q] - 0.95 * gap)
        travel = Travel(cost, classes, knots)
        endurance = None if seed % 3 == 0 or base.endurance is None else 1.3 * base.endurance
        return Instance.of_travel(f"clock-{n}-{m}-{seed}", travel, n, coordinates=base.coordinates, endurance=endurance)

    return make
