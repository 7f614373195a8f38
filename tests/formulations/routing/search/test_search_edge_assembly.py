"""Edge assembly: cycles take the legs that differ, children cost what they say, and it finds the optimum."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.search import ab_cycles, edge_assembly, ring_children, ring_energy
from formulations.routing.search import giant_tour as giant
from formulations.routing.search.candidate_legs import candidate_legs
from formulations.routing.search.chain_moves import ChainParameters
from formulations.routing.search.costs import search_costs
from formulations.routing.search.handover import HandoverParameters
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.tours import to_routes
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, check_routes, makespan

N, M = 19, 3
HOW = ChainParameters()
FULL = SearchParameters()
seeds = st.integers(0, 10**6)


class Assembled(Memetic):
    """memetic that takes every instance with one depot for one of long tours."""

    parameters = replace(FULL, handover=HandoverParameters(fewest=1, for_each=0))


def site(seed, n=N, m=M):
    """Random points with the m UAVs at one of them."""
    points = np.random.default_rng(seed).uniform(0.0, 100.0, (n + m, 2))
    points[n:] = points[n]
    return Instance("one-site", np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1)), n, m)


def ring(instance, seed):
    rng = np.random.default_rng(seed)
    cuts = np.sort(rng.integers(0, N + 1, M - 1))
    tours = np.split(rng.permutation(N), cuts)
    order = np.concatenate([np.append(N + k, tour) for k, tour in enumerate(tours)] + [[N]]).astype(np.int32)
    costs = search_costs(instance)
    return costs, giant.giant_tour(costs, order, M)


def merged(v):
    """The node, N for every depot: they are at one place."""
    return min(int(v), N)


def legs(order):
    return sorted(tuple(sorted((merged(v), merged(w)))) for v, w in pairwise(order))


def mating(costs):
    """What crossing works with where every leg is a candidate."""
    near = candidate_legs(costs.out, N, N, 1, N)
    return edge_assembly.Mating(costs, near, ab_cycles.ab_room(N + M), ring_children.child_room(99))


@settings(max_examples=30)
@given(seed=seeds)
def test_all_cycles_together_turn_one_ring_into_the_other(seed):
    instance = site(seed)
    _, a = ring(instance, seed + 1)
    _, b = ring(instance, seed + 2)
    cycles = ab_cycles.ab_room(N + M)
    found = ab_cycles.find_cycles(a, b, cycles, seeded(seed, 0))
    left = legs(a.order)
    for c in range(found):
        nodes = cycles.nodes[cycles.begins[c] : cycles.begins[c + 1]]
        assert len(nodes) % 2 == 0
        for x in range(0, len(nodes), 2):
            u, v, w = nodes[x], nodes[x + 1], nodes[(x + 2) % len(nodes)]
            assert v in (a.order[a.position[u] + 1], a.order[a.position[u] - 1 if a.position[u] > 0 else -2])
            left.remove(tuple(sorted((merged(u), merged(v)))))
            left.append(tuple(sorted((merged(v), merged(w)))))
    assert sorted(left) == legs(b.order)


@settings(max_examples=30)
@given(seed=seeds)
def test_no_cycle_comes_to_a_node_twice_in_the_same_way(seed):
    instance = site(seed)
    (_, a), (_, b) = ring(instance, seed + 1), ring(instance, seed + 2)
    cycles = ab_cycles.ab_room(N + M)
    for c in range(ab_cycles.find_cycles(a, b, cycles, seeded(seed, 0))):
        nodes = [merged(v) for v in cycles.nodes[cycles.begins[c] : cycles.begins[c + 1]]]
        for parity in range(2):
            assert len(set(nodes[parity::2])) == len(nodes) // 2


@settings(max_examples=30)
@given(seed=seeds)
def test_a_child_is_one_ring_and_costs_what_it_says(seed):
    instance = site(seed)
    costs, a = ring(instance, seed + 1)
    _, b = ring(instance, seed + 2)
    work = mating(costs)
    pressure = ring_energy.Pressure(a.sums[-1] / M, 200.0)
    for c in range(ab_cycles.find_cycles(a, b, work.cycles, seeded(seed, 0))):
        if not edge_assembly._assemble(work, a, c):
            continue
        said = ring_children.child_energy(costs, a, work.child, pressure)
        made = edge_assembly._copied(a)
        ring_children.become(costs, made, work.child)
        assert sorted(made.order[:-1]) == list(range(N + M))
        assert made.order[0] == made.order[-1] == N
        cost = giant.tours_of(costs, made.order, M).cost
        assert said == pytest.approx(float((200.0 * np.exp((cost - pressure.mean) / 200.0)).sum()), rel=1e-9)
        assert np.all(made.order[made.starts[:-1]] >= N)


@settings(max_examples=20)
@given(seed=seeds)
def test_a_ring_crossed_is_never_worse_and_takes_all_that_is_better(seed):
    instance = site(seed)
    rings = [ring(instance, seed + i)[1] for i in range(2)]
    costs, rng = search_costs(instance), seeded(seed, 1)
    work, before = mating(costs), float(rings[0].sums[-1])
    better = edge_assembly.cross(work, rings[0], rings[1], 1e7, rng)
    after = float(rings[0].sums[-1])
    assert after < before if better else after == before
    assert sorted(rings[0].order[:-1]) == list(range(N + M))
    assert giant.tours_of(costs, rings[0].order, M).cost.sum() == pytest.approx(after)
    for _ in range(20):  # cycles are drawn: it ends where none that is drawn is better
        if not edge_assembly.cross(work, rings[0], rings[1], 1e7, rng):
            break
    else:
        pytest.fail("crossed with the same ring again and again it is better every time")


def test_no_child_takes_out_legs_that_are_gone():
    instance = site(3)
    costs, a = ring(instance, 4)
    _, b = ring(instance, 5)
    _, other = ring(instance, 6)
    work = mating(costs)
    found = ab_cycles.find_cycles(a, b, work.cycles, seeded(3, 0))
    for c in range(found):
        nodes = work.cycles.nodes[work.cycles.begins[c] : work.cycles.begins[c + 1]]
        there = all(v in neighbours(other, u) for u, v in zip(nodes[::2], nodes[1::2], strict=True))
        assert there or not edge_assembly._assemble(work, other, c)


def neighbours(one, v):
    """The nodes before and after one of a ring."""
    return one.order[one.position[v] + 1], one.order[one.position[v] - 1 if one.position[v] > 0 else -2]


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
    search = edge_assembly.EdgeAssembly(data, HOW, FULL.assembly._replace(size=12), seeded(1, 0))
    longest, seen = [search.longest], set()
    for i in range(200):
        assert search.advance(i / 200, 100) == (search.longest < longest[-1])
        seen.add((search._crossed is not None, search._chained is not None))
        longest.append(search.longest)
        assert float(search.best().cost.max()) == pytest.approx(search.longest, rel=1e-9)
    check_routes(instance, to_routes(search.best()))
    assert longest[-1] < 0.98 * longest[0]
    assert seen == {(False, False), (True, False), (True, True)}


def test_rings_are_kicked_a_window_at_a_time():
    """No step takes much longer than it is asked to: a limit may end while a ring is being made."""
    instance = site(5, 60, 3)
    data = problem_data(search_costs(instance), 60, FULL.neighbourhood)
    search = edge_assembly.EdgeAssembly(data, HOW, FULL.assembly._replace(kicks=2.0), seeded(1, 0))
    kicks, made = [search._kicks], [len(search._rings)]
    while len(search._rings) < 3:
        search.advance(0.0, 50)
        kicks.append(search._kicks)
        made.append(len(search._rings))
    assert kicks == [120, 70, 20, 0, 120, 70, 20, 0, 120]
    assert made == [1, 1, 1, 1, 2, 2, 2, 2, 3]
    search.advance(FULL.assembly.made, 50)  # no time for more kicks
    assert search._kicks == 0
    assert len(search._rings) == 3
