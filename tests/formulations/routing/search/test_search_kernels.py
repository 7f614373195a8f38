"""Every kernel of ruin and recreate against a naive twin, on random asymmetric costs."""

from dataclasses import replace
from itertools import chain

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.search import recreate as rebuilding
from formulations.routing.search import ruin as ruining
from formulations.routing.search import tours as rings
from formulations.routing.search.annealing import AnnealingParameters, anneal, undo
from formulations.routing.search.costs import both_ways
from formulations.routing.search.energy import (
    MeasureKind,
    Objective,
    energy,
    energy_with,
    energy_without,
    excess,
    fitness,
    p_norm,
)
from formulations.routing.search.problem_data import (
    NeighbourhoodParameters,
    granular_neighbourhood,
    problem_data,
)
from formulations.routing.search.randomness import below, seeded, uniform
from formulations.routing.search.recreate import GUIDES, RecreateParameters
from formulations.routing.search.schedule import Schedule, ScheduleParameters
from formulations.routing.search.strategy import ONE_SITE, SEVERAL_DEPOTS
from instances import Instance, check_routes, makespan, tour_costs

seeds = st.integers(0, 10**6)
TIE = RecreateParameters().tie
NEAR = NeighbourhoodParameters(8, 3)


def neighbours(costs, n_tasks, tasks, depots):
    return granular_neighbourhood(costs, n_tasks, NeighbourhoodParameters(tasks, depots))


def room_for(count):
    return ruining.Removed(np.empty(count, np.int32), np.empty(count, np.int32), np.zeros(3, np.bool_))


def random_instance(seed, n=14, m=3):
    cost = np.random.default_rng(seed).uniform(1.0, 100.0, (n + m, n + m))
    np.fill_diagonal(cost, 0.0)
    return Instance(f"random {seed}", cost, n, m)


def random_routes(seed, n=14, m=3):
    rng = np.random.default_rng(seed)
    routes = [[] for _ in range(m)]
    for v in rng.permutation(n):
        routes[rng.integers(m)].append(int(v))
    return tuple(map(tuple, routes))


def test_random_numbers_are_uniform_and_repeatable():
    rng = seeded(3, 1)
    draws = np.array([uniform(rng) for _ in range(20_000)])
    assert draws.min() >= 0.0
    assert draws.max() < 1.0
    assert np.histogram(draws, 10, (0, 1))[0] == pytest.approx(2000, abs=250)
    assert [below(seeded(3, 1), 7) for _ in range(5)] == [below(seeded(3, 1), 7)] * 5
    assert uniform(seeded(3, 1)) != uniform(seeded(3, 2))
    faces = {below(rng, 4) for _ in range(200)}
    assert faces == {0, 1, 2, 3}


@given(seeds)
@settings(deadline=None, max_examples=20)
def test_neighbours_are_the_nearest_in_either_direction(seed):
    instance = random_instance(seed, 12, 4)
    near = neighbours(both_ways(instance.cost), 12, 5, 3)
    either = np.minimum(instance.cost, instance.cost.T)
    for v in range(12):
        others = [u for u in range(12) if u != v]
        assert near.tasks[v].tolist() == sorted(others, key=lambda u: either[u, v])[:5]
        assert near.depots[v].tolist() == sorted(range(12, 16), key=lambda u: either[u, v])[:3]


def test_neighbours_of_the_smallest_instances():
    near = neighbours(both_ways(random_instance(0, 1, 1).cost), 1, 20, 20)
    assert near.tasks.shape == (1, 0)
    assert near.depots.tolist() == [[1]]


@given(seeds)
@settings(deadline=None, max_examples=20)
def test_routes_survive_the_rings_and_costs_are_those_of_the_check(seed):
    instance, routes = random_instance(seed), random_routes(seed)
    tours = rings.from_routes(both_ways(instance.cost), routes)
    assert rings.to_routes(tours) == routes
    assert tours.cost == pytest.approx(tour_costs(instance, routes))
    assert tours.size.tolist() == [len(r) for r in routes]
    assert tours.arc.tolist() == [instance.cost[u, w] for u, w in enumerate(tours.after)]


