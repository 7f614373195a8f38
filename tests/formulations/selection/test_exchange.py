"""Exchange: against all sets that can be flown, and that it stops where it should."""

from __future__ import annotations

from itertools import combinations, permutations

import numpy as np
import pytest

from formulations.selection.exchange import exchanged
from instances import Instance, check_routes


def square(seed: int, endurance: float) -> tuple[Instance, np.ndarray]:
    """Return seven tasks and one UAV in a unit square, Euclidean, and the tasks' prizes."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, 1, (8, 2))
    cost = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    return Instance("x", cost, 7, 1, endurance=np.array([endurance])), rng.uniform(1, 2, 7)


def flyable(instance: Instance, tasks: tuple[int, ...]) -> bool:
    return any(not check_routes(instance, (order,), all_tasks=False) for order in permutations(tasks))


@pytest.mark.parametrize("seed", range(3))
def test_no_single_exchange_that_can_be_flown_is_better(seed: int) -> None:
    instance, prizes = square(seed, 1.6)

    def worth(tasks) -> float:  # type: ignore[no-untyped-def]
        return float(np.sqrt(prizes[list(tasks)].sum()))

    first = next((task,) for task in instance.tasks if flyable(instance, (task,)))
    routes, count = exchanged(instance, (first,), worth, 30.0)
    assert count > 0
    assert check_routes(instance, routes, all_tasks=False) == []
    tasks = sorted(routes[0])
    assert worth(tasks) > worth(first)
    best = max(worth(s) for size in (1, 2, 3) for s in combinations(range(7), size) if flyable(instance, s))
    assert worth(tasks) >= 0.9 * best
    assert exchanged(instance, routes, worth, 30.0) == (routes, 0)
    assert exchanged(instance, (first,), worth, 0.0) == ((first,), 0)
