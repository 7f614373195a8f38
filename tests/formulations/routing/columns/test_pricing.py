"""Pricing of tours: no bound of labels, beams or completions passes the best tour there is."""

import itertools

import numpy as np
import pytest

from formulations.routing.columns.completion import Bins, Memory, bins_left, completion
from formulations.routing.columns.cuts import Watch
from formulations.routing.columns.label_search import no_limit, path, search
from formulations.routing.columns.labelling import least_of_all, make_store
from formulations.routing.columns.legs import Legs, UavLegs
from formulations.routing.columns.pricing import Duals, Effort, Priced, Pricer
from instances import Instance, tour_costs
from tests.formulations.routing.test_branch_and_price import random_instance


def small_tours(instance: Instance, k: int, cap: float) -> list[tuple[int, ...]]:
    """All tours of UAV k of cost ≤ cap, by plain extension."""
    tours: list[tuple[int, ...]] = []
    paths: list[tuple[int, ...]] = [()]
    while paths:
        paths = [(*p, i) for p in paths for i in instance.tasks if i not in p]
        for tasks in paths:
            routes = [()] * k + [tasks] + [()] * (instance.n_depots - k - 1)
            if tour_costs(instance, routes)[k] <= cap:
                tours.append(tasks)
    return tours


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("near", "bins", "watch"), [(0, 1, 0), (2, 3, 1), (4, 50, 2), (1, 20, 3)])
def test_pricing_bounds_every_tour_at_any_duals(seed: int, near: int, bins: int, watch: int) -> None:
    instance = random_instance(5, 2, seed)
    rng = np.random.default_rng(seed)
    cap = float(instance.cost.mean() * 5)
    duals = Duals(rng.normal(30, 40, 5), np.array([0.7, 0.3]), np.zeros(2), np.array([8.0]), ((0, 2, 3),))
    pricer = Pricer(Legs.of(instance), cap, Effort(near, bins, 10**6, watch), make_store(5, 10_000))
    for k in range(2):
        tours = small_tours(instance, k, cap)
        costs = [tour_costs(instance, [()] * k + [t] + [()] * (1 - k))[k] for t in tours]
        held = [len({0, 2, 3} & set(t)) >= 2 for t in tours]
        values = [
            duals.sigma[k] * c - duals.price[list(t)].sum() + 8.0 * h
            for t, c, h in zip(tours, costs, held, strict=True)
        ]
        assert least_of_all(pricer.subproblem(k, duals)) <= min(values, default=np.inf) + 1e-9
        priced = pricer.price(k, duals, 0.0)
        assert priced.complete
        if min(values, default=0.0) < 0:
            assert priced.least == pytest.approx(min(values), abs=1e-9)
            assert sorted(priced.columns[0].tasks) in [sorted(t) for t, v in zip(tours, values, strict=True) if v < 0]
        for beam in (1, 3, 8):  # labels left aside bound the tours that are then not found
            narrow = Pricer(Legs.of(instance), cap, Effort(near, bins, beam, watch), make_store(5, 10_000))
            assert narrow.price(k, duals, 0.0).least <= min(values, default=0.0) + 1e-9


def test_a_beam_gives_a_better_bound_than_none_of_the_labels() -> None:
    """What is left aside is not the worst that could be: the bound is the least label's there, not the depot's."""
    instance = random_instance(12, 1, 0)
    cap = float(instance.cost.mean() * 12)
    duals = Duals(np.full(12, 60.0), np.ones(1), np.zeros(1), np.zeros(0))
    pricer = Pricer(Legs.of(instance), cap, Effort(1, 20, 300), make_store(12, 100_000))
    priced, whole = pricer.price(0, duals, 0.0), Pricer(Legs.of(instance), cap, Effort(1, 20, 10**6), pricer.store)
    assert not priced.complete
    assert least_of_all(pricer.subproblem(0, duals)) + 1.0 < priced.least <= whole.price(0, duals, 0.0).least + 1e-9


