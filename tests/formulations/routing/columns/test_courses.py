"""Columns by the clock: bins, completion bounds and fixed legs of costs that change with time, against enumeration."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, pairwise, permutations

import numpy as np
import pytest

from formulations.routing.columns.fixing import fix_legs
from formulations.routing.columns.label_search import no_limit, path, search
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.pricing import DualBound, Duals, Effort, Pricer
from instances import Instance, tour_costs

Clocked = Callable[..., Instance]


def tours_of(instance: Instance, k: int, cap: float) -> dict[tuple[int, ...], float]:
    """Return all tours of UAV k of cost ≤ cap and what they take, by the independent check."""
    found = {}
    for size in range(1, instance.n_tasks + 1):
        for order in permutations(instance.tasks, size):
            routes = [()] * k + [order] + [()] * (instance.n_depots - k - 1)
            found[order] = float(tour_costs(instance, routes)[k])
    return {order: cost for order, cost in found.items() if cost <= cap}


def some_duals(rng: np.random.Generator, n: int, m: int, size: float, sigma: float) -> Duals:
    cuts = tuple(c for c in combinations(range(n), 3) if rng.random() < 0.5)
    rho = rng.uniform(0, size, len(cuts))
    return Duals(rng.normal(size, size, n), np.full(m, sigma), np.zeros(m), rho, cuts)


def reduced(duals: Duals, k: int, order: tuple[int, ...], cost: float) -> float:
    paid = sum(rho for cut, rho in zip(duals.cuts, duals.rho, strict=True) if len(set(cut) & set(order)) >= 2)
    return float(duals.sigma[k] * cost - duals.price[list(order)].sum() + paid)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(("near", "bins", "watch"), [(0, 40, 0), (1, 3, 2), (3, 300, 3)])
def test_no_label_promises_less_than_the_best_tour_that_begins_so(
    clocked: Clocked, seed: int, near: int, bins: int, watch: int
) -> None:
    instance, rng = clocked(5, 2, seed), np.random.default_rng(seed)
    cap = float(rng.uniform(0.4, 1.2) * 5 * instance.cost.mean())
    duals = some_duals(rng, 5, 2, cap / 8, 0.5)
    store = make_store(5, 10_000)
    pricer = Pricer(Legs.of(instance).under(cap), cap, Effort(near, bins, 10**6, watch), store)
    for k in range(2):
        limit = min(cap, float(instance.limits[k]))
        values = {order: reduced(duals, k, order, cost) for order, cost in tours_of(instance, k, limit).items()}
        found = search(pricer.subproblem(k, duals), store, np.inf, no_limit, tours=10_000)
        assert found.complete
        for label in range(found.labels):
            begin = path(store, label)
            best = min((v for order, v in values.items() if order[: len(begin)] == begin), default=np.inf)
            assert store.bound[label] <= best + 1e-9 * cap
        assert found.values.min(initial=np.inf) == pytest.approx(min(values.values(), default=np.inf), abs=1e-9 * cap)


def test_legs_are_fixed_only_where_no_tour_through_them_is_allowed(clocked: Clocked) -> None:
    fixed = idle = 0
    for seed in range(12):
        instance, rng = clocked(5, 1, seed), np.random.default_rng(seed)
        cap = float(rng.uniform(0.5, 1.2) * 5 * instance.cost.mean())
        duals = some_duals(rng, 5, 1, cap / 8, 0.8)
        effort = Effort(*[(0, 5, 10**6, 0), (3, 200, 10**6, 2)][seed % 2])
        pricer = Pricer(Legs.of(instance), cap, effort, make_store(5, 10_000))
        tours = tours_of(instance, 0, min(cap, float(instance.limits[0])))
        values = {order: reduced(duals, 0, order, cost) for order, cost in tours.items()}
        least, allowed = min(0.0, *values.values(), 0.0), cap / 10
        at = DualBound(cap - allowed, duals, np.array([least]))  # tours above least + allowed are not needed
        left = fix_legs(pricer, [0], at)
        needed = [order for order, value in values.items() if value <= least + allowed - 1e-9 * cap]
        for order in needed:
            assert np.isfinite([left.out[0, order[0]], left.home[0, order[-1]]]).all()
            assert np.isfinite([left.between[0, i, j] for i, j in pairwise(order)]).all()
        before = int(np.isfinite(pricer.legs.between).sum())
        fixed += before - int(np.isfinite(left.between).sum())
        idle += before - len({leg for order in needed for leg in pairwise(order)})
    assert fixed > idle / 2


def test_of_tours_that_earn_the_same_the_cheapest_is_found(clocked: Clocked) -> None:
    """A UAV whose time has no price: its tours over one set of tasks differ in cost alone, and that is what counts."""
    instance = clocked(4, 1, 0)
    duals = Duals(np.full(4, 1.0), np.zeros(1), np.zeros(1), np.zeros(0))
    store = make_store(4, 10_000)
    pricer = Pricer(Legs.of(instance), 1e6, Effort(2, 50, 10**6), store)
    found = search(pricer.subproblem(0, duals), store, np.inf, no_limit, tours=10_000)
    best: dict[frozenset[int], float] = {}
    for order, cost in tours_of(instance, 0, float(instance.limits[0])).items():
        best[frozenset(order)] = min(cost, best.get(frozenset(order), np.inf))
    assert len(found.ends) == len(best)
    for end, cost in zip(found.ends, found.costs, strict=True):
        assert cost == pytest.approx(best[frozenset(path(store, int(end)))], rel=1e-12)
