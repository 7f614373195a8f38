"""Instances with several states at a node: subset-dp against brute force, whatever the costs."""

from __future__ import annotations

from itertools import pairwise, permutations, product

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.solver import Status, refusal
from formulations.routing.stateless import stateless
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Travel, objective
from instances.arrays import Floats


def random_states(seed: int, *, closed: bool = False, classes: int = 1, endurance: Floats | None = None) -> Instance:
    """Three tasks and two depots with one to three states each, costs without any law."""
    rng = np.random.default_rng(seed)
    nodes = np.repeat(np.arange(5), rng.integers(1, 4, 5))
    nodes = nodes if len(nodes) > 5 else np.repeat(np.arange(5), 2)
    cost = rng.uniform(0, 100, (classes, 1, len(nodes), len(nodes)))
    travel = Travel(cost, np.arange(2) % classes, nodes=nodes, closed=closed)
    return Instance.of_travel("states", travel, 3, endurance=endurance)


def by_hand(instance: Instance) -> float:
    """Return the shortest longest tour [s] by trying all routes."""
    best = np.inf
    for order in permutations(range(3)):
        for cut in range(4):
            best = min(best, objective(instance, (order[:cut], order[cut:])))
    return best


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("classes", [1, 2])
def test_subset_dp_finds_the_best_of_all_routes(closed: bool, classes: int) -> None:
    for seed in range(10):
        instance = random_states(seed, closed=closed, classes=classes)
        result = SubsetDp().solve(instance, limits=Limits(time=60.0))
        assert result.status is Status.OPTIMAL
        assert result.objective == pytest.approx(by_hand(instance), rel=1e-12)
        assert result.objective == pytest.approx(result.bound, rel=1e-12)


def test_endurance_counts_with_states() -> None:
    limited = random_states(0, endurance=np.array([1.0, 1.0]))
    assert SubsetDp().solve(limited, limits=Limits(time=60.0)).status is Status.INFEASIBLE


def test_a_tour_costs_the_cheapest_chain_of_states() -> None:
    for closed in (False, True):
        instance = random_states(3, closed=closed)
        assert instance.travel is not None
        cost, nodes = instance.travel.cost[0, 0], instance.travel.nodes
        at = [np.flatnonzero(nodes == node) for node in (3, 0, 2, 3)]
        chains = [c for c in product(*at) if c[0] == c[-1] or not closed]
        spent = min(sum(cost[a, b] for a, b in pairwise(c)) for c in chains)
        assert instance.travel.tour_cost(0, np.array([3, 0, 2, 3])) == pytest.approx(spent, rel=1e-12)


def test_without_states_each_leg_is_the_least_of_them() -> None:
    instance = random_states(4, classes=2)
    plain = stateless(instance)
    assert "states" not in plain.axes
    assert np.array_equal(plain.cost, instance.cost)
    for seed in range(5):
        assert by_hand(stateless(random_states(seed))) <= by_hand(random_states(seed))
    assert stateless(plain) is plain


def test_states_with_time_and_too_many_states_are_refused() -> None:
    both = Travel(
        np.ones((1, 2, 6, 6)), np.zeros(1, dtype=np.int64), np.array([0.0, 9.0]), np.array([0, 0, 1, 1, 2, 2])
    )
    assert refusal(SubsetDp(), Instance.of_travel("both", both, 2)) is not None
    nodes = np.repeat(np.arange(21), 8)
    many = Instance.of_travel("many", Travel(np.ones((1, 1, 168, 168)), np.zeros(1, dtype=np.int64), nodes=nodes), 20)
    assert "it takes 1.2 GB" in (refusal(SubsetDp(), many) or "")
