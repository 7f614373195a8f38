"""Labels over states: tours priced against all there are, and branch-and-price on states against subset programming."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.label_search import no_limit, path, search
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.pricing import Duals, Effort, Pricer
from formulations.routing.columns.state_labelling import StateLabels
from formulations.routing.search_in_parts import part
from formulations.routing.solver import Status, refusal
from formulations.routing.stateless import stateless
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Travel, tour_costs
from instances.arrays import Floats

LIMITS = Limits(time=60.0)


def between_states(seed: int, n: int, *, classes: int = 1, endurance: Floats | None = None) -> Instance:
    """Tasks and two depots of one to three states each, costs without any law."""
    rng = np.random.default_rng(seed)
    nodes = np.repeat(np.arange(n + 2), [*rng.integers(1, 4, n - 1), 3, 1, 2])
    cost = rng.uniform(5, 100, (classes, 1, len(nodes), len(nodes)))
    return Instance.of_travel("states", Travel(cost, np.arange(2) % classes, nodes=nodes), n, endurance=endurance)


@pytest.mark.parametrize("seed", range(4))
def test_pricing_finds_the_cheapest_tour_of_every_set_and_its_order(seed: int) -> None:
    instance = between_states(seed, 4, classes=2)
    cap, labels = 220.0, StateLabels.of(instance, 10_000)
    labels.store.spent.fill(np.nan)  # as its room may be at first
    duals = Duals(np.full(4, 60.0), np.array([0.6, 0.4]), np.zeros(2), np.array([9.0]), ((0, 1, 3),))
    for k in range(2):
        tours = [t for size in range(1, 5) for t in permutations(range(4), size)]
        costs = {t: float(tour_costs(instance, [()] * k + [t] + [()] * (1 - k))[k]) for t in tours}
        least: dict[frozenset[int], float] = {}
        for t, cost in costs.items():
            least[frozenset(t)] = min(cost, least.get(frozenset(t), np.inf))
        pricer = Pricer(Legs.of(stateless(instance)), cap, Effort(2, 20, 10**6, 1), labels)
        of_uav = labels.of_uav(k)
        found = search(pricer.subproblem(k, duals), of_uav, np.inf, no_limit, tours=10_000)
        orders, ends = of_uav.orders(found)
        listed = {path(orders, int(e)): float(c) for e, c in zip(ends, found.costs, strict=True)}
        assert found.complete
        assert {frozenset(t): c for t, c in listed.items()} == {s: c for s, c in least.items() if c <= cap}
        assert all(costs[t] == c for t, c in listed.items())
        values = [duals.sigma[k] * c - 60.0 * len(t) + 9.0 * (len({0, 1, 3} & set(t)) > 1) for t, c in listed.items()]
        assert pricer.price(k, duals, -1.0).least == pytest.approx(min(values), abs=1e-9)


@pytest.mark.parametrize("classes", [1, 2])
def test_columns_prove_what_subset_programming_does(classes: int) -> None:
    for seed in range(4):
        instance = between_states(seed, 6, classes=classes)
        optimum = SubsetDp().solve(instance, limits=LIMITS).objective
        result = BranchAndPrice().solve(instance, limits=LIMITS, seed=seed)
        assert result.status is Status.OPTIMAL
        assert result.objective == pytest.approx(optimum, rel=1e-7)
        assert (result.bound or 0.0) <= (optimum or 0.0)
        tight = between_states(seed, 6, classes=classes, endurance=np.array([1e3, 0.4 * (optimum or 0.0)]))
        limited = BranchAndPrice().solve(tight, limits=LIMITS)
        assert limited.objective == pytest.approx(SubsetDp().solve(tight, limits=LIMITS).objective, rel=1e-7)
    hopeless = between_states(0, 6, endurance=np.array([9.0, 9.0]))
    assert BranchAndPrice().solve(hopeless, limits=LIMITS).status is Status.INFEASIBLE


def test_headings_of_a_dense_survey_without_a_search() -> None:
    instance = generate("dense-survey", 8, 2, 2, spacing=3.0, headings=8, sights=1)
    best = SubsetDp().solve(instance, limits=LIMITS)
    result = BranchAndPrice(starts=0).solve(instance, limits=LIMITS)
    assert result.status is Status.OPTIMAL
    assert result.objective == pytest.approx(best.objective, rel=1e-7)


def test_depots_of_several_states_are_refused_where_tours_are_closed() -> None:
    nodes = np.repeat(np.arange(3), 2)
    closed = Travel(np.ones((1, 1, 6, 6)), np.zeros(1, dtype=np.int64), nodes=nodes, closed=True)
    assert "depots of one state" in (refusal(BranchAndPrice(), Instance.of_travel("closed", closed, 2)) or "")


def test_part_of_an_instance_keeps_the_states_of_its_nodes() -> None:
    instance = between_states(3, 5, classes=2)
    some = part(instance, [4, 1], [1])
    assert some.axes == {"states"}
    whole = tour_costs(instance, ((), (4, 1)))
    assert tour_costs(some, ((0, 1),))[0] == whole[1]