def test_costs_are_copied_only_where_they_are_asymmetric():
    cost = random_instance(1).cost
    costs = both_ways(cost)
    assert np.array_equal(costs.into, cost.T)
    symmetric = cost + cost.T
    assert both_ways(symmetric).into is symmetric


@given(seeds)
@settings(deadline=None, max_examples=30)
def test_change_of_a_removal_and_of_an_insertion_is_the_recomputed_difference(seed):
    instance, routes = random_instance(seed), random_routes(seed)
    costs, n = both_ways(instance.cost), instance.n_tasks
    tours = rings.from_routes(costs, routes)
    rng = np.random.default_rng(seed)
    for _ in range(20):
        v = int(rng.integers(n))
        before = tour_costs(instance, rings.to_routes(tours))
        k, change = tours.tour[v], rings.removal_change(costs, tours, v)
        rings.unlink(costs, tours, v)
        assert tour_costs(instance, rings.to_routes(tours))[k] == pytest.approx(before[k] + change)
        u = int(rng.choice([u for u in range(n + 3) if u != v]))
        before = tour_costs(instance, rings.to_routes(tours))
        change = rings.insertion_change(costs, tours, v, u)
        rings.link(costs, tours, v, u)
        after = tour_costs(instance, rings.to_routes(tours))
        assert after[tours.tour[u]] == pytest.approx(before[tours.tour[u]] + change)
    assert check_routes(instance, rings.to_routes(tours)) == []


@pytest.mark.parametrize("way", ["adjacent", "strings"])
@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_ruin_books_its_costs_and_undoes_without_a_trace(way, seed):
    instance, routes = random_instance(seed), random_routes(seed)
    near = neighbours(both_ways(instance.cost), instance.n_tasks, 8, 3)
    tours = rings.from_routes(both_ways(instance.cost), routes)
    removed = room_for(6)
    if way == "adjacent":
        count = ruining.remove_adjacent(both_ways(instance.cost), near.tasks, tours, removed, seeded(seed))
    else:
        count = ruining.remove_strings(both_ways(instance.cost), near.tasks, tours, removed, seeded(seed))
    assert 1 <= count <= 6
    taken = set(removed.tasks[:count].tolist())
    left = tuple(tuple(v for v in route if v not in taken) for route in routes)
    assert len(taken) == count
    assert rings.to_routes(tours) == left
    assert tours.cost == pytest.approx(tour_costs(instance, left))
    assert all(tours.tour[v] == -1 for v in taken)
    ruining.restore(both_ways(instance.cost), tours, count, removed)
    assert rings.to_routes(tours) == routes


def guided(lengths, longest, guide):
    """What recreation lowers, from its definition."""
    shares = lengths / longest
    if guide.kind == MeasureKind.P_NORM:
        return (shares**guide.p).sum()
    return np.maximum(shares - 1.0, 0.0).sum() + TIE * shares.sum()


@pytest.mark.parametrize("guide", GUIDES)
@given(seed=seeds)
@settings(deadline=None, max_examples=15)
def test_best_insertion_is_the_best_of_all_where_the_lists_hold_all(guide, seed):
    instance, routes = random_instance(seed, 10), random_routes(seed, 10)
    costs = both_ways(instance.cost)
    near = neighbours(both_ways(instance.cost), 10, 9, 3)
    tours = rings.from_routes(costs, routes)
    v = seed % 10
    tours.cost[tours.tour[v]] += rings.removal_change(costs, tours, v)
    rings.unlink(costs, tours, v)
    left, longest = rings.to_routes(tours), tours.cost.max()
    norms = []
    for k, route in enumerate(left):
        for i in range(len(route) + 1):
            tried = (*left[:k], (*route[:i], v, *route[i:]), *left[k + 1 :])
            norms.append(guided(tour_costs(instance, tried), longest, guide))
    u, change = rebuilding.best_insertion(
        costs, near, tours, v, guide, 1.0 / longest, RecreateParameters(9), 0.0, seeded(seed)
    )
    k = tours.tour[u]
    rings.link(costs, tours, v, u)
    tours.cost[k] += change
    assert tours.cost == pytest.approx(tour_costs(instance, rings.to_routes(tours)))
    assert guided(tours.cost, longest, guide) == pytest.approx(min(norms))