@pytest.mark.parametrize("time_left", [60.0, 0.0])
def test_all_are_priced_as_each_is_and_none_once_time_is_up(time_left: float) -> None:
    """UAVs 0 and 1 are alike, also at these duals: one of them is priced for both."""
    cost = random_instance(6, 3, 1).cost.copy()
    cost[:, 7], cost[7] = cost[:, 6], cost[6]
    legs = Legs.of(Instance("alike", cost, 6, 3))
    duals = Duals(np.full(6, 90.0), np.array([0.3, 0.3, 0.4]), np.zeros(3), np.zeros(0))
    pricer = Pricer(legs, 300.0, Effort(2, 30, 10**6), make_store(6, 10_000), lambda: time_left)
    priced = pricer.price_all([0, 1, 2], duals, np.zeros(3))
    each = Pricer(legs, 300.0, Effort(2, 30, 10**6), make_store(6, 10_000))
    for k in range(3):
        assert priced[k] == (Priced(-np.inf, [], False) if time_left == 0 else each.price(k, duals, 0.0))
        assert time_left == 0 or {column.uav for column in priced[k].columns} == {k}
    assert pricer.firsts([2, 1, 0], duals, np.zeros(3)) == {2: 2, 1: 1, 0: 1}


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("near", "bins", "watch"), [(0, 40, 0), (1, 3, 2), (2, 40, 1), (3, 40, 6)])
def test_no_label_promises_less_than_the_best_tour_that_begins_so(seed: int, near: int, bins: int, watch: int) -> None:
    """The completion bounds at every state reached, with many dear cuts that overlap."""
    instance = random_instance(6, 1, seed)
    rng = np.random.default_rng(seed)
    cap = float(instance.cost.mean() * 6)
    cuts = tuple(c for c in itertools.combinations(range(6), 3) if rng.random() < 0.5)
    duals = Duals(rng.normal(40, 40, 6), np.ones(1), np.zeros(1), rng.uniform(0, 40, len(cuts)), cuts)
    store = make_store(6, 10_000)
    pricer = Pricer(Legs.of(instance), cap, Effort(near, bins, 10**6, watch), store)
    found = search(pricer.subproblem(0, duals), store, np.inf, no_limit, tours=10_000)
    values = {
        tour: tour_costs(instance, [tour])[0]
        - duals.price[list(tour)].sum()
        + sum(rho for cut, rho in zip(cuts, duals.rho, strict=True) if len(set(cut) & set(tour)) >= 2)
        for tour in small_tours(instance, 0, cap)
    }
    assert found.complete
    for label in range(found.labels):
        begin = path(store, label)
        best = min((v for tour, v in values.items() if tour[: len(begin)] == begin), default=np.inf)
        assert store.bound[label] <= best + 1e-9
    assert found.values.min(initial=np.inf) == pytest.approx(min(values.values(), default=np.inf))


def test_zero_legs_do_not_break_the_completion_bound() -> None:
    """All tasks in one place: every leg between them has zero bins, and their prices could be collected in a circle."""
    n, home = 6, np.full(6, 10.0)
    between = np.zeros((n, n))
    np.fill_diagonal(between, np.inf)
    legs = UavLegs(home, between, home)
    bins = Bins.of(legs, 25.0, 5)
    memory = Memory.nearest(between, 2)
    watch = Watch.of(memory.near, (), np.zeros(0), 0)
    best = completion(bins, memory, watch, np.full(n, 3.0), 1.0)
    assert bins.high.tolist() == [4] * n  # the leg from the depot takes two bins, rounded down by a hair
    assert best[0, 4, 0] <= 10.0 - 3.0 * (n - 1)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("most", [1, 7, 40])
def test_no_tour_asks_for_bins_that_completion_bounds_leave_out(seed: int, most: int) -> None:
    """Neither flown as it is nor the other way round; and where nobody asks there is nothing to be had."""
    instance = random_instance(5, 1, seed)
    cap, legs = float(instance.cost.mean() * 4), Legs.of(instance).of_uav(0)
    ahead, behind = Bins.of(legs, cap, most), Bins.of(legs, cap, most, backwards=True)
    memory = Memory.nearest(legs.between, 2)
    best = completion(ahead, memory, Watch.of(memory.near, (), np.zeros(0), 0), np.full(5, 50.0), 1.0)[:, :, 0]
    assert small_tours(instance, 0, cap)
    for tour in small_tours(instance, 0, cap):
        whole = tour_costs(instance, [tour])[0]
        for bins, order, first in ((ahead, tour, legs.out), (behind, tour[::-1], legs.home)):
            flown, before = 0.0, -1
            for task in order:
                leg = legs.between[before, task] if bins is ahead else legs.between[task, before]
                flown += first[task] if before < 0 else leg
                assert bins.low[task] <= bins_left(cap - flown, bins) <= bins.high[task]
                assert bins.low[task] <= bins_left(whole - flown, bins)
                before = task
    asked = np.arange(most + 1)
    assert np.isinf(best[(asked < ahead.low[:, None]) | (asked > ahead.high[:, None])]).all()
