"""Edge assembly: cycles take the legs that differ, children cost what they say, and it finds the optimum."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.search import ab_cycles, edge_assembly, ring_children
from formulations.routing.search import giant_tour as giant
from formulations.routing.search.candidate_legs import candidate_legs
from formulations.routing.search.chained_search import ChainParameters
from formulations.routing.search.costs import search_costs
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.tours import from_routes, to_routes
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, check_routes, makespan

N, M = 19, 3
ALWAYS = ChainParameters(fewest=1, for_each=0)
FULL = SearchParameters()
seeds = st.integers(0, 10**6)


class Assembled(Memetic):
    """memetic that takes every instance with one depot for one of long tours."""

    parameters = replace(FULL, chain=ALWAYS)


def site(seed, n=N, m=M):
    """Random points with the m UAVs at one of them."""
    points = np.random.default_rng(seed).uniform(0.0, 100.0, (n + m, 2))
    points[n:] = points[n]
    return Instance("one-site", np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1)), n, m)


def ring(instance, seed):
    rng = np.random.default_rng(seed)
    cuts = np.sort(rng.integers(0, N + 1, M - 1))
    routes = tuple(tuple(part.tolist()) for part in np.split(rng.permutation(N), cuts))
    costs = search_costs(instance)
    return costs, giant.giant_tour(costs, from_routes(costs, routes))


def legs(order):
    return sorted(tuple(sorted((int(v), int(w)))) for v, w in pairwise(order))


@settings(max_examples=30)
@given(seed=seeds)
def test_all_cycles_together_turn_one_ring_into_the_other(seed):
    instance = site(seed)
    _, a = ring(instance, seed + 1)
    _, b = ring(instance, seed + 2)
    cycles = ab_cycles.ab_room(N + M)
    found = ab_cycles.find_cycles(a, b, cycles, seeded(seed, 0))
    left, named = legs(a.order), legs(cycles.name[b.order])
    for c in range(found):
        nodes = cycles.nodes[cycles.begins[c] : cycles.begins[c + 1]]
        assert len(nodes) % 2 == 0
        for x in range(0, len(nodes), 2):
            left.remove(tuple(sorted((int(nodes[x]), int(nodes[x + 1])))))
            left.append(tuple(sorted((int(nodes[x + 1]), int(nodes[(x + 2) % len(nodes)])))))
    assert sorted(left) == named
    assert sorted(cycles.name) == list(range(N + M))


@settings(max_examples=30)
@given(seed=seeds)
def test_a_child_is_one_ring_and_costs_what_it_says(seed):
    instance = site(seed)
    costs, a = ring(instance, seed + 1)
    _, b = ring(instance, seed + 2)
    near = candidate_legs(costs.out, N, N, 1, N)
    cycles, child, best = ab_cycles.ab_room(N + M), ring_children.child_room(99), ring_children.child_room(99)
    counted = np.zeros((N + M, N + M), np.int16)
    mating = edge_assembly.Mating(costs, near, cycles, child, best, counted)
    pressure = giant.Pressure(a.sums[-1] / M, 200.0)
    for c in range(ab_cycles.find_cycles(a, b, cycles, seeded(seed, 0))):
        if not edge_assembly._assemble(mating, a, c):
            continue
        said = ring_children.child_energy(costs, a, child, pressure)
        made = edge_assembly._copied(a)
        ring_children.become(costs, made, child)
        assert sorted(made.order[:-1]) == list(range(N + M))
        assert made.order[0] == made.order[-1] == N
        cost = giant.tours_of(costs, made.order, M).cost
        assert said == pytest.approx(float((200.0 * np.exp((cost - pressure.mean) / 200.0)).sum()), rel=1e-9)
        assert np.all(made.order[made.starts[:-1]] >= N)


@settings(max_examples=20)
@given(seed=seeds)
def test_a_ring_crossed_is_never_worse_and_its_legs_are_counted(seed):
    instance = site(seed)
    rings = [ring(instance, seed + i)[1] for i in range(2)]
    costs = search_costs(instance)
    counted = np.zeros((N + M, N + M), np.int16)
    for one in rings:
        np.add.at(counted, (one.order[:-1], one.order[1:]), 1)
        np.add.at(counted, (one.order[1:], one.order[:-1]), 1)
    near = candidate_legs(costs.out, N, N, 1, N)
    rooms = ring_children.child_room(99), ring_children.child_room(99)
    mating = edge_assembly.Mating(costs, near, ab_cycles.ab_room(N + M), *rooms, counted)
    before = float(rings[0].sums[-1])
    better = edge_assembly.cross(mating, rings[0], rings[1], 2, 30, 1e7, seeded(seed, 1))
    assert float(rings[0].sums[-1]) < before if better else float(rings[0].sums[-1]) == before
    expected = np.zeros_like(counted)
    for one in rings:
        np.add.at(expected, (one.order[:-1], one.order[1:]), 1)
        np.add.at(expected, (one.order[1:], one.order[:-1]), 1)
    assert np.array_equal(counted, expected)


@pytest.mark.parametrize("seed", range(3))
def test_it_finds_the_optimum_of_small_instances(seed):
    instance = site(seed, 11, 2)
    best = SubsetDp().solve(instance, limits=Limits(time=60.0)).objective
    result = Assembled().solve(instance, limits=Limits(time=60.0, iterations=30_000), seed=seed)
    check_routes(instance, result.routes)
    assert makespan(instance, result.routes) == pytest.approx(best)


def test_what_it_says_is_what_its_tours_cost():
    instance = site(5, 60, 3)
    data = problem_data(search_costs(instance), 60, FULL.neighbourhood)
    search = edge_assembly.EdgeAssembly(data, ALWAYS, FULL.assembly._replace(size=12), seeded(1, 0))
    longest = [search.longest]
    for i in range(200):
        assert search.advance(i / 200, 100) == (search.longest < longest[-1])
        longest.append(search.longest)
        assert float(search.best().cost.max()) == pytest.approx(search.longest, rel=1e-9)
    check_routes(instance, to_routes(search.best()))
    assert longest[-1] < 0.98 * longest[0]
