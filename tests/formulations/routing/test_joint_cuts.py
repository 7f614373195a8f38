"""Cuts of all UAVs: they hold for all routes within the cap, and are found where θ violates them."""

from itertools import combinations, pairwise, permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.routing.arcs.blossoms import blossoms
from formulations.routing.arcs.crowds import Crowds, one_tree
from formulations.routing.arcs.joint import Joint
from formulations.routing.separation import cut_tree


def flown(routes: list[list[int]], n: int) -> np.ndarray:
    """Return x (n + 1, n + 1) of routes, the depot last."""
    x = np.zeros((n + 1, n + 1))
    for route in routes:
        for i, j in zip([n, *route], [*route, n], strict=True):
            x[i, j] += i != j
    return x


def some_flown(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return what up to three UAVs fly."""
    order, ends = rng.permutation(n).tolist(), sorted(rng.integers(0, n + 1, 2).tolist())
    return flown([order[: ends[0]], order[ends[0] : ends[1]], order[ends[1] :]], n)


def value(cut: Joint, x: np.ndarray) -> float:
    """Return by how much x keeps to a cut."""
    return float((cut.entries * x).sum()) - cut.least


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(4, 9), mixed=st.integers(2, 4))
def test_blossoms_hold_for_all_routes_and_are_violated_where_found(seed: int, n: int, mixed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.einsum("r,rij->ij", rng.dirichlet(np.ones(mixed)), [some_flown(rng, n) for _ in range(mixed)])
    assert blossoms(x, 1e-6) == []  # between routes: whatever holds for these holds for it
    loose = rng.dirichlet(np.ones(3), size=n)
    x = np.zeros((n + 1, n + 1))
    for j in range(n):  # every task is entered once, by whatever comes
        x[rng.choice([i for i in range(n + 1) if i != j], 3, replace=False), j] = loose[j]
    cuts = blossoms(x, 1e-6)
    for cut in cuts:
        assert value(cut, x) < -1e-7
        assert all(value(cut, some_flown(rng, n)) >= 0 for _ in range(200))


def test_the_three_ends_of_a_prism_are_parted() -> None:
    """Two triangles flown by halves, and three edges between them: every task of degree two, and all sets entered."""
    x = np.zeros((8, 8))
    for a, b in [*combinations((0, 1, 2), 2), *combinations((3, 4, 5), 2)]:
        x[a, b] = x[b, a] = 0.25
    for a in range(3):
        x[a, a + 3] = x[a + 3, a] = 0.5
    x[6, 7] = x[7, 6] = 1.0
    cut = blossoms(x, 0.02)[0]
    assert set(cut.handle) in ({0, 1, 2}, {3, 4, 5})
    assert {tuple(sorted(tooth)) for tooth in cut.teeth} == {(0, 3), (1, 4), (2, 5)}
    assert value(cut, x) == pytest.approx(-1.0)


def shortest(leg: np.ndarray, tasks: tuple[int, ...]) -> float:
    """Return the shortest tour that holds some tasks, whatever else it passes."""
    n = len(leg) - 1
    others = [i for i in range(n) if i not in tasks]
    sets = [tasks + more for size in range(len(others) + 1) for more in combinations(others, size)]
    tours = (order for held in sets for order in permutations(held))
    return min(leg[n, order[0]] + sum(leg[i, j] for i, j in pairwise(order)) + leg[order[-1], n]
               for order in tours)  # fmt: skip


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), share=st.floats(0.3, 0.95))
def test_crowds_are_too_long_for_any_uav_whatever_the_legs(seed: int, share: float) -> None:
    rng, n, m = np.random.default_rng(seed), 5, 2
    cost = rng.uniform(0.05, 1.0, (m, n + 1, n + 1))
    cost[:, np.arange(n + 1), np.arange(n + 1)] = np.inf
    everything = min(shortest(leg, tuple(range(n))) for leg in cost)
    cap = share * everything
    cost = cost / cap
    limits = np.array([np.inf, 0.9])
    order = rng.permutation(n).tolist()
    x = (flown([order], n) + flown([order[::-1]], n)) / 2
    for cut in Crowds(np.where(cost > 1.0, np.inf, cost), limits).cuts(x, 1.0, 0.02):
        assert value(cut, x) < -0.02
        assert min(shortest(leg, cut.tasks) for leg in cost) > 1.0


def test_a_tour_of_all_is_parted_where_it_is_too_long() -> None:
    corners = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.5, 0.5]])
    leg = np.linalg.norm(corners[:, None] - corners[None], axis=-1) / 3.0
    np.fill_diagonal(leg, np.inf)
    crowds = Crowds(leg[None], np.array([np.inf]))
    cuts = crowds.cuts(flown([[0, 1, 2, 3]], 4), 1.0, 0.02)
    assert (0, 1, 2, 3) in {cut.tasks for cut in cuts}
    assert crowds.cuts(flown([[0, 1, 2, 3]], 4), 3.0, 0.02) == []
    assert crowds.cuts(flown([[0, 1], [2, 3]], 4), 1.0, 0.02) == []


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(3, 7))
def test_a_one_tree_is_no_longer_than_a_tour(seed: int, size: int) -> None:
    leg = np.random.default_rng(seed).uniform(0.0, 1.0, (size, size))
    leg = np.minimum(leg, leg.T)
    tour = min(leg[(0, *order), (*order, 0)].sum() for order in permutations(range(1, size)))
    bound, potential = one_tree(leg, 100.0, 80)
    assert bound <= tour + 1e-12
    assert one_tree(leg - potential[:, None] - potential[None], 100.0, 1)[0] + 2 * potential.sum() == pytest.approx(
        bound
    )


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(2, 7))
def test_a_cut_tree_tells_any_two_nodes_apart_by_a_smallest_cut(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    weight = rng.integers(0, 5, (size, size)) * (rng.random((size, size)) < 0.6)
    weight = np.triu(weight, 1) + np.triu(weight, 1).T.astype(float)
    sides = cut_tree(weight.astype(float))
    cut_of = [weight[np.ix_(side, ~side)].sum() for side in sides]
    everything = [np.array(side) for side in product([False, True], repeat=size)]
    for a, b in combinations(range(size), 2):
        smallest = min(weight[np.ix_(side, ~side)].sum() for side in everything if side[a] != side[b])
        assert smallest == pytest.approx(min(c for c, side in zip(cut_of, sides, strict=True) if side[a] != side[b]))
