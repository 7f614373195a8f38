"""Rasters in degrees and other projections, brought to the plane of a site and judged only there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import box

from instances.environment.radio_files import read_field
from instances.environment.region import Region
from instances.environment.site import Site
from instances.environment.terrain import read_terrain
from instances.environment.wind_table import wind_from_toml
from instances.errors import InputError
from instances.geodesy import TangentPlane, from_degrees

PLANE = TangentPlane(47.0, 8.0)
SITE = Site(Region(box(-2000, -2000, 2000, 2000)), PLANE)
POINTS = np.random.default_rng(0).uniform(-2000, 2000, (200, 2))


def hills(latitude: np.ndarray, longitude: np.ndarray) -> np.ndarray:
    """A smooth ground [m] by place on Earth."""
    return 500 + 40 * np.sin(300 * np.radians(latitude - 47)) + 2e4 * np.radians(longitude - 8)


def geotiff(path: Path, values: np.ndarray, west: float, north: float, step: float, crs: str, unit: str = "m") -> Path:
    rasterio = pytest.importorskip("rasterio")
    rows, columns = values.shape
    about = {"driver": "GTiff", "width": columns, "height": rows, "count": 1, "dtype": "float64", "nodata": np.nan}
    with rasterio.open(path, "w", transform=rasterio.Affine(step, 0, west, 0, -step, north), crs=crs, **about) as out:
        out.write(values, 1)
        out.units = (unit,)
    return path


def in_degrees(path: Path, step: float = 1 / 1200, half: int = 60, east: float = 8.0) -> Path:
    """Write `hills` over 2·half cells of `step` degrees a side around the plane's origin."""
    at = (np.arange(2 * half) + 0.5 - half) * step
    longitude, latitude = np.meshgrid(8.0 + at, 47.0 - at)
    return geotiff(path, hills(latitude, longitude), east - half * step, 47.0 + half * step, step, "EPSG:4326")


def test_ground_in_degrees(tmp_path: Path) -> None:
    ground = read_terrain(in_degrees(tmp_path / "dem.tif"), SITE)
    latitude, longitude = PLANE.geographic(POINTS).T
    np.testing.assert_allclose(ground(POINTS), hills(latitude, longitude), atol=0.2)
    x0, y0, x1, y1 = ground.bounds  # a quarter of the region on each side, and no more
    assert (x0, y0) == pytest.approx((-3000, -3000), abs=1)
    assert (x1, y1) == pytest.approx((3000, 3000), abs=100)


def test_ground_in_utm(tmp_path: Path) -> None:
    corner = from_degrees([[47.0, 8.0]], "EPSG:32632")[0] + (-5000, 5000)
    at = (np.arange(200) + 0.5) * 50
    x, y = np.meshgrid(corner[0] + at, corner[1] - at)
    from instances.geodesy import to_degrees

    values = hills(*to_degrees(np.column_stack([x.ravel(), y.ravel()]), "EPSG:32632").T).reshape(200, 200)
    ground = read_terrain(geotiff(tmp_path / "dem.tif", values, *corner, 50.0, "EPSG:32632"), SITE)
    latitude, longitude = PLANE.geographic(POINTS).T
    np.testing.assert_allclose(ground(POINTS), hills(latitude, longitude), atol=0.2)
    assert "aeqd" in ground.crs


def test_gdal_warps_it_to_the_same_heights(tmp_path: Path) -> None:
    """It does not do the work, as grids of text and NetCDF are to be brought here without the extra geo, too."""
    warp = pytest.importorskip("rasterio.warp")
    rasterio = pytest.importorskip("rasterio")
    path = in_degrees(tmp_path / "dem.tif")
    ours = read_terrain(path, SITE)
    step, count = 50.0, 80
    north_west = rasterio.transform.from_origin(-2000.0, 2000.0, step, step)
    warped = np.empty((count, count))
    with rasterio.open(path) as data:
        warp.reproject(
            rasterio.band(data, 1), warped, dst_transform=north_west, dst_crs=PLANE.projection,
            resampling=warp.Resampling.bilinear,
        )  # fmt: skip
    at = (np.arange(count) + 0.5) * step - 2000.0
    x, y = np.meshgrid(at, -at)
    heights = ours(np.column_stack([x.ravel(), y.ravel()])).reshape(count, count)
    np.testing.assert_allclose(heights, warped, atol=1e-3)
    assert np.ptp(warped) > 20


