"""The greedy construction and the genetic algorithm's operators, each against a naive twin or a count."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing import ga
from formulations.routing.ga import (
    border_line,
    breed,
    depot_distance,
    keep_elite,
    nearest_depots,
    random_chromosome,
    unborn,
    winner,
)
from formulations.routing.ga_operators import (
    Chromosome,
    Population,
    best_cost_route_crossover,
    chromosome,
    evaluate,
    insert_best,
    inter_depot_mutation,
    intra_depot_mutation,
    legs_of,
)
from formulations.routing.greedy import VARIANTS
from formulations.routing.recorder import Recorder
from formulations.routing.registry import make_solver
from formulations.routing.search.costs import both_ways
from instances import InputError, Instance, Routes, as_routes, check_routes, makespan, tour_costs

Windy = Callable[..., Instance]


def naive_insertions(instance: Instance, routes: Routes) -> list[tuple[float, int, int, Routes]]:
    """Return (cost of the tour then, UAV, task, routes then) of every insertion."""
    routed = {task for route in routes for task in route}
    choices = []
    for k, route in enumerate(routes):
        for task in set(instance.tasks) - routed:
            for at in range(len(route) + 1):
                longer = (*routes[:k], (*route[:at], task, *route[at:]), *routes[k + 1 :])
                choices.append((tour_costs(instance, longer)[k], k, task, longer))
    return choices


def naive_cheapest(instance: Instance, routes: Routes) -> Routes:
    return min(naive_insertions(instance, routes))[-1]


def naive_shortest(instance: Instance, routes: Routes) -> Routes:
    shortest = int(np.argmin(tour_costs(instance, routes)))
    return min(choice for choice in naive_insertions(instance, routes) if choice[1] == shortest)[-1]


def naive_regret(instance: Instance, routes: Routes) -> Routes:
    best: dict[int, dict[int, tuple[float, Routes]]] = {}
    for cost, k, task, longer in sorted(naive_insertions(instance, routes), reverse=True):
        best.setdefault(task, {})[k] = cost, longer
    ranked = [sorted(tours.values()) for tours in best.values()]
    if instance.n_depots == 1:
        return min(tours[0] for tours in ranked)[-1]
    return max(ranked, key=lambda tours: tours[1][0] - tours[0][0])[0][-1]


def naive_nearest(instance: Instance, routes: Routes) -> Routes:
    k = int(np.argmin(tour_costs(instance, routes)))
    last = routes[k][-1] if routes[k] else instance.n_tasks + k
    left = set(instance.tasks) - {task for route in routes for task in route}
    nearest = min(left, key=lambda task: instance.cost[last, task])
    return (*routes[:k], (*routes[k], nearest), *routes[k + 1 :])


NAIVE = {"regret": naive_regret, "cheapest": naive_cheapest, "shortest": naive_shortest, "nearest": naive_nearest}


@pytest.mark.parametrize("variant", VARIANTS)
@given(st.integers(1, 10), st.integers(1, 4), st.integers(0, 10**6))
@settings(deadline=None, max_examples=25)
def test_every_greedy_variant_is_its_naive_twin(windy: Windy, variant: str, n: int, m: int, seed: int) -> None:
    instance = windy(n, m, seed)
    routes: Routes = ((),) * m
    for _ in instance.tasks:
        routes = NAIVE[variant](instance, routes)
    result = make_solver("greedy", {"variant": variant}).solve(instance, limits=Limits(time=60))
    assert result.routes == routes


def test_greedy_whose_time_is_up_still_routes_every_task(windy: Windy) -> None:
    instance = windy(60, 3, 0)
    result = make_solver("greedy").solve(instance, limits=Limits(time=1e-9))
    assert result.stopped_by == "time"
    nearest = make_solver("greedy", {"variant": "nearest"}).solve(instance, limits=Limits(time=60))
    assert result.routes == nearest.routes
    assert check_routes(instance, result.routes) == []


def test_greedy_keeps_a_better_start_and_names_an_unknown_variant(windy: Windy) -> None:
    instance = windy(30, 3, 1)
    good = make_solver("ruin-recreate").solve(instance, limits=Limits(time=60, iterations=3000)).routes
    assert make_solver("greedy").solve(instance, limits=Limits(time=60), start=good).routes == good
    with pytest.raises(InputError, match="did you mean 'regret'"):
        make_solver("greedy", {"variant": "regrett"})


def a_chromosome(windy: Windy, n: int, m: int, seed: int) -> tuple[Instance, Chromosome]:
    instance = windy(n, m, seed)
    rng = np.random.default_rng(seed)
    perm = rng.permutation(n).astype(np.int64)
    cuts = np.sort(rng.integers(0, n + 1, m - 1))
    sizes = np.diff([0, *cuts, n]).astype(np.int64)
    tours = Chromosome(perm, sizes, np.zeros(m))
    evaluate(both_ways(instance.cost), tours)
    return instance, tours


def together(*all_tours: Chromosome) -> Population:
    return Population(*(np.stack(part) for part in zip(*all_tours, strict=True)), np.zeros(len(all_tours)))


def routes_of(tours: Chromosome) -> Routes:
    return as_routes(np.split(tours.perm, np.cumsum(tours.sizes)[:-1]))


@given(st.integers(1, 12), st.integers(1, 4), st.integers(0, 10**6))
@settings(deadline=None, max_examples=60)
def test_every_operator_keeps_a_chromosome_a_a_chromosome(windy: Windy, n: int, m: int, seed: int) -> None:
    instance, first = a_chromosome(windy, n, m, seed)
    _, second = a_chromosome(windy, n, m, seed + 1)
    evaluate(both_ways(instance.cost), second)
    rng = np.random.default_rng(seed)
    pair = together(first, second)
    costs = both_ways(instance.cost)
    best_cost_route_crossover(costs, rng, pair)
    for row in range(2):
        child = chromosome(pair, row)
        intra_depot_mutation(costs, rng, child)
        inter_depot_mutation(costs, rng, child, border_line(instance, 2.0))
        routes = routes_of(child)
        assert check_routes(instance, routes) == []
        fitness = evaluate(both_ways(instance.cost), child)
        assert fitness == pytest.approx(makespan(instance, routes))
        assert child.totals == pytest.approx(tour_costs(instance, routes))


@pytest.mark.parametrize("seed", range(5))
def test_insertion_takes_the_place_of_least_c_max(windy: Windy, seed: int) -> None:
    instance, tours = a_chromosome(windy, 7, 3, seed)
    task, last = tours.perm[-1], int(np.flatnonzero(tours.sizes)[-1])
    before = routes_of(tours)
    before = (*before[:last], before[last][:-1], *before[last + 1 :])
    tours.sizes[last] -= 1
    evaluate(both_ways(instance.cost), tours)
    legs = legs_of(both_ways(instance.cost), tours)
    insert_best(both_ways(instance.cost), tours, legs, task, np.ones(3, dtype=np.bool_))
    assert legs.tolist() == legs_of(both_ways(instance.cost), tours).tolist()
    every = [
        (*before[:k], (*route[:at], int(task), *route[at:]), *before[k + 1 :])
        for k, route in enumerate(before)
        for at in range(len(route) + 1)
    ]
    assert makespan(instance, routes_of(tours)) == pytest.approx(min(makespan(instance, r) for r in every))


def test_crossover_leaves_the_other_routes_in_order(windy: Windy) -> None:
    """The tasks that a child is not given anew keep their order and their depot."""
    instance, first = a_chromosome(windy, 10, 2, 3)
    _, second = a_chromosome(windy, 10, 2, 4)
    parents = routes_of(first), routes_of(second)
    pair = together(first, second)
    rng = np.random.default_rng(0)
    k = int(np.random.default_rng(0).integers(0, 2))
    best_cost_route_crossover(both_ways(instance.cost), rng, pair)
    for child in range(2):
        moved = set(parents[1 - child][k])
        kept = [[i for i in route if i not in moved] for route in parents[child]]
        after = routes_of(chromosome(pair, child))
        assert [[i for i in route if i not in moved] for route in after] == kept


def test_first_chromosomes_group_by_nearest_depot_and_share_a_place(windy: Windy) -> None:
    base = windy(20, 3, 0)
    nodes = [*range(21), 20, 22]  # two UAVs at the first depot
    instance = Instance("shared", base.cost[np.ix_(nodes, nodes)], 20, 3)
    distance = depot_distance(instance)
    used = set()
    for seed in range(10):
        perm, sizes = random_chromosome(nearest_depots(instance), np.random.default_rng(seed))
        routes = as_routes(np.split(perm, np.cumsum(sizes)[:-1]))
        assert check_routes(instance, routes) == []
        for k, route in enumerate(routes):
            assert all(distance[task, k] == distance[task].min() for task in route)
            used |= {k} if route else set()
    assert {0, 1} <= used


def test_border_line_tasks_are_those_within_the_bound() -> None:
    cost = np.zeros((4, 4))
    cost[:2, 2:] = [[1.0, 2.9], [1.0, 3.1]]  # twice the nearest and more is 3 × 1
    cost[2:, :2] = cost[:2, 2:].T
    instance = Instance("border", cost, 2, 2)
    assert border_line(instance, 2.0).tolist() == [[True, True], [True, False]]


def test_tournament_prefers_the_fitter() -> None:
    fitness = np.array([3.0, 1.0, 2.0])
    rng = np.random.default_rng(0)
    wins = np.bincount([winner(rng, fitness, 2, 0.8) for _ in range(4000)], minlength=3) / 4000
    # of two entrants the fitter wins with 0.8 + 0.2 / 2: fittest 1/3·(1/3 + 2·2/3·0.9), …
    assert wins == pytest.approx([1 / 9 + 4 / 9 * 0.1, 1 / 9 + 4 / 9 * 0.9, 1 / 9 + 2 / 9], abs=0.03)


def test_elite_survives(windy: Windy) -> None:
    instance, tours = a_chromosome(windy, 8, 2, 0)
    rng = np.random.default_rng(0)
    people = together(*[tours] * 20)
    for row, perm in enumerate(people.perms):
        rng.shuffle(perm)
        people.fitness[row] = evaluate(both_ways(instance.cost), chromosome(people, row))
    costs, candidates = both_ways(instance.cost), border_line(instance, 2.0)
    for _ in range(10):
        best, children = people.fitness.min(), unborn(20, 8, 2)
        breed(costs, rng, people, children, (0, 20), candidates, 2, False, (0.8, 0.6, 0.2))
        keep_elite(rng, people, children, 2)
        people = children
        assert people.fitness.min() <= best


def test_bad_options_are_named() -> None:
    for options, name in (({"population": 1}, "population"), ({"crossover_rate": 1.5}, "crossover_rate")):
        with pytest.raises(InputError, match=name):
            make_solver("ga", options)
    with pytest.raises(InputError, match="span_weight"):
        make_solver("routing-library", {"span_weight": 0})


def test_ga_whose_time_is_up_in_its_first_population_has_routes(windy: Windy) -> None:
    instance = windy(30, 3, 0)
    result = make_solver("ga").solve(instance, limits=Limits(time=1e-9))
    assert (result.stopped_by, result.statistics["generations"]) == ("time", 0)
    assert check_routes(instance, result.routes) == []


def test_ga_stops_within_a_generation(windy: Windy, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten chromosomes, two looks at the clock a generation, time for three of them: the second generation is cut."""
    monkeypatch.setattr(ga, "_LOOKS", 3 * 40**2)
    looks = iter([1.0] * (10 + 2 + 2 + 1))
    monkeypatch.setattr(Recorder, "remaining", property(lambda self: next(looks, 0.0)))
    result = make_solver("ga", {"population": 10}).solve(windy(40, 3, 0), limits=Limits(time=60))
    assert (result.stopped_by, result.statistics["generations"]) == ("time", 1)


def test_ga_ends_with_its_generations(windy: Windy) -> None:
    result = make_solver("ga", {"generations": 5, "population": 20}).solve(windy(8, 2, 0), limits=Limits(time=60))
    assert result.stopped_by == "finished"
    assert result.statistics["generations"] == 5
