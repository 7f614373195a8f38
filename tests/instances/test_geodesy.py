"""The tangent plane against closed forms of the ellipsoid, and there and back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instances.errors import InputError
from instances.geodesy import TangentPlane, from_degrees, to_degrees

A = 6_378_137.0  # of WGS 84
FLATTENING = 1 / 298.257223563
E2 = FLATTENING * (2 - FLATTENING)


def test_the_origin_is_the_origin() -> None:
    np.testing.assert_allclose(TangentPlane(36.0, 128.0).geographic([[0.0, 0.0]]), [[36.0, 128.0]], atol=1e-12)


@pytest.mark.parametrize("latitude", [0.0, 36.0, -70.0])
def test_small_steps_are_those_of_the_radii_of_curvature(latitude: float) -> None:
    s = math.sin(math.radians(latitude))
    N = A / math.sqrt(1 - E2 * s * s)  # prime vertical
    M = A * (1 - E2) / (1 - E2 * s * s) ** 1.5  # meridian
    step = 10.0
    moved = TangentPlane(latitude, 10.0).geographic([[step, 0.0], [0.0, step]])
    assert math.radians(moved[0, 1] - 10.0) * N * math.cos(math.radians(latitude)) == pytest.approx(step, rel=1e-6)
    assert math.radians(moved[1, 0] - latitude) * M == pytest.approx(step, rel=1e-6)


def test_east_along_the_equator_is_an_arc_tangent() -> None:
    assert TangentPlane(0.0, 0.0).geographic([[20e3, 0.0]])[0] == pytest.approx(
        [0.0, math.degrees(math.atan(20e3 / A))]
    )


def on_ellipsoid(latitude: float, longitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Earth-centred place [m] of a point of the ellipsoid, angles in radians, and its vertical."""
    up = np.array(
        [math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude), math.sin(latitude)]
    )
    return A / math.sqrt(1 - E2 * up[2] ** 2) * up * [1, 1, 1 - E2], up


@settings(deadline=None)
@given(st.floats(-80, 80), st.floats(-180, 180), st.floats(-30e3, 30e3), st.floats(-30e3, 30e3))
def test_there_and_back(latitude: float, longitude: float, x: float, y: float) -> None:
    foot, vertical = on_ellipsoid(*np.radians(TangentPlane(latitude, longitude).geographic([[x, y]])[0]))
    f, g = math.radians(latitude), math.radians(longitude)
    origin, up = on_ellipsoid(f, g)
    east = np.array([-math.sin(g), math.cos(g), 0.0])
    way = foot - origin
    way = way - vertical * (up @ way) / (up @ vertical)  # up the point's own vertical, into the plane
    np.testing.assert_allclose([east @ way, np.cross(up, east) @ way], [x, y], atol=1e-4)


def test_degrees_are_those_of_bowrings_formula_to_a_millimetre() -> None:
    plane = TangentPlane(47.0, 8.0)
    f, g = math.radians(plane.latitude), math.radians(plane.longitude)
    centre, _ = on_ellipsoid(f, g)
    east = np.array([-math.sin(g), math.cos(g), 0.0])
    north = np.array([-math.sin(f) * math.cos(g), -math.sin(f) * math.sin(g), math.cos(f)])
    points = np.random.default_rng(0).uniform(-20e3, 20e3, (50, 2))
    X, Y, Z = (centre + points[:, :1] * east + points[:, 1:] * north).T
    across, b = np.hypot(X, Y), A * (1 - FLATTENING)
    reduced = np.arctan2(Z * A, across * b)
    latitude = np.arctan2(Z + E2 / (1 - E2) * b * np.sin(reduced) ** 3, across - E2 * A * np.cos(reduced) ** 3)
    expected = np.degrees(np.column_stack([latitude, np.arctan2(Y, X)]))
    np.testing.assert_allclose(plane.geographic(points), expected, rtol=0, atol=1e-3 / 111e3)


@pytest.mark.parametrize("origin", [(128.0, 36.0), (0.0, 200.0), (float("nan"), 0.0)])
def test_origins_that_are_none(origin: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="latitude, longitude"):
        TangentPlane(*origin)


@pytest.mark.parametrize("origin", [(36.0, 128.0), (-33.0, -70.0), (89.0, -180.0), (0.0, 0.0)])
def test_the_plane_and_back(origin):
    plane = TangentPlane(*origin)
    points = np.random.default_rng(0).uniform(-5e4, 5e4, (100, 2))
    np.testing.assert_allclose(plane.local(plane.geographic(points)), points, atol=1e-6)


def test_map_projections_and_back():
    # the central meridian of zone 32 at the equator: false easting 500 km
    np.testing.assert_allclose(from_degrees([[0.0, 9.0]], "EPSG:32632"), [[500e3, 0.0]], atol=1e-6)
    np.testing.assert_allclose(to_degrees([[500e3, 0.0]], "EPSG:32632"), [[0.0, 9.0]], atol=1e-9)
    assert not np.isfinite(to_degrees([[1e9, 1e9]], "EPSG:32632")).any()


@pytest.mark.parametrize(
    ("crs", "words"),
    [
        ("IAU_2015:49900", r"crs: nothing leads from 'Mars .*' to 'WGS 84'"),
        ("EPSG:5773", "'EGM96 height' is no map"),
        ("EPSG:4978", "'WGS 84' is no map"),
    ],
)
def test_reference_systems_that_are_no_maps_of_the_earth(crs, words):
    with pytest.raises(InputError, match=words):
        to_degrees([[0.0, 0.0]], crs)
