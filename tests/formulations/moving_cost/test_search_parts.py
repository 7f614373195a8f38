"""The parts of the search against slow twins: free space, gauge and vorticity, Newton step, FMT* radius."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from formulations.moving_cost.costing import query_of
from formulations.moving_cost.field import SearchField, search_field
from formulations.moving_cost.free_space import free_space, segments_free
from formulations.moving_cost.graph import hexagonal_lattice, near_pairs, standard_radius
from formulations.moving_cost.newton import newton_step
from formulations.moving_cost.polish import relax, subdivide
from instances import InputError
from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.wind import Rotation, Uniform, WindField
from instances.environment.wind_grid import Grid
from instances.environment.wind_table import Sum
from instances.environment.wind_vortices import Vortices
from instances.moving_cost import CostKind, CostMeasure
from instances.scenario import Scenario

SIDE = 10_000.0
SQUARE = Region.rectangle(SIDE, SIDE)
WHIRL = Vortices(((4000.0, 6000.0),), (5e4,), (1500.0,))


@settings(deadline=None, max_examples=25, derandomize=True)
@given(st.integers(0, 10_000))
def test_segments_are_free_where_shapely_says_so_corners_included(seed: int) -> None:
    rng = np.random.default_rng(seed)
    zones = []
    while len(zones) < 3:
        angle = np.sort(rng.uniform(0, 2 * np.pi, 5))
        ring = rng.uniform(1500, 8500, 2) + 1400 * np.column_stack([np.cos(angle), np.sin(angle)])
        if shapely.Polygon(ring).area > 1e5 and all(shapely.Polygon(ring).distance(z) > 10 for z in zones):
            zones.append(shapely.Polygon(ring))
    region = SQUARE.minus(zones)
    space = free_space(region)
    points = np.concatenate([region.sample(25, rng), space.corners])
    i, j = np.triu_indices(len(points), 1)
    found = segments_free(points[i], points[j], space)
    expected = shapely.covers(
        region.polygon.buffer(1e-5), shapely.linestrings(np.stack([points[i], points[j]], axis=1))
    )
    np.testing.assert_array_equal(found, expected)


def split(wind: WindField, speed: float, region: Region = SQUARE) -> SearchField:
    return search_field(CostMeasure(CostKind.ENERGY, wind, speed), region)


def residual_speed(wind: WindField, field: SearchField, points: Floats) -> float:
    """Largest speed [m/s] that the gradient of the potential leaves of the wind at `points`."""
    step = 1e-2 * np.eye(2)
    slopes = [(field.potential(points + d) - field.potential(points - d)) / 2e-2 for d in step]
    return float(np.linalg.norm(wind(points) - np.column_stack(slopes), axis=1).max())


def test_the_gauge_takes_a_potential_wind_away_and_leaves_the_vorticity() -> None:
    field = split(Uniform((7.0, -3.0)), 20.0)
    points = SQUARE.sample(50, np.random.default_rng(0))
    shift = field.potential(points) - points @ np.array([7.0, -3.0])
    assert np.ptp(shift) < 1e-6
    assert residual_speed(Uniform((7.0, -3.0)), field, points) < 1e-9
    assert np.abs(field.bending.vorticity.omega).max() < 1e-12
    both = Sum((Uniform((7.0, -3.0)), WHIRL))
    mixed = split(both, 20.0)
    assert residual_speed(both, mixed, points) < mixed.max_speed
    np.testing.assert_allclose(split(Rotation(3e-4), 20.0).bending.vorticity.omega, 6e-4, rtol=1e-9)


def test_wind_as_strong_as_the_ground_speed_is_refused_with_its_place() -> None:
    with pytest.raises(
        InputError, match=r"wind: at \(\d+, \d+\) m it blows with .* not less than the ground speed of 2 m/s"
    ):
        split(WHIRL, 2.0)
    assert split(Uniform((30.0, 0.0)), 20.0).max_speed == pytest.approx(30.0)


def test_the_newton_step_uses_the_derivative_of_the_cost() -> None:
    v0 = 20.0
    field = split(WHIRL, v0)
    rng = np.random.default_rng(1)
    p = np.column_stack([np.linspace(1000, 8000, 12), 5500 + rng.normal(0, 60, 12)])
    held = np.zeros(12, dtype=bool)
    held[[0, -1]] = True
    g, normal, _ = newton_step(p, held, field.bending)

    def cost(q: np.ndarray) -> float:
        return float(np.hypot(*np.diff(q, axis=0).T).sum() - WHIRL.line_integral(q[:-1], q[1:]).sum() / v0)

    for k in range(1, 11):
        move = np.zeros_like(p)
        move[k] = 0.5 * normal[k]
        assert cost(p + move) - cost(p - move) == pytest.approx(g[k], abs=2e-4)


def test_relaxing_wraps_a_path_around_a_corner_and_lets_another_go() -> None:
    region = SQUARE.minus([shapely.box(4000, 4000, 6000, 6000)])
    space, field = free_space(region), split(Uniform((0.0, 0.0)), 20.0, region)
    top = int(np.argmax(space.corners @ np.array([-1.0, 1.0])))  # the corner (4000, 6000)
    far = np.array([[1000.0, 5000.0], [2000.0, 9000.0], [8000.0, 9000.0], [9000.0, 7500.0]])
    p, corner = relax(*subdivide(far, np.full(4, -1), 500.0), field.bending, space, 1e-6)
    length = math.dist((1000, 5000), (4000, 6000)) + math.dist((4000, 6000), (9000, 7500))
    assert np.hypot(*np.diff(p, axis=0).T).sum() == pytest.approx(length, rel=1e-12)
    assert (corner >= 0).sum() == 1
    assert corner.max() == top
    loose = np.array([[1000.0, 7000.0], space.corners[top], [9000.0, 8500.0]])
    p, corner = relax(*subdivide(loose, np.array([-1, top, -1]), 500.0), field.bending, space, 1e-6)
    assert np.hypot(*np.diff(p, axis=0).T).sum() == pytest.approx(math.dist((1000, 7000), (9000, 8500)), rel=1e-12)
    assert corner.max() == -1


def test_lattice_and_radius() -> None:
    points, spacing = hexagonal_lattice(SQUARE, 1000)
    assert len(points) == pytest.approx(1000, rel=0.05)
    assert (np.bincount(near_pairs(points, 1.01 * spacing).ravel()) <= 6).all()
    assert standard_radius(SIDE**2, 1000) == pytest.approx(2 * SIDE * math.sqrt(math.log(1000) / 1000 / (2 * math.pi)))


def test_terrain_and_wind_in_different_projections_are_refused(tmp_path) -> None:
    header = "ncols 2\nnrows 2\nxllcenter 0\nyllcenter 0\ncellsize 10000\n1 2\n3 4\n"
    (tmp_path / "dem.asc").write_text(header)
    (tmp_path / "dem.prj").write_text('PROJCS["UTM 52N"]')
    wind = Grid((0.0, 0.0), (SIDE, SIDE), np.ones((2, 2)), np.ones((2, 2)), crs='PROJCS["UTM 33N"]')
    scenario = Scenario(
        "s", SQUARE, np.array([[1.0, 1.0]]), 20.0, wind, np.array([[9.0, 9.0]]), terrain=tmp_path / "dem.asc"
    )
    with pytest.raises(InputError, match="scenario s: terrain and wind: different map projections"):
        query_of(scenario)
