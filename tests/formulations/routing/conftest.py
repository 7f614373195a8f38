"""Oracles and random instances for every test of routing: brute force and Held–Karp for n ≤ 8."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations

import numpy as np
import pytest

from instances import Instance, Routes, makespan

Oracle = Callable[[Instance], tuple[float, Routes]]


def best_partition(instance: Instance, tours: list[dict[int, tuple[float, tuple[int, ...]]]]) -> tuple[float, Routes]:
    """Hand the tasks to the UAVs in every possible way; ``tours[k][mask]`` is UAV k's best tour of those tasks."""
    everything = 2**instance.n_tasks - 1
    reached: dict[int, tuple[float, Routes]] = {0: (0.0, ())}
    for best in tours:
        after: dict[int, tuple[float, Routes]] = {}
        for mask, (longest, routes) in reached.items():
            rest = everything ^ mask
            part = rest
            while True:
                length, tour = best[part]
                value = max(longest, length)
                if value < after.get(mask | part, (np.inf, ()))[0]:
                    after[mask | part] = value, (*routes, tour)
                if part == 0:
                    break
                part = (part - 1) & rest
        reached = after
    routes = reached[everything][1]
    return makespan(instance, routes), routes


def enumerated_tours(instance: Instance, depot: int) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Try every order of every set of tasks."""
    cost = instance.cost.tolist()
    best: dict[int, tuple[float, tuple[int, ...]]] = {0: (0.0, ())}
    for size in range(1, instance.n_tasks + 1):
        for tour in permutations(instance.tasks, size):
            length, at, mask = 0.0, depot, 0
            for task in tour:
                length, at, mask = length + cost[at][task], task, mask | 1 << task
            length += cost[at][depot]
            if length < best.get(mask, (np.inf, ()))[0]:
                best[mask] = length, tour
    return best


def held_karp_tours(instance: Instance, depot: int) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Held and Karp's dynamic programme over (set of tasks, last task)."""
    cost = instance.cost.tolist()
    ways: dict[tuple[int, int], tuple[float, tuple[int, ...]]] = {
        (1 << i, i): (cost[depot][i], (i,)) for i in instance.tasks
    }
    best: dict[int, tuple[float, tuple[int, ...]]] = {0: (0.0, ())}
    for mask in range(1, 2**instance.n_tasks):
        for last in instance.tasks:
            if not mask >> last & 1:
                continue
            length, tour = ways[mask, last]
            if length + cost[last][depot] < best.get(mask, (np.inf, ()))[0]:
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
    return lambda instance: best_partition(instance, [enumerated_tours(instance, k) for k in instance.depots])


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
