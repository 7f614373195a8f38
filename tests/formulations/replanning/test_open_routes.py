"""Routes from where UAVs are: the best of all by enumeration, empty ones included; ways round zones."""

from itertools import pairwise, permutations, product

import numpy as np
import pytest
from shapely.geometry import box

from formulations.replanning.open_routes import empty_routes, open_routes
from formulations.replanning.ways import Ways
from instances.environment.region import Region
from instances.environment.wind import Uniform
from instances.moving_cost import CostKind, CostMeasure
from tests.formulations.replanning.worlds import CALM

SQUARE = Region.rectangle(8000.0, 8000.0)


def longest(legs, n, m, spent, limits, routes):
    """Return the least that any UAV has left."""
    left = []
    for k, route in enumerate(routes):
        stops = [n + k, *route, n + m + k]
        left.append(limits[k] - spent[k] - sum(legs.cost[i, j] for i, j in pairwise(stops)))
    return min(left)


@pytest.mark.parametrize("seed", range(3))
def test_no_assignment_and_order_leaves_more(seed):
    rng = np.random.default_rng(seed)
    n, m = 4, 2
    legs = Ways(SQUARE, CostMeasure(CostKind.ENERGY, Uniform((20.0, 5.0)), 100.0)).between(
        rng.uniform(0, 8000, (n + 2 * m, 2))
    )
    spent, limits = rng.uniform(0, 60, m), np.array([400.0, 330.0])
    found = open_routes(legs.cost, n, spent, limits)
    every = (
        tuple(tuple(t for t in order if who[t] == k) for k in range(m))
        for order in permutations(range(n))
        for who in product(range(m), repeat=n)
    )
    best = max(longest(legs, n, m, spent, limits, routes) for routes in every)
    assert found.left.min() == pytest.approx(longest(legs, n, m, spent, limits, found.routes))
    assert found.left.min() == pytest.approx(best)


def test_an_empty_route_costs_the_way_home():
    points = np.array([[1000.0, 1000.0], [4000.0, 1000.0], [1000.0, 2000.0], [4000.0, 4000.0]])
    legs = Ways(SQUARE, CostMeasure(CostKind.ENERGY, CALM, 100.0)).between(points)
    found = empty_routes(legs.cost, 0, np.array([5.0, 7.0]), np.array([50.0, 50.0]))
    assert found.left == pytest.approx([35.0, 13.0])


def test_ways_go_round_a_zone_by_its_corners_and_start_on_its_wrong_side():
    region = Region(SQUARE.polygon.difference(box(3000, 3000, 5000, 5000)))
    ways = Ways(region, CostMeasure(CostKind.ENERGY, CALM, 100.0))
    legs = ways.between(np.array([[2000.0, 4000.0], [6000.0, 4000.0], [3000.0, 7000.0], [3100.0, 4000.0]]))
    round_it = [[2000.0, 4000.0], [3000.0, 3000.0], [5000.0, 3000.0], [6000.0, 4000.0]]
    assert legs.cost[0, 1] == pytest.approx(np.hypot(1000, 1000) * 2 / 100 + 20)
    path = legs.path(0, 1)
    assert len(path) == 4
    assert np.allclose(abs(path[:, 1] - 4000), abs(np.array(round_it)[:, 1] - 4000))
    assert np.allclose(legs.path(0, 2), [[2000, 4000], [3000, 7000]])
    assert np.allclose(legs.path(3, 0), [[3100, 4000], [3000, 4000], [2000, 4000]])
