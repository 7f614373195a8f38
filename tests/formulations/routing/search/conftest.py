"""Random asymmetric instances with random routes, for the kernels' naive twins."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from instances import Instance, Routes

RandomCase = Callable[[int, int, int], tuple[Instance, Routes]]


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
