"""Costs of old corridor files: against shapely's sight and shortest paths of a lattice, which knows no corners."""

import numpy as np
import pytest
import shapely
from scipy.sparse.csgraph import dijkstra

from instances.environment.region import Region
from instances.environment.wind import Rotation, Shear, Uniform
from instances.environment.wind_table import Sum
from instances.families.corridor import winding
from instances.formats.native import instance_of
from instances.old_corridor_metric import old_corridor_costs, turning_corners
from instances.wind_metric import cost_matrix

V0 = 20.0
WINDS = [
    None,
    Uniform((5.0, -3.0)),
    Shear(8e-4, (0.0, 10_000.0)),
    Rotation(5e-4, (10_000.0, 10_000.0)),
    Rotation(-5e-4, (9_000.0, 11_000.0)),
    Sum((Uniform((3.0, 1.0)), Rotation(3e-4, (10_000.0, 10_000.0)))),
]
winds = pytest.mark.parametrize("wind", WINDS, ids=lambda w: "calm" if w is None else f"{type(w).__name__}")

HOLED = Region.rectangle(20_000, 20_000).minus(
    [
        shapely.box(0, 0, 6_000, 5_000),
        shapely.box(8_000, 8_000, 12_000, 13_000),
    ]
)


def test_corners_a_string_can_bend_around():
    assert {tuple(c) for c in turning_corners(HOLED)} == {
        (6_000, 5_000),
        (8_000, 8_000),
        (12_000, 8_000),
        (12_000, 13_000),
        (8_000, 13_000),
    }


def test_legs_along_a_wall_and_from_corner_to_corner_are_seen():
    p = 1000.0 * np.array([(8, 5), (8, 8), (8, 13), (8, 18), (15, 13)])
    cost = old_corridor_costs(p, HOLED, 1.0, None)
    assert cost[0, 3] == pytest.approx(13_000)
    assert cost[1, 2] == pytest.approx(5_000)
    assert cost[2, 4] == pytest.approx(7_000)


@winds
def test_corner_paths_against_shortest_paths_of_a_fine_lattice(wind):
    """A fine lattice with straight links is another way to the same shortest paths, from above."""
    p = HOLED.sample(8, np.random.default_rng(3))
    cost = old_corridor_costs(p, HOLED, V0, wind)
    free = cost_matrix(p, V0, wind)
    assert (cost >= free * (1 - 1e-12)).all()  # walls never help
    nodes = np.concatenate([p, HOLED.cell_centres(14, 14), turning_corners(HOLED)])
    roomy = HOLED.polygon.buffer(1e-6)
    ends = np.stack(np.broadcast_arrays(nodes[:, None], nodes[None, :]), axis=2)
    inside = shapely.covers(roomy, shapely.linestrings(ends))
    legs = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=-1) / V0
    if wind is not None:
        flat = ends.reshape(-1, 2, 2)
        legs -= wind.line_integral(flat[:, 0], flat[:, 1]).reshape(legs.shape) / V0**2
    seen = inside[:8, :8]
    assert (cost[seen] <= legs[:8, :8][seen] * (1 + 1e-12) + 1e-9).all()
    other = dijkstra(np.where(inside, legs, 0.0), indices=range(8))[:, :8]
    if wind is None or isinstance(wind, Uniform):
        assert cost == pytest.approx(other, rel=1e-9, abs=1e-6)  # closed form 2: exact
    else:
        # straight legs, where the optimum bends between corners too: a few per cent
        assert (cost <= other * 1.06 + 1e-6).all()


def test_an_old_file_has_the_digest_it_was_stored_with():
    """The digest is of the code that wrote such files."""
    ring = [[0, 0], [4, 0], [4, 6], [6, 6], [6, 0], [10, 0], [10, 10], [0, 10], [0, 0]]
    wind = {"kind": "rotation", "rate": 0.05, "centre": [5, 5]}
    document = {
        "schema": 1,
        "name": "old",
        "n_tasks": 2,
        "n_depots": 1,
        "cost": {"metric": "wind", "airspeed": 2.0, "wind": wind, "region": [ring]},
        "coordinates": [[1.0, 3.0], [9.0, 3.0], [2.0, 9.0]],
    }
    assert instance_of(document).digest == "b216cd752530"


def test_one_stretch_of_corridor_by_hand():
    """One wall of thickness 2 at x in [4, 6], opening 3 at the top of a 10 m square: a taut string over two corners."""
    region = winding({"size": 10.0, "walls": 1, "opening": 3.0, "thickness": 2.0})
    points = np.array([[1.0, 3.0], [9.0, 3.0], [2.0, 9.0]])
    cost = old_corridor_costs(points, region, 2.0, None)
    assert cost[0, 1] == pytest.approx((5 + 2 + 5) / 2)
    assert cost[0, 2] == pytest.approx(np.sqrt(1 + 36) / 2)
    # closed form 2: uniform wind adds a potential difference, whatever the way
    windy = old_corridor_costs(points, region, 2.0, Uniform((0.5, -0.3)))
    shift = -(points[None] - points[:, None]) @ np.array([0.5, -0.3]) / 4
    assert windy == pytest.approx(cost + shift)


def block_world(seed):
    """A 10 m square with rectangular holes and notches on whole metres: walls in line, points on walls and corners."""
    rng = np.random.default_rng(seed)
    region = Region.rectangle(10, 10)
    for _ in range(rng.integers(1, 5)):
        (x, y), (width, height) = rng.integers(0, 9, 2), rng.integers(1, 4, 2)
        rest = region.polygon.difference(shapely.box(x, y, x + width, y + height))
        if isinstance(rest, shapely.Polygon):
            region = Region(rest)
    grid = np.array([(x, y) for x in range(11) for y in range(11)], dtype=float)
    inside = grid[region.contains(grid)]
    some = inside[rng.permutation(len(inside))[:20]]
    return region, np.concatenate([some, some[:2]])


@pytest.mark.parametrize("seed", range(25))
def test_points_on_walls_on_corners_and_on_each_other(seed):
    region, p = block_world(seed)
    nodes = np.concatenate([p, turning_corners(region)])
    ends = np.stack(np.broadcast_arrays(nodes[:, None], nodes[None, :]), axis=2)
    length = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=-1)
    seen = shapely.covers(region.polygon.buffer(1e-6), shapely.linestrings(ends)) | (length == 0)
    shortest = dijkstra(np.where(seen, np.maximum(length, 1e-7), 0.0))[: len(p), : len(p)]  # 0 would mean no link
    assert old_corridor_costs(p, region, 1.0, None) == pytest.approx(shortest, abs=1e-5)
