"""Refined headings: never worse than the candidates, near what exact values and bounds say, and flown as claimed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.mapping.dubins import dubins_length
from formulations.moving_cost.turns.headings import headings
from formulations.moving_cost.turns.refinement import (
    best_chain,
    flown_headings,
    open_legs,
    refine,
    refined_routes,
)
from formulations.moving_cost.turns.travel import Turns, relaxed, turning_instance
from formulations.routing.subset_dp import SubsetDp
from instances import InputError, Instance, tour_costs
from instances.arrays import Floats


def flown(stops: Floats, at: Floats, turns: Turns) -> float:
    """Return what Dubins paths between the headings take [s]."""
    ends = zip(stops[:-1].tolist(), at[:-1], stops[1:].tolist(), at[1:], strict=True)
    return float(sum(dubins_length(*a, h, *b, g, turns.radius) for a, h, b, g in ends)) / turns.speed


def test_there_and_back_is_what_the_closed_form_says() -> None:
    r, stops = 1000.0, np.array([[0.0, 0.0], [4000.0, 0.0], [0.0, 0.0]])
    closed_form = 2 * (math.sqrt((4000 - r) ** 2 - r**2) + r * (math.pi - math.acos(r / (4000 - r))))
    legs = open_legs(stops, Turns(r, 1.0))
    best = refine([None, np.array([0.3]), None], legs)  # the optimum is π/2, far from what is given
    assert best.cost == pytest.approx(closed_form, rel=1e-9)
    assert abs(math.sin(best.headings[1])) == pytest.approx(1.0, abs=1e-4)
    kept = refine([np.array([0.2]), np.array([0.3]), np.array([0.2])], legs, closed=True)
    assert kept.headings[0] == pytest.approx(kept.headings[-1], abs=1e-12)
    assert kept.cost == pytest.approx(2 * (4000 - 2 * r) + 2 * math.pi * r, rel=1e-6)


@pytest.mark.parametrize("closed", [False, True])
def test_no_tour_takes_longer_than_in_its_instance_nor_less_than_its_bound(closed: bool) -> None:
    turns, gained = Turns(500.0, 20.0), 0
    for seed in range(4):
        points = np.random.default_rng(seed).uniform(0, 2500, (7, 2))
        states = headings(points, 5, uniform=8, free_depots=not closed)
        instance = turning_instance("few", points, 5, turns, states, closed=closed)
        routes = ((0, 1, 2), (3, 4)) if seed else ((4, 3, 2, 1, 0), ())
        chains, costs = refined_routes(instance, routes), tour_costs(instance, routes)
        looser = relaxed(instance, 32)
        assert looser is not None
        least = tour_costs(looser, routes)
        for k, chain in enumerate(chains):
            if chain is None:
                assert not routes[k]
                continue
            assert least[k] <= chain.cost <= costs[k]
            gained += chain.cost < 0.99 * costs[k]
            stops = points[[5 + k, *routes[k], 5 + k]]
            at = flown_headings(chain, stops, turns)
            assert flown(stops, at, turns) == pytest.approx(chain.cost, rel=1e-8)
            assert not closed or at[0] == pytest.approx(at[-1], abs=1e-12)
    assert gained


def test_few_headings_refined_are_as_good_as_many() -> None:
    points = np.random.default_rng(1000 * 4 + 200).uniform(0, 20000, (6, 2))
    few = turning_instance("few", points, 4, Turns(2000.0, 1.0), headings(points, 4, uniform=16, free_depots=False))
    found = SubsetDp().solve(few, limits=Limits(time=60.0))
    assert found.objective == pytest.approx(33684.663370, abs=1e-6)
    assert found.routes is not None
    longest = max(chain.cost for chain in refined_routes(few, found.routes) if chain is not None)
    assert 33429.833545 < longest < 33604.945240  # the bound and the optimum of 64 headings


def test_a_chain_is_the_cheapest_of_all() -> None:
    rng = np.random.default_rng(0)
    tables = [rng.uniform(0, 1, (3, 3)) for _ in range(3)]
    some = [np.arange(3.0)] * 4

    def cost(a: int, b: int, c: int, d: int) -> float:
        return float(tables[0][a, b] + tables[1][b, c] + tables[2][c, d])

    for closed in (False, True):
        best = best_chain(some, lambda s, here, there: tables[s], closed=closed)
        every = {index: cost(*index) for index in np.ndindex(3, 3, 3, 3) if not closed or index[0] == index[3]}
        assert best.cost == pytest.approx(min(every.values()), rel=1e-12)
        assert cost(*best.headings.astype(int).tolist()) == pytest.approx(best.cost, rel=1e-12)


def test_an_instance_that_does_not_say_how_uavs_turn_is_refused() -> None:
    with pytest.raises(InputError, match="plain does not say how its UAVs turn"):
        refined_routes(Instance("plain", np.ones((3, 3)) - np.eye(3), 2, 1), ((0, 1),))
