"""Instances without a matrix: their costs are those of the matrix they stand for, and no matrix is made unasked."""

import pickle

import numpy as np
import pytest

from formulations.moving_cost.families import generate
from formulations.routing.registry import make_solver
from formulations.routing.solver import refusal
from instances import InputError, Instance, check_routes, makespan
from instances.files import read_instance, write_instance
from instances.instance import MAX_NODES
from instances.metric_costs import MATRIX_NODES
from instances.metrics import metric_cost

N, M = 60, 3
XY = np.random.default_rng(7).uniform(-3_000.0, 3_000.0, (N + M, 2))
WIND = {"kind": "sum", "parts": [{"kind": "uniform", "velocity": [3.0, -2.0]}, {"kind": "shear", "rate": 5e-4}]}
METRICS = [
    {"metric": "euclidean", "speed": 7.3},
    {"metric": "euclidean", "rounding": "nearest"},
    {"metric": "manhattan", "rounding": "up"},
    {"metric": "maximum", "rounding": "down"},
    {"metric": "att"},
    {"metric": "wind", "airspeed": 20.0, "wind": None},
    {"metric": "wind", "airspeed": 20.0, "wind": WIND},
    {"metric": "wind", "airspeed": 20.0, "wind": {"kind": "rotation", "rate": 1e-3}},
]


def lazily(metric, xy=XY, n=N, **more):
    return Instance.of_metric("places", metric, xy, n, len(xy) - n, **more)


@pytest.mark.parametrize("metric", METRICS, ids=str)
def test_costs_are_those_of_the_matrix(metric):
    cost, matrix = lazily(metric).cost, metric_cost(metric, XY)
    i, j = np.random.default_rng(0).integers(0, N + M, (2, 200))
    assert cost[i, j] == pytest.approx(matrix[i, j], rel=1e-12)
    assert cost[4] == pytest.approx(matrix[4], rel=1e-12)
    assert cost[:, 5] == pytest.approx(matrix[:, 5], rel=1e-12)
    assert cost[N:, :N] == pytest.approx(matrix[N:, :N], rel=1e-12)
    assert cost[3, 9] == pytest.approx(matrix[3, 9], rel=1e-12)
    assert cost.symmetric == np.allclose(matrix, matrix.T)


def test_routes_are_checked_and_priced_alike():
    metric = METRICS[6]
    instance, other = lazily(metric), Instance("matrix", metric_cost(metric, XY), N, M, XY)
    routes = np.array_split(np.random.default_rng(1).permutation(N), M)
    assert makespan(instance, routes) == pytest.approx(makespan(other, routes), rel=1e-12)
    assert check_routes(instance, routes) == []
    assert check_routes(instance, [routes[0], routes[0], []])
    assert instance.asymmetry == pytest.approx(other.asymmetry, rel=1e-9)
    again = pickle.loads(pickle.dumps(instance))
    assert again.digest == instance.digest
    assert again.digest != lazily(METRICS[5]).digest
    assert "too many for a matrix" in instance.summary()


def test_who_wants_a_matrix_is_refused_in_a_sentence():
    instance = lazily(METRICS[0])
    for wants in (np.asarray, lambda cost: np.minimum(cost, 3.0), lambda cost: cost[None, None]):
        with pytest.raises(InputError, match="this asks for one"):
            wants(instance.cost)
    assert "memetic" in (refusal(make_solver("exact"), instance) or "")
    assert refusal(make_solver("memetic"), instance) is None
    limited = lazily(METRICS[0], endurance=np.full(M, 9e3))
    assert "limited endurance" in (refusal(make_solver("memetic"), limited) or "")


@pytest.mark.parametrize(
    ("metric", "xy", "sentence"),
    [
        ({"metric": "geo"}, XY, "'geo' gives no costs that can be computed leg by leg"),
        ({"metric": "euclidian"}, XY, "euclidian"),
        (METRICS[0], XY[:, :1], r"coordinates must have shape \(63, 2\)"),
        ({"metric": "wind", "airspeed": 20.0, "wind": {"kind": "uniform", "velocity": [30, 0]}}, XY, "it reaches 30"),
    ],
)
def test_one_sentence_names_what_is_wrong(metric, xy, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        lazily(metric, xy)
    assert "\n" not in str(caught.value)


def test_large_instances_are_generated_written_and_read_without_a_matrix(tmp_path):
    instance = generate("uniform", MATRIX_NODES, 2, 0)
    assert instance.by_metric is not None
    write_instance(instance, tmp_path / "a.json")
    assert (tmp_path / "a.json").stat().st_size < 50 * MATRIX_NODES
    assert read_instance(tmp_path / "a.json").digest == instance.digest
    with pytest.raises(InputError, match="would hold a matrix"):
        write_instance(instance, tmp_path / "a.tsp")
    whole = Instance.of_metric("w", METRICS[1], instance.coordinates, MATRIX_NODES, 2)
    write_instance(whole, tmp_path / "w.tsp")
    assert read_instance(tmp_path / "w.tsp").digest == whole.digest


def test_sizes_that_cannot_be_held_are_refused_before_anything_is_made():
    with pytest.raises(InputError, match=f"more than the {MAX_NODES} nodes an instance can have"):
        generate("uniform", MAX_NODES, 1, 0)
    with pytest.raises(InputError, match="whose costs no metric names"):
        generate("square-wind", MATRIX_NODES, 1, 0)
