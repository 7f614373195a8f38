"""The pool of listed tours: its scan against plain sums, and lists of some UAVs only."""

import itertools
import math

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.columns.generation import generate
from formulations.routing.columns.label_search import Orders, _projected
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import Master
from formulations.routing.columns.pool import Pool, PoolPricer, list_tours
from formulations.routing.columns.pricing import Column, DualBound, Duals, Effort, Pricer
from formulations.routing.columns.tightening import hint
from formulations.routing.recorder import Recorder
from formulations.routing.search_beside import search_around
from formulations.routing.solver import ignore
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, check_routes

N = 70  # two words a set


def random_pool(seed):
    """Tours of UAV 1, listed first, and of UAV 0 over random sets, the sets themselves, duals and reduced costs."""
    rng = np.random.default_rng(seed)
    pool, sets, costs = Pool.empty(2, N), [], []
    for k in (1, 0):
        of_k = [sorted(rng.choice(N, rng.integers(1, 12), replace=False).tolist()) for _ in range(50)]
        visited = np.zeros((50, 2), np.uint64)
        for p, tasks in enumerate(of_k):
            for i in tasks:
                visited[p, i // 64] |= np.uint64(1) << np.uint64(i % 64)
        cost, labels = rng.uniform(1, 50, 50), np.arange(50)
        orders = Orders(np.zeros(50, np.int16), np.full(50, -1, np.int32))
        pool = pool.listing(k, visited, cost, labels, orders)
        sets += of_k
        costs += cost.tolist()
    cuts = tuple(tuple(sorted(c)) for c in {tuple(sorted(rng.choice(N, 3, replace=False).tolist())) for _ in range(60)})
    duals = Duals(rng.normal(3, 5, N), np.array([0.3, 0.7]), np.zeros(2), rng.uniform(0, 9, len(cuts)), cuts)
    values = np.array([
        duals.sigma[1 if p < 50 else 0] * costs[p] - duals.price[tasks].sum()
        + sum(r for cut, r in zip(cuts, duals.rho, strict=True) if len(set(cut) & set(tasks)) >= 2)
        for p, tasks in enumerate(sets)
    ])  # fmt: skip
    return pool, sets, duals, values


@pytest.mark.parametrize("seed", range(5))
def test_a_scan_finds_all_tours_below_the_threshold_and_the_least(seed):
    pool, _, duals, values = random_pool(seed)
    pricer = PoolPricer(pool)
    for k, of_k in ((1, values[:50]), (0, values[50:])):
        for threshold in (float(np.median(of_k)), float(of_k.min()) - 1.0):
            priced = pricer.price(k, duals, threshold)
            assert priced.least == pytest.approx(of_k.min())
            assert len(priced.columns) == (of_k < threshold).sum()
            assert all(c.uav == k for c in priced.columns)


@pytest.mark.parametrize("seed", range(5))
def test_tours_that_are_not_needed_go_and_only_those(seed):
    pool, sets, duals, values = random_pool(seed)
    least = np.array([values[50:].min(), values[:50].min()])
    gap = 10.0
    keep = np.concatenate([values[:50] <= gap + least[1], values[50:] <= gap + least[0]])
    left = pool.needed(DualBound(100.0, duals, least), 100.0 + gap)
    assert 0 < left.size < pool.size
    assert left.cost == pytest.approx(pool.cost[keep])
    kept = [tasks for tasks, stays in zip(sets, keep, strict=True) if stays]
    assert [np.flatnonzero([left.holds(i)[p] for i in range(N)]).tolist() for p in range(left.size)] == kept


def test_what_a_uav_may_visit_follows_from_its_tours():
    pool, sets, _, _ = random_pool(0)
    without = pool.without(sets[0][0], [1])
    assert pool.may_visit(N)[1, sets[0][0]]
    assert not without.may_visit(N)[1, sets[0][0]]
    assert (without.may_visit(N)[0] == pool.may_visit(N)[0]).all()


@pytest.mark.parametrize("seed", range(6))
def test_with_some_uavs_listed_the_bound_is_valid_and_no_weaker(seed):
    """UAV 1 may visit few tasks and is listed first; with few labels not all are."""
    rng = np.random.default_rng(seed)
    cost = rng.uniform(1.0, 50.0, (10, 10))
    np.fill_diagonal(cost, 0.0)
    instance = Instance("random", cost, 7, 3)
    optimum = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
    cap = 1.6 * optimum
    legs = Legs.of(instance).under(cap)
    few = legs.without(0, [1]).without(1, [1]).without(2, [1]).without(3, [1])
    store = make_store(7, 10_000)

    def pricer():
        return Pricer(few, cap, Effort(3, 50, 10**6), store)

    def bound(prices):
        return generate(Master(7, np.arange(3), cap), [prices], cap, lambda: np.inf).best

    alone = bound(pricer())
    pool, reserve, in_vain = list_tours(none := Pool.empty(3, 7), pricer(), alone, 15, 10_000, none)
    assert pool.listed[1]
    assert not pool.complete
    assert in_vain > 0
    assert not (reserve.listed & pool.listed).any()
    mixed = bound(PoolPricer(pool, pricer()))
    assert mixed.value >= alone.value * (1 - 1e-6)
    whole, _, in_vain = list_tours(pool, pricer(), alone, 10_000, 10_000, none)
    assert whole.complete
    assert in_vain == 0
    listed = bound(PoolPricer(whole))
    assert listed.value >= mixed.value * (1 - 1e-6)
    best = min(longest for giving, longest in longest_tours(instance) if 1 not in giving[:4])
    assert mixed.value <= best * (1 + 1e-9) or best > cap
    assert listed.value <= best * (1 + 1e-9) or best > cap


def test_a_uav_of_too_many_tours_is_passed_over_and_some_of_them_are_kept_in_reserve():
    """UAV 0 does not fit; the others, of which hardly a tour matters, are listed after it."""
    points = np.random.default_rng(3).uniform(0.0, 1.0, (11, 2))
    instance = Instance("plane", np.hypot(*(points[:, None] - points).transpose(2, 0, 1)), 8, 3)
    legs = Legs.of(instance).without(0, [0])
    pricer = Pricer(legs, 9.0, Effort(3, 50, 10**6), make_store(8, 10_000))
    duals = Duals(np.zeros(8), np.full(3, 0.3), np.zeros(3), np.zeros(0))
    at, none = DualBound(0.0, duals, np.array([0.0, -8.9, -8.9])), Pool.empty(3, 8)
    lists = list_tours(none, pricer, at, 60, 10_000, none)
    assert lists.pool.listed.tolist() == [False, True, True]
    assert lists.in_vain > 0
    assert not (lists.reserve.listed & lists.pool.listed).any()
    again = list_tours(lists.pool, pricer, at, 70, 10_000, lists.reserve, known_are_of_here=True)
    assert again.reserve.listed.tolist() == lists.reserve.listed.tolist() == [True, False, False]
    assert again.reserve.size == lists.reserve.size
    not_looked_for = list_tours(lists.pool, pricer, at, 70, 10_000, none, known_are_of_here=True)
    assert not not_looked_for.reserve.listed.any()
    whole = list_tours(none, pricer, at, 10_000, 10_000, none)
    assert whole.pool.complete
    assert (whole.reserve.size, whole.in_vain) == (0, 0)


def test_the_same_is_listed_however_many_are_looked_at_side_by_side(monkeypatch):
    """Also where one of them takes the room that the next had: with few labels, and with a reserve of fewer."""
    cost = np.random.default_rng(2).uniform(0, 9, (13, 13)) * ~np.eye(13, dtype=bool)
    instance = Instance("any", cost, 8, 5)
    pricer = Pricer(Legs.of(instance), 30.0, Effort(3, 50, 10**6), make_store(8, 90_000))
    duals = Duals(np.full(8, 4.0), np.full(5, 0.2), np.zeros(5), np.zeros(0))
    at, none, fates = DualBound(24.0, duals, np.linspace(-30.0, -10.0, 5)), Pool.empty(5, 8), set()
    for labels, kept, room in itertools.product((20, 200, 2000, 90_000), (10, 100, 1000, 90_000), (5, 300, 90_000)):
        monkeypatch.setattr("formulations.routing.columns.pool._RESERVE_LABELS", kept)
        alone, *together = (list_tours(none, pricer, at, labels, room, none, at_once=few) for few in (1, 2, 3))
        for lists in together:
            assert lists.in_vain == alone.in_vain
            for one, other in ((lists.pool, alone.pool), (lists.reserve, alone.reserve)):
                assert one.listed.tolist() == other.listed.tolist()
                assert (one.visited.tolist(), one.cost.tolist()) == (other.visited.tolist(), other.cost.tolist())
        fates.add((bool(alone.pool.listed.any()), bool(alone.reserve.listed.any())))
    assert fates == set(itertools.product((False, True), repeat=2))


def longest_tours(instance):
    """Of all ways to give the tasks to the UAVs: whose task each is, and the cost of the longest tour at best."""
    cost, best = instance.cost.tolist(), {}
    for k in range(instance.n_depots):
        for size in range(instance.n_tasks + 1):
            for tasks in itertools.combinations(instance.tasks, size):
                closed = (
                    [instance.n_tasks + k, *order, instance.n_tasks + k] for order in itertools.permutations(tasks)
                )
                best[k, tasks] = min(sum(cost[u][w] for u, w in itertools.pairwise(nodes)) for nodes in closed)
    for giving in itertools.product(range(instance.n_depots), repeat=instance.n_tasks):
        tours = [tuple(i for i in instance.tasks if giving[i] == k) for k in range(instance.n_depots)]
        yield giving, max(best[k, tour] for k, tour in enumerate(tours))


def test_layers_to_come_are_not_overestimated():
    layers = [math.comb(30, k) for k in range(1, 31)]
    for k in range(3, 14):
        assert 0.0 < _projected(layers[:k]) <= sum(layers[k:])


def test_a_search_around_a_tour_keeps_it():
    rng = np.random.default_rng(1)
    cost = rng.uniform(1.0, 50.0, (15, 15))
    np.fill_diagonal(cost, 0.0)
    instance = Instance("random", cost, 12, 3)
    recorder = Recorder(instance, Limits(time=60.0), ignore, None)
    search_around(recorder, Column(1, (4, 2, 7), 0.0), 500, 0, 10.0)
    assert recorder.routes is not None
    assert check_routes(instance, recorder.routes) == []
    assert recorder.routes[1] == (4, 2, 7)


def test_the_tours_to_search_around_are_the_longest_of_the_uavs_that_set_the_relaxation():
    master = Master(2, np.arange(2), 100.0)
    master.add([Column(0, (0,), 50.0), Column(0, (0, 1), 60.0), Column(1, (1,), 20.0)])

    def found(sigma):
        duals = Duals(np.zeros(2), np.array([sigma, 1 - sigma]), np.zeros(2), np.zeros(0))
        return hint(master, DualBound(30.0, duals, np.zeros(2)), np.array([0.7, 0.3, 0.0]))

    assert found(0.95).long == [master.columns[1]]
    assert found(0.4).long == [master.columns[1]]
    assert found(0.05).long == []
    assert found(0.95).used == [(master.columns[0], 0.7), (master.columns[1], 0.3)]


def test_of_several_uavs_that_set_the_relaxation_the_one_that_sets_most_comes_first():
    master = Master(2, np.arange(2), 100.0)
    master.add([Column(0, (0,), 50.0), Column(1, (1,), 20.0)])
    duals = Duals(np.zeros(2), np.array([0.4, 0.6]), np.zeros(2), np.zeros(0))
    assert hint(master, DualBound(30.0, duals, np.zeros(2)), np.ones(2)).long == master.columns[::-1]
