"""The chained search across tours: moves against naive twins, and the result against the optimum."""

import itertools
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.search import bridges, chain_moves, ring_energy
from formulations.routing.search import chained_search as chained
from formulations.routing.search import tour_blocks as blocks
from formulations.routing.search.costs import search_costs
from formulations.routing.search.giant_tour import tours_of
from formulations.routing.search.handover import HandoverParameters
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.nearest_in_turn import nearest_in_turn
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.problem_data import problem_data
from formulations.routing.search.randomness import seeded
from formulations.routing.search.tours import from_routes, to_routes
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, check_routes, makespan

N, M = 17, 3
HOW = chain_moves.ChainParameters()
FULL = SearchParameters()
PRESSURE = ring_energy.Pressure(100.0, 40.0)
seeds = st.integers(0, 10**6)


class Chained(Memetic):
    """memetic that takes every instance with one depot for one of long tours."""

    parameters = replace(FULL, handover=HandoverParameters(fewest=1, for_each=0))


def one_site(seed, n=N, m=M):
    """Random points, the m UAVs at one of them, and random routes."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 100.0, (n + m, 2))
    points[n:] = points[n]
    cost = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    cuts = np.sort(rng.integers(0, n + 1, m - 1))
    routes = tuple(tuple(part.tolist()) for part in np.split(rng.permutation(n), cuts))
    return Instance("one-site", cost, n, m), routes


def blocks_of(seed):
    instance, routes = one_site(seed)
    costs = search_costs(instance)
    return costs, blocks.tour_blocks(costs, from_routes(costs, routes))


def ring_of(ring):
    """All nodes in turn, the first again at the end."""
    order = np.empty(N + M + 1, np.int32)
    blocks.write_ring(ring, order)
    return order


def tours_on(order):
    """The tours of a ring, each in the direction that begins with the smaller end, in any order."""
    parts = np.split(order[:-1], np.flatnonzero(order[:-1] >= N)[1:])
    return sorted(min(part[1:].tolist(), part[:0:-1].tolist()) for part in parts)


def energy(costs, order, pressure=PRESSURE):
    """The energy of all tours, walked along; above 30 s it rises as its tangent there does."""
    over = (tours_of(costs, order, M).cost - pressure.mean) / pressure.scale
    steep = np.maximum(over - 30.0, 0.0)
    return float((pressure.scale * np.exp(over - steep) * (1.0 + steep)).sum())


def legs_of(order):
    """How often each two nodes are neighbours on a ring; depots are one node, for they are at one place."""
    merged = np.minimum(order, N)
    return Counter(tuple(sorted(leg)) for leg in itertools.pairwise(merged.tolist()))


def priced(ring, pressure=PRESSURE):
    """The energies of its tours."""
    return np.array([ring_energy.tour_energy(ring.sums[end], pressure) for end in ring.ends])


def assert_booked(costs, ring):
    """Places, prefix sums and ends are those of the order, which visits every node once."""
    order = ring_of(ring)
    assert sorted(order[:-1]) == list(range(N + M))
    for k in range(M):
        first, end = k << ring.bits, ring.ends[k]
        nodes = ring.order[first : end + 1]
        assert nodes[0] == N + k
        assert nodes[-1] == N + (k + 1) % M
        assert all(v < N for v in nodes[1:-1])
        assert list(ring.position[nodes[:-1]]) == list(range(first, end))
        assert ring.sums[first : end + 1] == pytest.approx(np.cumsum([0.0, *costs.out[nodes[:-1], nodes[1:]]]))


def test_a_ring_is_its_tours():
    instance, routes = one_site(5)
    costs = search_costs(instance)
    ring = blocks.tour_blocks(costs, from_routes(costs, routes))
    assert_booked(costs, ring)
    order = ring_of(ring)
    assert to_routes(tours_of(costs, order, M)) == routes
    assert blocks.longest_of(ring) == pytest.approx(makespan(instance, routes))
    at = [blocks.position_of(ring, place) for place in range(N + M)]
    assert list(ring.order[at]) == list(order[:-1])
    for right in (0, 1):
        legs = [blocks.leg_at(ring, i, right) for i in at]
        assert list(ring.order[np.add(legs, right)]) == list(order[:-1])
        assert sorted(legs) == at


@given(seed=seeds, kind=st.integers(2, 6), two=st.booleans(), scale=st.sampled_from([400.0, 40.0, 8.0, 1.0]))
@example(seed=10, kind=4, two=False, scale=40.0)  # a depot comes to stand where the move begins
@example(seed=30, kind=2, two=True, scale=40.0)
@settings(max_examples=200, deadline=None)
def test_a_move_costs_what_it_says_and_is_taken_back(seed, kind, two, scale):
    costs, ring = blocks_of(seed)
    p, q, r = (int(x) for x in np.sort(np.random.default_rng(seed).choice(N + M, 3, replace=False)))
    q, kind = (r, blocks.TURNED_B) if two or kind == blocks.TURNED_B else (q, kind)
    order, kept = ring_of(ring), blocks.kept_of(ring)
    a, b, c, d = np.split(order, [p + 1, q + 1, r + 1])
    b, c = b[::-1] if kind & blocks.TURNED_B else b, c[::-1] if kind & blocks.TURNED_C else c
    expected = np.concatenate([a, c, b, d] if kind & blocks.SWAPPED else [a, b, c, d])
    joints = [p, r, r] if kind == blocks.TURNED_B else [p, p + (r - q if kind & blocks.SWAPPED else q - p), r]
    legs = tuple(costs.out[expected[joints], expected[np.add(joints, 1)]].tolist())
    p, q, r = (blocks.position_of(ring, place) for place in (p, q, r))
    pressure = ring_energy.Pressure(100.0, scale)
    if p >> ring.bits != r >> ring.bits:
        gain = ring_energy.gain_across(ring, priced(ring, pressure), p, q, r, kind, legs, 0.0, pressure)
        before, after = energy(costs, order, pressure), energy(costs, expected, pressure)
        assert gain == pytest.approx(max(before - after, 0.0), rel=1e-6, abs=1e-8 * before)
    blocks.rejoin(costs, ring, p, q, r, kind)
    assert tours_on(ring_of(ring)) == tours_on(expected)
    assert_booked(costs, ring)
    moved = ring_of(ring)
    blocks.note_change(ring, kept, p, q, r)
    blocks.restore(ring, kept)
    assert list(ring_of(ring)) == list(order)
    assert_booked(costs, ring)
    blocks.rejoin(costs, ring, p, q, r, kind)
    blocks.keep(ring, kept)
    other = blocks.tour_blocks(costs, tours_of(costs, order, M))
    kept.since[:] = np.arange(M) << ring.bits
    blocks.restore(other, kept)
    assert list(ring_of(other)) == list(moved)
    assert_booked(costs, other)


@given(seed=seeds, walk=st.integers(0, 12))
@settings(max_examples=100, deadline=None)
def test_a_kick_exchanges_a_few_legs(seed, walk):
    instance, routes = one_site(seed)
    data = problem_data(search_costs(instance), N, FULL.neighbourhood)
    search = chained.ChainedSearch(data, from_routes(data.costs, routes), HOW, seeded(seed))
    chain, rng = search._chain, seeded(seed, 1)
    chained.price_all(chain, PRESSURE)
    for _ in range(10):
        before = legs_of(ring_of(chain.blocks))
        chained._kick(chain, HOW._replace(walk=walk), PRESSURE, rng)
        assert_booked(data.costs, chain.blocks)
        after = legs_of(ring_of(chain.blocks))
        assert (before - after).total() == (after - before).total() <= 6  # two moves; four on one tour
        assert chain.energies == pytest.approx(priced(chain.blocks))


@pytest.mark.parametrize("walk", [0, 8])
def test_a_kick_finds_no_four_legs_of_three_nodes(walk):
    instance, routes = one_site(0, 1, 2)
    data = problem_data(search_costs(instance), 1, FULL.neighbourhood)
    search = chained.ChainedSearch(data, from_routes(data.costs, routes), HOW._replace(walk=walk), seeded(0))
    for i in range(20):
        search.advance(i / 20, 5)
    assert to_routes(search.best()) in {((0,), ()), ((), (0,))}


@given(seed=seeds)
@settings(max_examples=40, deadline=None)
def test_the_best_move_of_a_node_is_worth_what_it_says(seed):
    instance, routes = one_site(seed)
    data = problem_data(search_costs(instance), N, FULL.neighbourhood)
    search = chained.ChainedSearch(data, from_routes(data.costs, routes), HOW, seeded(seed))
    chain, same = search._chain, 0
    ring = chain.blocks
    for v in range(N + M):
        before, total = energy(data.costs, ring_of(ring)), blocks.total_of(ring)
        chained.price_all(chain, PRESSURE)
        assert chain.energies.sum() == pytest.approx(before)
        worth = chain_moves.best_move(chain, v, 1e-9, HOW, PRESSURE)
        if worth <= 1e-9:
            continue
        p, q, r, kind = (int(x) for x in chain.move)
        inside = p >> ring.bits == r >> ring.bits
        blocks.rejoin(data.costs, ring, p, q, r, kind)
        assert_booked(data.costs, ring)
        after = energy(data.costs, ring_of(ring))
        assert worth == pytest.approx(total - blocks.total_of(ring) if inside else before - after, rel=1e-6)
        assert after < before
        same += 1
    assert same > 0


def bridges_of(cost, order):
    """All bridges of a ring: what their legs save [s], whether on one tour, and the ring then.

    Only those of which the exchange that closes a ring saves something, and still does with one leg put in after it.
    """
    depots = np.cumsum(order >= N)
    for low, high in itertools.combinations(range(N + M), 2):
        part, rest = order[low + 1 : high + 1], np.append(np.delete(order[:-1], np.s_[low + 1 : high + 1]), order[0])
        taken_out = cost[order[[low, high]], order[[low + 1, high + 1]]]
        closing, joining = cost[order[high], order[low + 1]], cost[order[low], order[high + 1]]
        saved = taken_out.sum() - closing - joining
        whole = order[low] >= N and order[high + 1] >= N  # a leg from depot to depot begins no move
        if part.size < 3 or depots[low] < depots[high] or saved <= 1e-9 or (whole and taken_out.max() <= closing):
            continue
        for i, at in itertools.product(range(1, part.size), range(rest.size - 1)):
            for opened in (np.roll(part, -i), np.roll(part, -i)[::-1]):
                put_in = cost[rest[at], opened[0]], cost[opened[-1], rest[at + 1]]
                so_far = saved + cost[part[i - 1], part[i]]
                if at != low and so_far > min(put_in):  # at `low` it is a move of three legs
                    inside = np.sum(rest[: at + 1] >= N) == depots[low]
                    yield so_far + cost[rest[at], rest[at + 1]] - sum(put_in), inside, np.insert(rest, at + 1, opened)


@given(seed=seeds, scale=st.sampled_from([400.0, 40.0, 8.0]))
@settings(max_examples=5, deadline=None)
def test_the_best_bridge_is_worth_what_it_says_and_no_less_than_any(seed, scale):
    instance, routes = one_site(seed)
    data, pressure = problem_data(search_costs(instance), N, FULL.neighbourhood), ring_energy.Pressure(100.0, scale)
    how = HOW._replace(nearest=N, layers=0, most=N, bridged=N)
    search = chained.ChainedSearch(data, from_routes(data.costs, routes), how, seeded(seed))
    chain, ring = search._chain, search._chain.blocks
    for _ in range(3):
        chained.price_all(chain, pressure)
        order, total = ring_of(ring), blocks.total_of(ring)
        before = energy(data.costs, order, pressure)
        worths = [bridges.best_bridge(chain, v, 1e-9, how, pressure) for v in range(N + M)]
        naive = [
            saves if inside else before - energy(data.costs, then, pressure)
            for saves, inside, then in bridges_of(instance.cost, order)
        ]
        assert max(worths) == pytest.approx(max([1e-9, *naive]), rel=1e-6)
        if max(worths) <= 1e-9:
            return
        bridges.best_bridge(chain, int(np.argmax(worths)), 1e-9, how, pressure)
        inside = chain.bridge[0] >> ring.bits == chain.bridge[3] >> ring.bits
        chained._build(chain, pressure)
        assert_booked(data.costs, ring)
        assert chain.energies == pytest.approx(priced(ring, pressure))
        after = energy(data.costs, ring_of(ring), pressure)
        assert max(worths) == pytest.approx(total - blocks.total_of(ring) if inside else before - after, rel=1e-6)
        assert after < before


@given(seed=seeds)
@settings(max_examples=100, deadline=None)
def test_tours_that_change_places_gain_nothing_however_steep_the_energy(seed):
    ring = blocks_of(seed)[1]
    a, b = np.argsort(ring.sums[ring.ends])[[-1, 0]]
    less = ring.sums[ring.ends[a]] - ring.sums[ring.ends[b]]
    pressure = ring_energy.Pressure(0.0, ring.sums[ring.ends].max() / 25.0)
    assert ring_energy.gain_between(ring, priced(ring, pressure), a, b, less, 0.0, pressure) == 0.0


def test_a_search_never_gets_worse_and_keeps_all_tasks():
    instance, routes = one_site(11, 60, 3)
    data = problem_data(search_costs(instance), 60, FULL.neighbourhood)
    search = chained.ChainedSearch(data, from_routes(data.costs, routes), HOW, seeded(1))
    lengths = [makespan(instance, routes)]
    for done in np.linspace(0.0, 1.0, 20):
        better = search.advance(float(done), 50)
        found = to_routes(search.best())
        assert check_routes(instance, found) == []
        assert search.longest == pytest.approx(makespan(instance, found))
        assert better == (search.longest < lengths[-1])
        lengths.append(search.longest)
    assert lengths[-1] < 0.6 * lengths[0]


def test_the_first_tours_fly_on_to_the_nearest_task_and_are_about_as_long():
    instance, _ = one_site(7, 90, 3)
    tours = nearest_in_turn(problem_data(search_costs(instance), 90, FULL.neighbourhood), 17)
    routes = to_routes(tours)
    assert routes[0][0] == 17
    assert check_routes(instance, routes) == []
    assert makespan(instance, routes) == pytest.approx(tours.cost.max())
    for route in routes:
        later = [v for other in routes[routes.index(route) + 1 :] for v in other]
        for i, (u, v) in enumerate(itertools.pairwise(route)):
            assert instance.cost[u, v] == min(instance.cost[u, w] for w in [*route[i + 1 :], *later])
    inside = [sum(instance.cost[u, v] for u, v in itertools.pairwise(route)) for route in routes]
    assert max(inside) - min(inside) <= 2.0 * instance.cost.max()


def test_the_optimum_of_small_instances():
    for seed in range(3):
        instance, _ = one_site(seed, 10, 2)
        best = SubsetDp().solve(instance, limits=Limits(time=60.0))
        found = Chained().solve(instance, limits=Limits(time=60.0, iterations=3000), seed=1)
        assert found.objective == pytest.approx(best.objective)


def test_a_run_repeats_for_a_seed_and_starts_from_what_is_given():
    instance, _ = one_site(3, 40, 2)
    first, again = (Chained().solve(instance, limits=Limits(time=60.0, iterations=2000), seed=4) for _ in range(2))
    assert first.routes == again.routes
    start = first.routes
    after = Chained().solve(instance, limits=Limits(time=60.0, iterations=50), seed=5, start=start)
    assert after.objective <= first.objective
