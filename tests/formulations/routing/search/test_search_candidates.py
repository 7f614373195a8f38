"""Candidate legs: against a naive twin, connected, and with all equal costs."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from formulations.routing.search.candidate_legs import candidate_legs


def clusters(seed, n, m):
    """Costs between three clusters of n tasks in all, and m depots at one place."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 1.0, (n + m, 2)) + 50.0 * rng.integers(0, 3, (n + m, 1))
    points[n:] = points[n]
    return np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))


def naive(cost, v, near, layers):
    """The candidates of node v, as a set."""
    others = sorted((w for w in range(len(cost)) if w != v), key=lambda w: cost[v, w])
    found = set()
    for _ in range(layers):
        layer = []
        for w in others:
            if w not in found and all(cost[u, w] >= cost[v, w] for u in layer):
                layer.append(w)
        found |= set(layer)
    return found | set(others[:near])


@given(seed=st.integers(0, 10**6), near=st.integers(1, 4), layers=st.integers(0, 2), m=st.integers(1, 3))
@settings(max_examples=30, deadline=None)
def test_candidates_are_the_nearest_and_those_of_the_layers(seed, near, layers, m):
    n = 25
    cost = clusters(seed, n, m)
    legs = candidate_legs(cost, n, near, layers, n)
    for v in range(n + m):
        found = legs.nodes[v][legs.nodes[v] >= 0].tolist()
        expected = naive(cost[: n + 1, : n + 1], min(v, n), near, layers)
        assert set(found) == expected | (set(range(n, n + m)) if n in expected else set())
        assert len(found) == len(set(found))
        assert list(legs.cost[v, : len(found)]) == sorted(cost[v, found])
        assert np.all(np.isinf(legs.cost[v, len(found) :]))


def test_no_cluster_is_cut_off():
    n = 60
    cost = clusters(3, n, 2)
    for layers, parts in ((0, 3), (1, 1)):
        nodes = candidate_legs(cost, n, 3, layers, 12).nodes
        v, at = np.nonzero(nodes >= 0)
        graph = csr_array((np.ones(v.size), (v, nodes[v, at])), shape=(n + 2, n + 2))
        assert connected_components(graph, directed=False)[0] >= parts
        if layers:
            assert connected_components(graph, directed=False)[0] == 1


def test_equal_costs_fill_the_lists_and_no_more():
    cost = 1.0 - np.eye(12)
    assert candidate_legs(cost, 10, 5, 2, 6).nodes.shape == (12, 7)
    assert np.count_nonzero(candidate_legs(cost, 10, 5, 2, 6).nodes >= 0, axis=1).min() == 6
