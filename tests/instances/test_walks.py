"""Shortest walks against every walk tried."""

from itertools import pairwise, permutations

import numpy as np
import pytest

from instances.walks import shortest_walks


@pytest.mark.parametrize("seed", range(8))
def test_shortest_walks_equal_every_walk_tried(seed: int) -> None:
    """Detours may be cheaper than the leg, legs may be missing, and both ways may differ."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 6))
    cost = rng.uniform(0, 1, (n, n)) ** 3
    cost[rng.random((n, n)) < 0.3] = np.inf
    before = cost.copy()
    walk = shortest_walks(cost)
    assert np.array_equal(cost, before)
    for i in range(n):
        for j in range(n):
            others = [v for v in range(n) if v not in (i, j)]
            walks = [(i, *inner, j) for size in range(n) for inner in permutations(others, size)]
            best = min(sum(cost[a, b] for a, b in pairwise(nodes)) for nodes in walks) if i != j else 0.0
            assert walk[i, j] == pytest.approx(best)