def test_a_wider_recreation_sees_a_tour_that_passes_none_of_the_nearest_tasks():
    x = np.array([0.0, 1.0, 2.0, -3.0, 9.0, -10.0])  # tasks 0 to 3, two depots far off
    costs = both_ways(np.abs(x[:, None] - x))
    near = neighbours(costs, 4, 3, 1)  # one depot, of the long tour
    tours = rings.from_routes(costs, ((1, 2), (3,)))
    tours.cost[0] += 10.0  # so long that at p = 5 the tour of the farthest task is the better
    found = [
        rebuilding.best_insertion(costs, near, tours, 0, p_norm(5), 0.01, RecreateParameters(width), 0.0, seeded(1))[0]
        for width in (1, 2, 3)
    ]
    assert [tours.tour[u] for u in found] == [0, 0, 1]


@given(seeds)
@settings(deadline=None, max_examples=20)
def test_construction_and_recreation_book_what_they_build(seed):
    instance = random_instance(seed)
    tours = rings.empty_tours(14, 3)
    rebuilding.construct(problem_data(both_ways(instance.cost), 14, NEAR), tours, RecreateParameters(), seeded(seed))
    routes = rings.to_routes(tours)
    assert check_routes(instance, routes) == []
    assert tours.cost == pytest.approx(tour_costs(instance, routes))


def test_construction_where_all_costs_are_zero_or_huge():
    for scale in (0.0, 1e149):
        cost = Instance("flat", scale * (1.0 - np.eye(8)), 6, 2).cost
        tours = rings.empty_tours(6, 2)
        rebuilding.construct(problem_data(both_ways(cost), 6, NEAR), tours, RecreateParameters(), seeded(0))
        assert sorted(sum(rings.to_routes(tours), ())) == list(range(6))


def test_growth_is_the_difference_of_powers():
    for p in (1, 2, 5, 12, 30):
        assert rebuilding.power(1.3, p) == pytest.approx(1.3**p)
        assert rebuilding.growth(1.3, 0.4, p_norm(p), TIE) == pytest.approx(1.7**p - 1.3**p)


def test_the_last_guide_prefers_a_long_detour_with_time_to_spare_to_the_least_growth_of_the_longest():
    last, sharp = GUIDES[-1], p_norm(30)
    spare, longest = rebuilding.growth(0.5, 0.4, last, TIE), rebuilding.growth(1.0, 1e-3, last, TIE)
    assert spare < longest
    assert rebuilding.growth(0.5, 0.3, last, TIE) < spare
    assert rebuilding.growth(0.5, 0.4, sharp, TIE) > rebuilding.growth(1.0, 1e-4, sharp, TIE)


def test_shuffle_keeps_the_items_and_moves_them():
    queue = np.arange(50, dtype=np.int32)
    rebuilding.shuffle(queue, 40, seeded(1))
    assert sorted(queue[:40]) == list(range(40))
    assert queue[40:].tolist() == list(range(40, 50))
    assert (queue[:40] != np.arange(40)).sum() > 20


def test_undo_returns_to_the_tours_before_the_step():
    instance, routes = random_instance(5), random_routes(5)
    near = neighbours(both_ways(instance.cost), 14, 8, 3)
    tours = rings.from_routes(both_ways(instance.cost), routes)
    costs = tours.cost.copy()
    removed = room_for(6)
    rng = seeded(5)
    count = ruining.remove_adjacent(both_ways(instance.cost), near.tasks, tours, removed, rng)
    rebuilding.recreate(
        both_ways(instance.cost),
        near,
        tours,
        removed.tasks[:count].copy(),
        count,
        p_norm(5),
        RecreateParameters(8),
        rng,
    )
    undo(both_ways(instance.cost), tours, count, removed, costs)
    assert rings.to_routes(tours) == routes
    assert tours.cost.tolist() == costs.tolist()


