"""Moves of long segments, each against a naive twin that recomputes the tours, on random asymmetric costs.

Every other seed has UAVs that differ.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.search import concatenation, moves
from formulations.routing.search import tours as rings
from formulations.routing.search.costs import least, search_costs
from formulations.routing.search.energy import Objective, energy, excess, p_norm
from formulations.routing.search.problem_data import NeighbourhoodParameters, granular_neighbourhood
from formulations.routing.search.randomness import seeded
from instances import Instance, Travel, check_routes, tour_costs

N, M = 12, 3


class Table:
    """Random tours with tours a and b laid out, and the naive view of both."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        legs = rng.uniform(1.0, 100.0, (M, N + M, N + M)) * (1.0 - np.eye(N + M))
        fleet = Instance.of_travel("random fleet", Travel.of_uavs(list(legs)), N)
        self.instance = fleet if seed % 2 else Instance("random", legs[0], N, M)
        routes = [[] for _ in range(M)]
        for v in rng.permutation(N):
            routes[rng.integers(M)].append(int(v))
        self.routes = [tuple(r) for r in routes]
        self.costs = search_costs(self.instance)
        self.tours = rings.from_routes(self.costs, tuple(self.routes))
        self.workspace = moves.empty_workspace(self.costs, N)
        self.k_a, self.k_b = (int(k) for k in rng.permutation(M)[:2])
        concatenation.read_tour(self.costs, self.tours, self.k_a, self.k_b, self.workspace.a, self.workspace.position)
        concatenation.read_tour(self.costs, self.tours, self.k_b, self.k_a, self.workspace.b, self.workspace.position)
        self.rng = rng

    def pick(self, low, high):
        return int(self.rng.integers(low, high + 1))

    def check(self, route_a, route_b, cost_a, cost_b):
        wanted = list(self.routes)
        wanted[self.k_a], wanted[self.k_b] = tuple(route_a), tuple(route_b)
        costs = tour_costs(self.instance, wanted)
        assert costs[self.k_a] == pytest.approx(cost_a)
        assert costs[self.k_b] == pytest.approx(cost_b)
        assert list(rings.to_routes(self.tours)) == wanted
        tours = self.tours
        for k, route in enumerate(wanted):
            assert tours.size[k] == len(route)
            assert all(tours.tour[v] == k for v in route)
        for u in range(N + M):
            w, cost = tours.after[u], self.instance.uav_cost(tours.tour[u])
            assert tours.before[w] == u
            assert (tours.arc[u], tours.back[u]) == (cost[u, w], cost[w, u])


seeds = st.integers(0, 10**6)


@given(seeds)
@settings(deadline=None, max_examples=60)
def test_prefix_sums_are_the_costs_of_flying_there_and_back(seed):
    table = Table(seed)
    a, cost = table.workspace.a, table.instance.uav_cost(table.k_a)
    stops = [N + table.k_a, *table.routes[table.k_a], N + table.k_a]
    assert a.shape.tolist() == [table.k_a, len(stops) - 2]
    assert a.nodes[: len(stops)].tolist() == stops
    for i in range(len(stops)):
        assert a.forward[i] == pytest.approx(sum(cost[stops[q], stops[q + 1]] for q in range(i)))
        assert a.backward[i] == pytest.approx(sum(cost[stops[q + 1], stops[q]] for q in range(i)))
    assert all(table.workspace.position[v] == i for i, v in enumerate(stops[1:-1], 1))
    tasks, cost = stops[1:-1], table.instance.uav_cost(table.k_b)
    within = slice(1, len(tasks) + 1)
    there, back = (np.diff(of(a)[within]) for of in (concatenation.given_forward, concatenation.given_backward))
    assert there == pytest.approx(cost[tasks[:-1], tasks[1:]])
    assert back == pytest.approx(cost[tasks[1:], tasks[:-1]])


@given(seeds)
@settings(deadline=None, max_examples=60)
def test_two_opt(seed):
    table = Table(seed)
    route = table.routes[table.k_a]
    if not route:
        return
    i = table.pick(1, len(route))
    j = table.pick(i, len(route))
    cost_a = table.tours.cost[table.k_a] + concatenation.two_opt_change(table.costs, table.workspace.a, i, j)
    concatenation.two_opt(table.costs, table.tours, table.workspace.a, i, j)
    turned = (*route[: i - 1], *route[i - 1 : j][::-1], *route[j:])
    table.check(turned, table.routes[table.k_b], cost_a, table.tours.cost[table.k_b])


