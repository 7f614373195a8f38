"""Terrain: synthetic mountains and elevation models in files, bad ones named."""

import sys
from pathlib import Path

import numpy as np
import pytest

from instances import InputError
from instances.environment.raster import same_projection
from instances.environment.terrain import Terrain, mountains, read_terrain


def test_mountains_are_seeded_and_fill_the_relief() -> None:
    a, b, c = (mountains(cells=30, relief=900.0, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(a.height, b.height)
    assert (a.height != c.height).any()
    assert (a.height.min(), a.height.max()) == (0.0, 900.0)
    assert a.bounds == (0.0, 0.0, 20_000.0, 20_000.0)


def test_elevation_is_bilinear_and_survives_refining() -> None:
    t = Terrain((100.0, 200.0), (10.0, 20.0), np.array([[0.0, 10.0], [20.0, 30.0]]))
    np.testing.assert_allclose(t([[105.0, 210.0], [110.0, 200.0], [0.0, 0.0]]), [15.0, 10.0, 0.0])
    ground = mountains(cells=10)
    np.testing.assert_allclose(ground.resampled(20).height[::2, ::2], ground.height)


def geotiff(path: Path, values: np.ndarray, crs: str | None, nodata: float | None = None) -> Path:
    rasterio = pytest.importorskip("rasterio")
    transform = rasterio.transform.from_origin(500_000.0, 4_000_000.0, 30.0, 30.0)
    with rasterio.open(
        path, "w", driver="GTiff", height=values.shape[0], width=values.shape[1], count=1, dtype="float32",
        crs=crs, transform=transform, nodata=nodata,
    ) as file:  # fmt: skip
        file.write(values.astype("float32"), 1)
    return path


def test_geotiff_is_read_north_up_at_pixel_centres(tmp_path: Path) -> None:
    values = np.arange(12.0).reshape(3, 4)
    t = read_terrain(geotiff(tmp_path / "dem.tif", values, "EPSG:32652"))
    np.testing.assert_array_equal(t.height, values[::-1])
    assert (t.origin, t.spacing) == ((500_015.0, 4_000_000.0 - 75.0), (30.0, 30.0))
    assert "UTM" in t.crs


def test_holes_in_the_elevation_model_are_located(tmp_path: Path) -> None:
    values = np.ones((3, 4))
    values[0, 1] = -9999
    with pytest.raises(InputError, match=r"1 of 12 values are missing .* first at \(500045, 3.99998e\+06\) m"):
        read_terrain(geotiff(tmp_path / "dem.tif", values, "EPSG:32652", nodata=-9999))
    values[0, 1] = np.nan
    with pytest.raises(InputError, match="1 of 12 values are missing"):
        read_terrain(geotiff(tmp_path / "nan.tif", values, "EPSG:32652"))


def test_degrees_and_feet_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"in degrees \(WGS 84\); project it"):
        read_terrain(geotiff(tmp_path / "deg.tif", np.ones((3, 3)), "EPSG:4326"))
    with pytest.raises(InputError, match="not in metres"):
        read_terrain(geotiff(tmp_path / "ft.tif", np.ones((3, 3)), "EPSG:2225"))


def netcdf(path: Path, name: str = "elevation", units: str = "m", axis: str = "m") -> Path:
    xarray = pytest.importorskip("xarray")
    coords = {"x": ("x", [0.0, 10.0, 20.0], {"units": axis}), "y": ("y", [10.0, 0.0], {"units": axis})}
    field = (("y", "x"), np.arange(6.0).reshape(2, 3), {"units": units})
    xarray.Dataset({name: field}, coords=coords).to_netcdf(path, engine="netcdf4")
    return path


def test_netcdf_elevations(tmp_path: Path) -> None:
    t = read_terrain(netcdf(tmp_path / "dem.nc"))
    np.testing.assert_array_equal(t.height, [[3.0, 4.0, 5.0], [0.0, 1.0, 2.0]])
    assert (t.origin, t.spacing) == ((0.0, 0.0), (10.0, 10.0))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"name": "depth"}, "no variable with standard_name surface_altitude or named elevation .it has: 'depth'"),
        ({"units": "feet"}, "must be in metres, its units are 'feet'"),
        ({"axis": "degrees_east"}, "in degrees"),
    ],
)
def test_bad_netcdf_elevations_are_named(tmp_path: Path, change: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_terrain(netcdf(tmp_path / "dem.nc", **change))


def test_ascii_grid_elevations_and_unreadable_files(tmp_path: Path) -> None:
    (tmp_path / "dem.asc").write_text("ncols 2\nnrows 2\nxllcenter 5\nyllcenter 7\ncellsize 10\n1 2\n3 4\n")
    t = read_terrain(tmp_path / "dem.asc")
    np.testing.assert_array_equal(t.height, [[3.0, 4.0], [1.0, 2.0]])
    assert t.origin == (5.0, 7.0)
    (tmp_path / "text.tif").write_text("no picture")
    for name, words in (("text.tif", "cannot be read as GeoTIFF"), ("dem.png", "must be GeoTIFF")):
        with pytest.raises(InputError, match=words):
            read_terrain(tmp_path / name)


def test_different_projections_are_refused() -> None:
    same_projection("UTM 52N", "UTM  52N", "scenario")
    same_projection("", "UTM 52N", "scenario")
    with pytest.raises(InputError, match="scenario: different map projections, 'UTM 52N' and 'UTM 33N'"):
        same_projection("UTM 52N", "UTM 33N", "scenario")


def test_without_the_extra_a_sentence_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "dem.tif").touch()
    (tmp_path / "dem.nc").touch()
    for module in ("rasterio", "xarray"):
        monkeypatch.setitem(sys.modules, module, None)
    for name in ("dem.tif", "dem.nc"):
        with pytest.raises(InputError, match=r"needs the extra 'geo'"):
            read_terrain(tmp_path / name)