@given(seeds)
@settings(deadline=None, max_examples=15)
def test_annealing_keeps_its_best_and_its_books(seed):
    instance, routes = random_instance(seed), random_routes(seed)
    data = problem_data(both_ways(instance.cost), 14, NEAR)
    tours, best, fittest = (rings.from_routes(both_ways(instance.cost), routes) for _ in range(3))
    objective, measure = Objective(p_norm(9), 0.1), excess(0.9 * makespan(instance, routes))
    how = AnnealingParameters(removals=6, moves=0.3, guides=4)
    anneal(data, tours, best, fittest, seeded(seed), 300, 5.0, objective, measure, how)
    for each in (tours, best, fittest):
        found = rings.to_routes(each)
        assert check_routes(instance, found) == []
        assert each.cost == pytest.approx(tour_costs(instance, found))
    assert best.cost.max() <= min(tours.cost.max(), fittest.cost.max(), makespan(instance, routes)) * (1 + 1e-12)
    assert fitness(fittest.cost, measure) <= min(fitness(each.cost, measure) for each in (tours, best)) + 1e-9


def test_energy_is_a_norm_plus_a_share_of_the_mean():
    lengths = np.array([3.0, 4.0])
    assert energy(lengths, Objective(p_norm(2), 0.5)) == pytest.approx(5.0 + 0.5 * 3.5)
    assert energy(np.zeros(2), Objective(p_norm(2), 0.5)) == 0.0


def test_in_the_end_energy_is_what_exceeds_the_cap_plus_a_share_of_the_mean():
    lengths = np.array([3.0, 4.0, 5.0])
    assert energy(lengths, Objective(excess(3.5), 0.5)) == (0.5 + 1.5) + 0.5 * 4.0
    assert energy(lengths, Objective(excess(9.0), 0.5)) == 0.5 * 4.0


SCHEDULE = ScheduleParameters()
COARSE, FINE = (Schedule(SCHEDULE.founder, 8.0, final) for final in (SCHEDULE.final, SEVERAL_DEPOTS.fine))


def legs(count: int) -> rings.Tours:
    """Return two tours whose longest, of 100 s, has `count` mean legs, empty ones among them."""
    tours = rings.empty_tours(int(1.6 * count) - 2, 2)
    tours.cost[:] = 100.0, 60.0
    return tours


def objective_at(done, schedule, count):
    return schedule.at(done, legs(count), 90.0, SCHEDULE)[1]


def test_the_norm_sharpens_as_the_temperature_falls_and_in_the_end_a_cap_counts():
    start, middle, end = (objective_at(done, COARSE, 1000) for done in (0.0, 0.4, 1.0))
    assert [start.measure, middle.measure] == [p_norm(178), p_norm(SCHEDULE.largest_p)]
    assert end.measure == excess(90.0 * (1.0 - SCHEDULE.final.margin))
    assert objective_at(1.0, FINE, 1000).measure == excess(90.0 * (1.0 - SEVERAL_DEPOTS.fine.margin))
    softened = [replace(COARSE, softness=softness) for softness in SCHEDULE.softness]
    assert [objective_at(0.4, schedule, 10).measure.p for schedule in softened] == [24, 98]
    assert (start.mean_weight, end.mean_weight) == pytest.approx(SCHEDULE.mean_weight)


def test_in_the_end_a_compact_annealing_weighs_each_tour_as_others_weigh_the_mean():
    compact = replace(COARSE, compact=True)
    assert objective_at(0.0, compact, 1000) == objective_at(0.0, COARSE, 1000)
    assert objective_at(1.0, compact, 1000).mean_weight == pytest.approx(2 * SCHEDULE.mean_weight[1])


