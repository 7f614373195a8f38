"""Paths: their file, and an independent check that finds what is wrong."""

import gzip
import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from instances import InputError, Instance
from instances.environment.region import Region
from instances.environment.wind import Rotation
from instances.moving_cost import moving_costs
from instances.paths import Paths, check_paths, paths_file, read_paths, write_paths

WIND, V0 = Rotation(4e-4, (500.0, 500.0)), 20.0
NODES = np.array([[100.0, 100.0], [900.0, 120.0], [480.0, 930.0]])
REGION = Region.rectangle(1000.0, 1000.0).minus([shapely.box(400, 300, 600, 500)])


def bent(i: int, j: int, by: float = 30.0) -> np.ndarray:
    """A polyline from node i to node j with a bend in the middle."""
    middle = 0.5 * (NODES[i] + NODES[j]) + by
    return np.array([NODES[i], middle, NODES[j]])


def paths_and_cost() -> tuple[Paths, np.ndarray]:
    paths = Paths.of(3, [np.empty((0, 2)) if i == j else bent(i, j) for i in range(3) for j in range(3)])
    return paths, moving_costs(paths.points, paths.offsets, WIND, V0).reshape(3, 3)


def check(paths: Paths, cost: np.ndarray, region: Region = REGION) -> list[str]:
    return check_paths(paths, cost, NODES, region, WIND, V0)


def test_true_claims_are_confirmed() -> None:
    paths, cost = paths_and_cost()
    assert check(paths, cost) == []
    assert cost[0, 1] != cost[1, 0]
    p = np.array([1.0, 2.0, 5.0])
    assert check_paths(paths, cost + p[None] - p[:, None], NODES, REGION, WIND, V0, p) == []
    np.testing.assert_array_equal(paths.along([0, 1, 2])[[0, 2, 4]], NODES)


def test_a_wrong_cost_is_refuted() -> None:
    paths, cost = paths_and_cost()
    cost[1, 2] *= 1.0005
    (fault,) = check(paths, cost)
    assert fault.startswith("The path from 1 to 2 costs")


def test_a_collision_a_missed_end_and_a_missing_path_are_found() -> None:
    paths, cost = paths_and_cost()
    wall = Region.rectangle(1000.0, 1000.0).minus([shapely.box(400, 100, 600, 500)])
    assert "in a no-fly zone" in check(paths, cost, wall)[0]
    moved = Paths(3, paths.points + np.where(np.arange(len(paths.points)) == 0, 0.5, 0.0)[:, None], paths.offsets)
    assert "does not start at node 0, but 0.707 m away" in check(moved, cost)[0]
    gone = Paths.of(
        3, [paths.between(i, j) if (i, j) != (2, 0) else np.empty((0, 2)) for i in range(3) for j in range(3)]
    )
    assert check(gone, cost) == ["There is no path from node 2 to node 0 (1 are missing)."]


def test_files_round_trip_to_the_millimetre(tmp_path: Path) -> None:
    paths, cost = paths_and_cost()
    instance = Instance("three", cost, 2, 1, NODES)
    file = paths_file(tmp_path / "three.json.gz")
    assert file.name == "three.paths.json.gz"
    write_paths(paths, instance, file, "s.toml")
    again = read_paths(file, instance)
    np.testing.assert_allclose(again.points, paths.points, atol=5.1e-4)
    assert check(again, cost) == []


def test_bad_files_are_named(tmp_path: Path) -> None:
    paths, cost = paths_and_cost()
    instance = Instance("three", cost, 2, 1, NODES)
    file = tmp_path / "x.paths.json.gz"
    write_paths(paths, instance, file)
    with pytest.raises(InputError, match="belongs to an instance of digest"):
        read_paths(file, Instance("other", cost * 2, 2, 1, NODES))
    table = json.loads(gzip.decompress(file.read_bytes()))
    for change in ({"offsets": [0, 1]}, {"points": [[0.0]]}, {"n_nodes": "three"}, {"points": [[None, 1.0]]}):
        file.write_bytes(gzip.compress(json.dumps({**table, **change}).encode()))
        with pytest.raises(InputError, match=r"x.paths.json.gz: (points|offsets|n_nodes|paths)"):
            read_paths(file, instance)
    file.write_bytes(b"no gzip")
    with pytest.raises(InputError, match="cannot be decompressed"):
        read_paths(file, instance)


def test_nodes_at_one_place_share_paths() -> None:
    paths, _ = paths_and_cost()
    of = np.array([0, 1, 2, 1])
    more = paths.repeated(of, NODES[of])
    np.testing.assert_array_equal(more.between(3, 2), paths.between(1, 2))
    np.testing.assert_array_equal(more.between(1, 3), NODES[[1, 1]])
