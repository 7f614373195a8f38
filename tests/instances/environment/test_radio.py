"""Radio maps: closed forms of free space and of one knife edge, laws of shadowing, files and their faults."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instances import InputError
from instances.environment.propagation import (
    EFFECTIVE_EARTH,
    bullington,
    free_space_loss,
    knife_edge,
    radio_map,
    shadowing,
)
from instances.environment.radio import RadioMap, RadioSource
from instances.environment.radio_files import read_field, write_field
from instances.environment.terrain import Terrain

SQUARE = (0.0, 0.0, 20e3, 20e3)
CENTRE = RadioSource((10e3, 10e3))


def test_free_space_is_the_papers_formula() -> None:
    wavelength = CENTRE.wavelength
    assert wavelength == pytest.approx(2.0534, abs=1e-4)
    loss = -10 * math.log10(wavelength**2 / (4 * math.pi * 5000.0) ** 2)
    assert free_space_loss(np.array([5000.0]), wavelength)[0] == pytest.approx(loss, abs=1e-10)
    flat = radio_map(CENTRE, SQUARE, model="free-space", shadowing_sd=0.0)
    distance = math.hypot(7000.0, 3000.0 - 10.0)
    assert flat([[17e3, 10e3]])[0] == pytest.approx(
        40 + 6 + 2 - free_space_loss(np.array([distance]), wavelength)[0], abs=1e-9
    )


@pytest.mark.parametrize(("v", "loss"), [(-0.78, 0.0), (-5.0, 0.0), (0.0, 6.03), (1.0, 13.93), (2.4, 20.54)])
def test_knife_edge_of_p526(v: float, loss: float) -> None:
    # ν = 0 is the grazing edge (6 dB); ν = 2.4 approaches 12.95 + 20 log ν
    assert knife_edge(v) == pytest.approx(loss, abs=0.02)


def test_bullington_of_one_ridge_is_its_knife_edge() -> None:
    step, height, wavelength = 100.0, 400.0, 2.0
    heights = np.zeros(101)
    heights[50] = height
    d = 10_000.0
    edge = height + 25e6 / (2 * EFFECTIVE_EARTH) - 20.0
    v = edge * math.sqrt(2 * d / (wavelength * 25e6))
    j = 6.9 + 20 * math.log10(math.sqrt((v - 0.1) ** 2 + 1) + v - 0.1)
    expected = j + (1 - math.exp(-j / 6)) * (10 + 0.02 * 10)
    assert bullington(heights, step, 20.0, 20.0, wavelength) == pytest.approx(expected, abs=1e-9)


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 10_000), st.floats(5.0, 500.0), st.floats(5.0, 3000.0), st.floats(0.1, 5.0))
def test_diffraction_is_never_negative_reciprocal_and_grows_with_the_terrain(
    seed: int, transmitter: float, receiver: float, wavelength: float
) -> None:
    heights = np.random.default_rng(seed).uniform(0, 800, 60)
    heights[[0, -1]] = 0.0
    loss = bullington(heights, 150.0, transmitter, receiver, wavelength)
    assert loss >= 0.0
    assert bullington(heights[::-1].copy(), 150.0, receiver, transmitter, wavelength) == pytest.approx(loss, abs=1e-9)
    assert (
        bullington(heights + np.r_[0, np.full(58, 100.0), 0], 150.0, transmitter, receiver, wavelength) >= loss - 1e-9
    )


def test_flat_ground_in_plain_sight_adds_nothing() -> None:
    near = (8e3, 8e3, 12e3, 12e3)
    maps = [radio_map(CENTRE, near, model=m, shadowing_sd=0.0) for m in ("free-space", "diffraction")]
    np.testing.assert_allclose(maps[0].values, maps[1].values, atol=1e-9)


def test_shadowing_has_its_standard_deviation_and_correlation() -> None:
    fields = np.array([shadowing((64, 64), (100.0, 100.0), 4.0, 500.0, seed) for seed in range(200)])
    assert fields.mean() == pytest.approx(0.0, abs=0.1)
    assert fields.std() == pytest.approx(4.0, rel=0.03)
    at_500 = (fields[:, :, :-5] * fields[:, :, 5:]).mean() / 16.0
    assert at_500 == pytest.approx(math.exp(-1.0), abs=0.03)


def test_same_seed_same_map() -> None:
    one, again, other = (radio_map(CENTRE, SQUARE, seed=s, cells=40).values for s in (3, 3, 4))
    np.testing.assert_array_equal(one, again)
    assert np.abs(one - other).max() > 1.0


@pytest.mark.parametrize("name", ["field.csv", "field.nc"])
def test_files_round_trip(tmp_path: Path, name: str) -> None:
    if name.endswith(".nc"):
        pytest.importorskip("xarray")
    field = radio_map(CENTRE, (0.0, 0.0, 4000.0, 2000.0), cells=20)
    write_field(field, tmp_path / name)
    again = read_field(tmp_path / name)
    np.testing.assert_allclose(again.x, field.x)
    np.testing.assert_allclose(again.y, field.y)
    np.testing.assert_array_equal(again.values, field.values)
    assert again.unit == "dBm"


def test_a_geotiff_is_read_north_up(tmp_path: Path) -> None:
    rasterio = pytest.importorskip("rasterio")
    values = np.arange(12.0).reshape(3, 4)
    transform = rasterio.transform.from_origin(1000.0, 3000.0, 100.0, 100.0)
    profile = {"driver": "GTiff", "width": 4, "height": 3, "count": 1, "dtype": "float64", "transform": transform}
    with rasterio.open(tmp_path / "field.tif", "w", crs="EPSG:32633", **profile) as out:
        out.write(values, 1)
    field = read_field(tmp_path / "field.tif")
    assert field([[1050.0, 2950.0]])[0] == values[0, 0]
    assert field([[1350.0, 2750.0]])[0] == values[2, 3]


def bad(tmp_path: Path, text: str) -> str:
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        read_field(path)
    return str(error.value)


def test_bad_files_are_named_with_what_is_wrong(tmp_path: Path) -> None:
    assert "first line must be" in bad(tmp_path, "1,2,3\n")
    assert "line 2: every line must hold three numbers x, y and a value, got '0,0,abc'" in bad(
        tmp_path, "x,y,dBm\n0,0,abc\n"
    )
    assert "need 4 lines, got 3" in bad(tmp_path, "x,y,dBm\n0,0,1\n1,0,1\n0,1,1\n")
    assert "missing (NaN" in bad(tmp_path, "x,y,dBm\n0,0,1\n1,0,nan\n0,1,1\n1,1,1\n")
    assert "equally spaced" in bad(tmp_path, "x,y,dBm\n0,0,1\n1,0,1\n5,0,1\n0,1,1\n1,1,1\n5,1,1\n")
    with pytest.raises(InputError, match="must be CSV"):
        read_field(tmp_path / "field.xyz")


def test_bad_values_are_said() -> None:
    with pytest.raises(InputError, match="did you mean 'diffraction'"):
        radio_map(CENTRE, SQUARE, model="difraction")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="must be above the terrain"):
        radio_map(CENTRE, SQUARE, Terrain((0.0, 0.0), (20e3, 20e3), np.full((2, 2), 3500.0)))
    with pytest.raises(InputError, match="unknown key 'frequncy'; did you mean 'frequency'"):
        RadioSource.from_table({"position": [0, 0], "frequncy": 1e6})
    with pytest.raises(InputError, match="frequency must be positive"):
        RadioSource((0.0, 0.0), frequency=0.0)
    with pytest.raises(InputError, match="equally spaced"):
        RadioMap(np.array([0.0, 1.0, 1.0]), np.array([0.0, 1.0]), np.zeros((2, 3)))