def hole(path: Path, row: int, column: int) -> Path:
    """Put a hole of one cell into a written model of 120 × 120 cells."""
    rasterio = pytest.importorskip("rasterio")
    with rasterio.open(path, "r+") as data:
        values = data.read(1)
        values[row, column] = np.nan
        data.write(values, 1)
    return path


def test_holes_are_judged_in_the_region(tmp_path: Path) -> None:
    whole = read_terrain(in_degrees(tmp_path / "whole.tif"), SITE)
    corner = read_terrain(hole(in_degrees(tmp_path / "corner.tif"), 0, 0), SITE)  # beyond the margin
    np.testing.assert_array_equal(corner.height, whole.height)
    beside = read_terrain(hole(in_degrees(tmp_path / "beside.tif"), 27, 60), SITE)  # in the margin
    assert np.isfinite(beside.height).all()
    np.testing.assert_array_equal(beside(POINTS), whole(POINTS))
    sentence = r"inside\.tif: \d+ values in the region are missing .*, first at \([-\d.]+, [-\d.]+\) m, longitude 7\.99"
    with pytest.raises(InputError, match=sentence):
        read_terrain(hole(in_degrees(tmp_path / "inside.tif"), 60, 60), SITE)


def test_holes_of_local_metres_are_judged_in_the_region_too(tmp_path: Path) -> None:
    def ascii_grid(name: str, row: int) -> Path:
        rows = [["7"] * 9 for _ in range(9)]
        rows[row][0] = "-9999"
        text = "\n".join(" ".join(line) for line in rows)
        (tmp_path / name).write_text(f"ncols 9\nnrows 9\nxllcenter -4000\nyllcenter -4000\ncellsize 1000\n{text}\n")
        return tmp_path / name

    site = Site(SITE.region)
    assert (read_terrain(ascii_grid("out.asc", 0), site).height == 7).all()
    with pytest.raises(InputError, match=r"in\.asc: 1 values in the region are missing .*at \(-4000, 0\) m; fill"):
        read_terrain(ascii_grid("in.asc", 4), Site(Region(box(-3500, -2000, 2000, 2000))))


def test_ground_smaller_than_the_region_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"small\.tif: covers longitude 7\.98.*, latitude 46\.98.* not all of the reg"):
        read_terrain(in_degrees(tmp_path / "small.tif", half=20), SITE)
    with pytest.raises(InputError, match=r"away\.tif: covers longitude 8\.3"):
        read_terrain(in_degrees(tmp_path / "away.tif", east=8.4), SITE)
    with pytest.raises(InputError, match=r"elevations must be in metres, their unit is 'ft'"):
        read_terrain(geotiff(tmp_path / "feet.tif", np.ones((4, 4)), 7, 48, 1.0, "EPSG:4326", "ft"), SITE)