@pytest.mark.parametrize("turned", [False, True])
@given(seed=seeds)
@settings(deadline=None, max_examples=60)
def test_or_opt_to_another_tour(turned, seed):
    table = Table(seed)
    a, b = table.routes[table.k_a], table.routes[table.k_b]
    if not a:
        return
    i = table.pick(1, len(a))
    j, q = table.pick(i, len(a)), table.pick(0, len(b))
    out, into = concatenation.or_opt_changes(table.costs, table.workspace.a, i, j, table.workspace.b, q, turned)
    concatenation.or_opt(table.costs, table.tours, table.workspace.a, i, j, table.workspace.b, q, turned)
    piece = a[i - 1 : j][::-1] if turned else a[i - 1 : j]
    costs = table.tours.cost
    table.check((*a[: i - 1], *a[j:]), (*b[:q], *piece, *b[q:]), costs[table.k_a] + out, costs[table.k_b] + into)


@pytest.mark.parametrize("turned", [False, True])
@given(seed=seeds)
@settings(deadline=None, max_examples=60)
def test_or_opt_inside_a_tour(turned, seed):
    table = Table(seed)
    a = table.routes[table.k_a]
    if len(a) < 2:
        return
    i = table.pick(1, len(a))
    j = table.pick(i, len(a))
    places = [q for q in range(len(a) + 1) if not i - 1 <= q <= j]
    if not places:
        return
    q = places[table.pick(0, len(places) - 1)]
    out, into = concatenation.or_opt_changes(table.costs, table.workspace.a, i, j, table.workspace.a, q, turned)
    concatenation.or_opt(table.costs, table.tours, table.workspace.a, i, j, table.workspace.a, q, turned)
    piece = a[i - 1 : j][::-1] if turned else a[i - 1 : j]
    moved = (*a[:q], *piece, *a[q : i - 1], *a[j:]) if q < i else (*a[: i - 1], *a[j:q], *piece, *a[q:])
    costs = table.tours.cost
    table.check(moved, table.routes[table.k_b], costs[table.k_a] + out + into, costs[table.k_b])


@given(seeds)
@settings(deadline=None, max_examples=80)
def test_two_opt_star(seed):
    table = Table(seed)
    a, b = table.routes[table.k_a], table.routes[table.k_b]
    i, j = table.pick(0, len(a)), table.pick(1, len(b) + 1)
    cost_a, cost_b = concatenation.two_opt_star_costs(table.costs, table.workspace.a, i, table.workspace.b, j)
    concatenation.two_opt_star(table.costs, table.tours, table.workspace.a, i, table.workspace.b, j)
    table.check((*a[:i], *b[j - 1 :]), (*b[: j - 1], *a[i:]), cost_a, cost_b)


@given(seeds)
@settings(deadline=None, max_examples=80)
def test_reversed_two_opt_star(seed):
    table = Table(seed)
    a, b = table.routes[table.k_a], table.routes[table.k_b]
    i, j = table.pick(0, len(a)), table.pick(0, len(b))
    cost_a, cost_b = concatenation.reversed_two_opt_star_costs(table.costs, table.workspace.a, i, table.workspace.b, j)
    concatenation.reversed_two_opt_star(table.costs, table.tours, table.workspace.a, i, table.workspace.b, j)
    table.check((*a[:i], *b[:j][::-1]), (*a[i:][::-1], *b[j:]), cost_a, cost_b)


@pytest.mark.parametrize("by", ["norm", "excess"])
@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_a_move_keeps_the_books_and_the_threshold(seed, by):
    table = Table(seed)
    near = granular_neighbourhood(least(table.costs), N, NeighbourhoodParameters(8, M))
    rng, tours = seeded(seed), table.tours
    objective = Objective(p_norm(4) if by == "norm" else excess(0.8 * tours.cost.max()), 0.1)
    how = moves.MoveParameters()
    now = energy(tours.cost, objective)
    for _ in range(20):
        then = moves.move(table.costs, near.tasks, tours, table.workspace, rng, now, 1e-8, objective, how)
        routes = rings.to_routes(tours)
        assert check_routes(table.instance, routes) == []
        assert tours.cost == pytest.approx(tour_costs(table.instance, routes))
        assert then == pytest.approx(energy(tours.cost, objective))
        assert then <= now + 1e-6
        now = then
