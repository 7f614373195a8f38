"""Random asymmetric instances with random routes, for the kernels' naive twins; stages begun one after another."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from formulations.routing.search.population import Population
from instances import Instance, Routes

RandomCase = Callable[[int, int, int], tuple[Instance, Routes]]
Begun = Callable[[Population, int, int], Iterator[Population]]


@pytest.fixture(scope="session")
def random_case() -> RandomCase:
    """Return a function of (seed, n, m): an instance with no structure and routes that visit every task."""

    def make(seed: int, n: int, m: int) -> tuple[Instance, Routes]:
        rng = np.random.default_rng(seed)
        cost = rng.uniform(1.0, 100.0, (n + m, n + m))
        np.fill_diagonal(cost, 0.0)
        routes: list[list[int]] = [[] for _ in range(m)]
        for v in rng.permutation(n):
            routes[rng.integers(m)].append(int(v))
        return Instance("random", cost, n, m), tuple(map(tuple, routes))

    return make


@pytest.fixture(scope="session")
def begun() -> Begun:
    """Return a function of (population, barren, since_restart) that begins 100 stages of it, two members in it."""

    def begin(population: Population, barren: int, since_restart: int) -> Iterator[Population]:
        population.plan(1e-6)
        family = population.family
        family.founders, family.members = 8, [population.best, population.best]
        family.since_restart, family.barren = since_restart, barren
        for _ in range(100):
            population.begin(0.0)
            yield population

    return begin
