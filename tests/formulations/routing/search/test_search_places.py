"""Kernels without a matrix: legs, neighbourhoods and greedy routes are those of the matrix."""

import subprocess
import sys

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.greedy import Greedy
from formulations.routing.search.costs import leg, leg_into, n_nodes, part_of, search_costs
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.problem_data import NeighbourhoodParameters, problem_data
from instances import Instance, check_routes, makespan
from instances.metrics import metric_cost

N, M = 300, 5
XY = np.random.default_rng(3).uniform(-3_000.0, 3_000.0, (N + M, 2))
XY[N + 2] = XY[N]
CALM = {"metric": "wind", "airspeed": 20.0, "wind": None}
METRICS = [
    CALM,
    {"metric": "euclidean", "rounding": "nearest"},
    {"metric": "manhattan", "rounding": "up"},
    {"metric": "maximum", "rounding": "down"},
    {"metric": "att"},
    {"metric": "wind", "airspeed": 20.0, "wind": {"kind": "uniform", "velocity": [3.0, -2.0]}},
    {"metric": "wind", "airspeed": 20.0, "wind": {"kind": "shear", "rate": 5e-4, "centre": [10.0, 20.0]}},
    {"metric": "wind", "airspeed": 20.0, "wind": {"kind": "rotation", "rate": 1e-3, "centre": [-50.0, 70.0]}},
]


def both(metric):
    matrix = Instance("matrix", metric_cost(metric, XY), N, M, XY)
    return Instance.of_metric("places", metric, XY, N, M), matrix


@pytest.mark.parametrize("metric", METRICS, ids=str)
def test_legs_sites_and_neighbourhoods_are_those_of_the_matrix(metric):
    places, matrix = (search_costs(each) for each in both(metric))
    rng = np.random.default_rng(0)
    for u, w in rng.integers(0, N + M, (200, 2)).tolist():
        assert leg(places, 0, u, w) == pytest.approx(matrix.out[u, w], rel=1e-9, abs=1e-9)
        assert leg_into(places, 0, w, u) == pytest.approx(matrix.out[u, w], rel=1e-9, abs=1e-9)
    parameters = NeighbourhoodParameters(8, M)
    none = np.zeros((2, N + M))  # of a matrix they would be found, and change what is near
    here, there = (problem_data(costs, N, parameters, none) for costs in (places, matrix))
    assert here.site.tolist() == there.site.tolist() == [0, 1, 0, 3, 4]
    nearest = np.minimum(matrix.out, matrix.out.T)
    for mine, known in zip(here.near, there.near, strict=True):  # ties may go to others
        costs = [np.take_along_axis(nearest[:N], near.astype(np.int64), axis=1) for near in (mine, known)]
        assert costs[0] == pytest.approx(costs[1], rel=1e-9)
    assert not (here.near.tasks == np.arange(N)[:, None]).any()
    some = np.array([5, 9, N + 1])
    part = part_of(places, some, np.array([1]))
    assert n_nodes(part) == 3
    assert leg(part, 0, 0, 2) == leg(places, 0, 5, N + 1)


@pytest.mark.parametrize("variant", ["nearest", pytest.param("regret", marks=pytest.mark.slow)])
def test_greedy_routes_are_those_of_the_matrix(variant):
    places, matrix = both(CALM)
    found, known = (Greedy(variant).solve(each, limits=Limits(time=60.0)).routes for each in (places, matrix))
    assert found == known


@pytest.mark.slow
def test_memetic_searches_without_a_matrix():
    places, matrix = both(CALM)
    found = Memetic(depth=0.05).solve(places, limits=Limits(time=60.0, iterations=40_000))
    assert check_routes(matrix, found.routes) == []
    assert makespan(matrix, found.routes) == pytest.approx(found.objective, rel=1e-9)
    greedy = Greedy().solve(places, limits=Limits(time=60.0))
    assert found.objective < greedy.objective


SOLVES_20_000 = """
import resource
from formulations.limits import Limits
from formulations.moving_cost.families import generate
from formulations.routing.search.memetic import Memetic
instance = generate("uniform", 20_000, 50, 0)
Memetic().solve(instance, limits=Limits(time=60.0, iterations=40_000))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)
"""


@pytest.mark.slow
def test_twenty_thousand_tasks_take_less_than_a_gigabyte():
    ran = subprocess.run([sys.executable, "-c", SOLVES_20_000], capture_output=True, text=True, check=True)
    gigabytes = float(ran.stdout)
    assert gigabytes < 1.0  # a matrix would be 3.2