def test_the_last_temperature_is_low_in_mean_legs_and_in_longest_tours():
    for count, schedule, last in (
        (1000, COARSE, SCHEDULE.last * 0.1),
        (10, COARSE, SCHEDULE.final.last * 100.0),
        (10, FINE, SEVERAL_DEPOTS.fine.last * 100.0),
    ):
        hot, cold = (schedule.at(done, legs(count), 90.0, SCHEDULE)[0] for done in (0.0, 1.0))
        assert hot == pytest.approx(SCHEDULE.founder * 100.0 / count)
        assert cold == pytest.approx(last)


@pytest.mark.parametrize(("strategy", "first", "most"), [(SEVERAL_DEPOTS, SCHEDULE.child, 400), (ONE_SITE, 0.05, 300)])
def test_annealings_are_fine_the_more_often_the_longer_nothing_new_was_found_and_at_one_site_begin_low(
    strategy, first, most
):
    rng = seeded(4)
    drawn = [
        [strategy.draw_schedule(SCHEDULE.child, stale, SCHEDULE, rng) for _ in range(400)] for stale in (0.0, 0.5, 9.0)
    ]
    fine = [sum(schedule.final == strategy.fine for schedule in schedules) for schedules in drawn]
    assert fine[0] == 0
    assert 160 < fine[1] < 240 < fine[2] <= most
    for schedule in chain(*drawn):
        assert schedule.softness in SCHEDULE.softness
        assert (schedule.first, schedule.final) in [(SCHEDULE.child, SCHEDULE.final), (first, strategy.fine)]


def test_reheatings_come_the_more_often_the_longer_nothing_new_was_found():
    rng = seeded(6)
    none, some, most = (sum(ONE_SITE.reheats(stale, rng) for _ in range(400)) for stale in (0.0, 0.4, 9.0))
    assert none == 0
    assert 50 < some < 110 < 130 < most < 190
    assert not SEVERAL_DEPOTS.reheats(9.0, rng)


def test_tours_that_cost_nothing_have_a_temperature_and_an_objective():
    temperature, objective = COARSE.at(0.5, rings.empty_tours(3, 2), 0.0, SCHEDULE)
    assert 0.0 <= temperature < 1e-9
    assert objective.measure.cap == 0.0


def test_of_two_with_the_same_longest_tour_the_one_with_fewer_long_ones_is_fitter():
    for measure in (p_norm(128), excess(9.0)):
        assert fitness(np.array([10.0, 9.9, 5.0]), measure) < fitness(np.array([10.0, 10.0, 1.0]), measure)


def test_many_tours_nearly_as_long_as_the_longest_known_are_no_fault():
    even, uneven = np.array([10.0, 10.0, 10.0]), np.array([10.05, 8.0, 8.0])
    assert fitness(even, excess(10.0)) < fitness(uneven, excess(10.0))
    assert fitness(even, p_norm(128)) > fitness(uneven, p_norm(128))


def test_tours_that_beat_the_best_known_are_the_fitter_the_more_they_do():
    better, good, known = (
        fitness(np.array(lengths), excess(10.0)) for lengths in ([9.0, 9.0], [9.5, 1.0], [10.0, 1.0])
    )
    assert better < good < known


@given(st.lists(st.floats(0.0, 1e4), min_size=2, max_size=6), st.integers(0, 9), st.sampled_from((2, 7, 64, "excess")))
@settings(deadline=None, max_examples=60)
def test_a_partial_energy_and_two_lengths_make_the_energy(lengths, pick, p):
    tours = rings.empty_tours(0, len(lengths))
    tours.cost[:] = lengths
    a, b = pick % len(lengths), (pick + 1) % len(lengths)
    objective = Objective(excess(0.6 * max(lengths)) if p == "excess" else p_norm(p), 0.3)
    partial, whole = energy_without(tours, a, b, objective), energy(tours.cost, objective)
    assert energy_with(partial, lengths[a], lengths[b]) == pytest.approx(whole, rel=1e-12, abs=1e-12)