@pytest.mark.parametrize(
    ("shape", "crs", "words"),
    [
        ((1, 200), "EPSG:4326", r"a\.tif: must hold a grid of at least 2 × 2 nodes, it holds 200 × 1"),
        ((200, 200), "+proj=ortho +lat_0=-47 +lon_0=188", r"a\.tif: covers longitude -171"),
    ],
)
def test_rasters_that_lead_nowhere(tmp_path: Path, shape: tuple[int, int], crs: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_terrain(geotiff(tmp_path / "a.tif", np.ones(shape), 7.9, 47.1, 0.001, crs), SITE)


def test_longitudes_from_0_to_360(tmp_path: Path) -> None:
    west = Site(SITE.region, TangentPlane(47.0, -8.0))
    at = (np.arange(120) + 0.5 - 60) / 1200
    longitude, latitude = np.meshgrid(-8.0 + at, 47.0 - at)
    path = geotiff(tmp_path / "a.tif", hills(latitude, longitude), 352 - 0.05, 47.05, 1 / 1200, "EPSG:4326")
    latitude, longitude = west.plane.geographic(POINTS).T
    np.testing.assert_allclose(read_terrain(path, west)(POINTS), hills(latitude, longitude), atol=0.2)


FIELDS = [("a.tif", None, "ppm"), ("a.tif", "ppb", "ppb"), ("c.csv", None, "K")]


@pytest.mark.parametrize(("name", "unit", "said"), FIELDS)
def test_fields_in_degrees_and_their_units(tmp_path: Path, name: str, unit: str | None, said: str) -> None:
    at = (np.arange(120) + 0.5 - 60) / 1200
    longitude, latitude = np.meshgrid(8.0 + at, 47.0 + at)
    values = hills(latitude, longitude)
    if name.endswith(".csv"):
        lines = np.column_stack([longitude.ravel(), latitude.ravel(), values.ravel()]).tolist()
        (tmp_path / name).write_text("lon,lat,K\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in lines))
    else:
        geotiff(tmp_path / name, values[::-1], 8 - 0.05, 47.05, 1 / 1200, "EPSG:4326", "ppm")
    field = read_field(tmp_path / name, SITE, unit)
    latitude, longitude = PLANE.geographic(POINTS).T
    np.testing.assert_allclose(field(POINTS), hills(latitude, longitude), atol=0.2)
    assert field.unit == said


def wind_file(path: Path, x: np.ndarray, y: np.ndarray, names: tuple[str, str], crs: str) -> None:
    """Write 10 m/s along the first of two axes."""
    xarray = pytest.importorskip("xarray")
    axes = ("latitude", "longitude") if not crs else ("y", "x")
    about = {} if crs else {"units": "degrees"}
    blown = [10.0, 0.0]
    fields = {
        key: (axes, np.full((len(y), len(x)), speed), {"units": "m/s", "standard_name": name})
        for key, speed, name in zip("uv", blown, names, strict=True)
    }
    coords = {axes[0]: (axes[0], y, about), axes[1]: (axes[1], x, about)}
    xarray.Dataset(fields, coords=coords, attrs={"crs": crs} if crs else {}).to_netcdf(path, engine="netcdf4")


def test_wind_along_the_parallels_turns_with_the_meridians(tmp_path: Path) -> None:
    wide = Site(Region(box(20e3, -10e3, 60e3, 10e3)), PLANE)
    axes = (np.linspace(7, 10, 31), np.linspace(46, 48, 21))
    wind_file(tmp_path / "w.nc", *axes, ("eastward_wind", "northward_wind"), "")
    wind = wind_from_toml({"kind": "grid", "file": "w.nc"}, tmp_path, wide)
    points = np.array([[20e3, 0.0], [60e3, 0.0]])
    east = PLANE.geographic(points)[:, 1] - 8.0
    turned = np.radians(east) * np.sin(np.radians(47.0))  # the convergence of the meridians
    np.testing.assert_allclose(wind(points), 10 * np.column_stack([np.cos(turned), np.sin(turned)]), atol=2e-3)


@pytest.mark.parametrize("names", [("eastward_wind", "northward_wind"), ("x_wind", "y_wind")])
def test_wind_along_the_axes_of_a_projection(tmp_path: Path, names: tuple[str, str]) -> None:
    x, y = from_degrees([[47.0, 8.0]], "EPSG:32633")[0]  # zone 33 is turned by 7 × sin 47° there
    axes = (x + np.linspace(-4e3, 4e3, 9), y + np.linspace(-4e3, 4e3, 9))
    wind_file(tmp_path / "w.nc", *axes, names, "EPSG:32633")
    u, v = wind_from_toml({"kind": "sum", "parts": [{"kind": "grid", "file": "w.nc"}]}, tmp_path, SITE)([[0.0, 0.0]])[0]
    grid_north = np.radians(-7.0) * np.sin(np.radians(47.0))  # of true north, west of the zone's middle
    turned = 0.0 if names[0] == "eastward_wind" else -grid_north
    assert (u, v) == pytest.approx((10 * np.cos(turned), 10 * np.sin(turned)), abs=0.02)
