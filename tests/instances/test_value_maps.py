"""Maps of importance and of prior standard deviation from files as people have them, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from shapely.geometry import box, mapping

from instances.environment.region import Region
from instances.environment.site import Site
from instances.errors import InputError
from instances.geodesy import TangentPlane, from_degrees
from instances.value_maps import read_value_map

LOCAL = Site(Region.rectangle(4000, 2000))
PLANE = TangentPlane(47.0, 8.0)
EARTH = Site(Region(box(-2000, -2000, 2000, 2000)), PLANE)


def collection(path: Path, *features: tuple[Any, Any], crs: str = "") -> Path:
    """Write polygons with their property ``value``, none where it is None."""
    made = [
        {"type": "Feature", "properties": {} if value is None else {"value": value}, "geometry": mapping(polygon)}
        for polygon, value in features
    ]
    more = {"crs": {"type": "name", "properties": {"name": crs}}} if crs else {}
    path.write_text(json.dumps({"type": "FeatureCollection", "features": made, **more}))
    return path


def degrees(polygon: shapely.Polygon) -> shapely.Polygon:
    return shapely.transform(polygon, lambda p: PLANE.geographic(p)[:, ::-1])


def test_the_last_polygon_counts_and_elsewhere_does_where_none_lies(tmp_path):
    path = collection(tmp_path / "w.geojson", (box(0, 0, 2000, 2000), 3.0), (box(1000, 0, 3000, 1000), 0))
    found = read_value_map(path, LOCAL, 1.0)
    places = [[500, 500], [500, 1500], [1500, 500], [1500, 1500], [2500, 500], [2500, 1500], [3900, 100]]
    assert found(places) == pytest.approx([3, 3, 0, 3, 0, 1, 1])


def test_a_road_narrower_than_a_cell_is_on_the_map(tmp_path):
    path = collection(tmp_path / "road.geojson", (box(-10, 1003.0, 5000, 1004.0), 9.0))
    assert read_value_map(path, LOCAL, 1.0)([[1234.0, 1003.5]]) > 5.0


@pytest.mark.parametrize("ending", [".geojson", ".kml", ".gpkg", ".shp"])
def test_polygons_in_degrees_lie_where_they_are(tmp_path, ending):
    path, field = tmp_path / f"w{ending}", degrees(box(-1500, -1000, 500, 1500))
    if ending == ".geojson":
        collection(path, (field, 2.5))
    elif ending == ".kml":  # as Google Earth writes a property
        pytest.importorskip("pyogrio")
        ring = " ".join(f"{x!r},{y!r}" for x, y in field.exterior.coords)
        path.write_text(
            '<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><ExtendedData>'
            '<Data name="value"><value>2.5</value></Data></ExtendedData><Polygon><outerBoundaryIs><LinearRing>'
            f"<coordinates>{ring}</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>"
        )
    else:
        raw = pytest.importorskip("pyogrio.raw")
        about = {"geometry_type": "Polygon", "crs": "EPSG:4326"}
        raw.write(path, shapely.to_wkb(np.array([field])), [np.array([2.5])], ["value"], **about)
    found = read_value_map(path, EARTH, 1.0)
    assert found([[-1400, 0], [400, 1400], [600, 0], [0, -1100]]) == pytest.approx([2.5, 2.5, 1, 1])


def test_polygons_of_another_projection(tmp_path):
    utm = shapely.transform(degrees(box(-1000, -1000, 1000, 1000)), lambda p: from_degrees(p[:, ::-1], "EPSG:32632"))
    path = collection(tmp_path / "w.geojson", (utm, 4.0), crs="EPSG:32632")
    assert read_value_map(path, EARTH, 1.0)([[-900, 900], [900, -900], [1100, 0]]) == pytest.approx([4, 4, 1])


def test_a_raster_in_degrees_and_a_grid_in_metres(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    at, step = (np.arange(200) - 99.5) / 2400, 1 / 2400
    longitude, latitude = np.meshgrid(8 + at, 47 - at)
    values = 10 + 100 * (longitude - 8) + 50 * (latitude - 47)
    shape = {"driver": "GTiff", "width": 200, "height": 200, "count": 1, "dtype": "float64", "crs": "EPSG:4326"}
    corner = rasterio.Affine(step, 0, 8 + at[0] - step / 2, 0, -step, 47 - at[0] + step / 2)
    with rasterio.open(tmp_path / "s.tif", "w", transform=corner, **shape) as out:
        out.write(values, 1)
    found = read_value_map(tmp_path / "s.tif", EARTH, 1.0)
    points = EARTH.region.sample(50, np.random.default_rng(0))
    q = PLANE.geographic(points)
    assert found(points) == pytest.approx(10 + 100 * (q[:, 1] - 8) + 50 * (q[:, 0] - 47), abs=1e-3)
    assert max(map(abs, found.bounds)) < 2100  # nodes far from the region have no say in what is greatest


def test_points_are_linear_between_and_the_nearest_one_s_beyond(tmp_path):
    def plane(p: np.ndarray) -> np.ndarray:
        return 5 + p[:, 0] / 1000 + p[:, 1] / 500

    points = np.random.default_rng(1).uniform((500, 300), (3500, 1700), (60, 2))
    lines = [f"{x!r},{y!r},{v!r}" for (x, y), v in zip(points.tolist(), plane(points).tolist(), strict=True)]
    path = tmp_path / "s.csv"
    path.write_text("\n".join(["x,y,value", *lines]))
    found, inside = read_value_map(path, LOCAL, 1.0), np.array([[1500.0, 900], [2200, 1100], [2600, 700]])
    assert found(inside) == pytest.approx(plane(inside), abs=1e-6)
    corner = points[np.argmin(np.hypot(*points.T))]
    assert found([[0.0, 0.0]]) == pytest.approx(plane(corner[None]))


def test_two_points_share_the_region(tmp_path):
    path = tmp_path / "s.csv"
    path.write_text("Lon,Lat,value\n7.99,47,3\n8.01,47,8\n")
    assert read_value_map(path, EARTH, 1.0)([[-1000, 500], [1000, -500]]) == pytest.approx([3, 8])


SQUARE = box(0, 0, 1000, 1000)


@pytest.mark.parametrize(
    ("features", "words"),
    [
        ([(SQUARE, -2)], r"w.geojson: polygon 0: its property 'value' must be a number of at least 0, got -2"),
        ([(SQUARE, 1), (SQUARE, "much")], "polygon 1: its property 'value' must be a number of at least 0, got 'much'"),
        ([(SQUARE, None)], "polygon 0: its property 'value' must be a number of at least 0, it is missing"),
        ([(SQUARE, True)], "got True"),
        ([(SQUARE, 1e300)], "got 1e"),
        ([(box(9000, 9000, 9100, 9100), 2)], "none of its polygons meets the region"),
        ([(shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), 2)], "w.geojson: region: the polygon is not valid"),
        ([(shapely.Point(1, 1), 2)], "value: must hold a polygon, it holds Point"),
    ],
)
def test_polygons_that_cannot_be_used(tmp_path, features, words):
    with pytest.raises(InputError, match=words):
        read_value_map(collection(tmp_path / "w.geojson", *features), LOCAL, 1.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x,y,weight\n1,2,3\n", "w.csv: must have columns x, y, value or lon, lat, value, it has x, y, weight"),
        ("x,y,value\n1,2,3\n1,3,-4\n", "w.csv: line 3: value must be a number of at least 0, got '-4'"),
        ("x,y,value\n1,2,nan\n", "line 2: value must be a number of at least 0, got 'nan'"),
        ("x,y,value\n1,2\n", "line 2: value must be a number of at least 0, it is missing"),
        ("x,y,value\n1,oops,3\n", "line 2: y must be a number, got 'oops'"),
        ("x,y,value\n1,2,3\n\n1,2,4\n", r"line 4: the point \(1, 2\) is given twice"),
        ("x,y,value\n", "holds no point"),
        ("", "it has none"),
        ("x,y,value\n-5,-5,3\n", "none of its 1 points lies within"),
        ("x,y,value\n5,5,0\n", "all values are 0"),
        ("lon,lat,value\n8,47,1\n", "beside a region in local metres"),
    ],
)
def test_points_that_cannot_be_used(tmp_path, text, words):
    (tmp_path / "w.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        read_value_map(tmp_path / "w.csv", LOCAL, 1.0)


@pytest.mark.parametrize(
    ("low", "value", "words"),
    [(0.0, -3.0, r"w.nc: value at \(2000, 1000\) m is negative: -3"), (0.0, np.nan, "missing"), (500.0, 3.0, "covers")],
)
def test_rasters_that_cannot_be_used(tmp_path, low, value, words):
    xarray = pytest.importorskip("xarray")
    x, y = np.linspace(low, 4000.0, 9), np.linspace(0.0, 2000.0, 5)
    values = np.ones((5, 9))
    values[2, 4] = value
    xarray.Dataset({"w": (("y", "x"), values)}, coords={"x": x, "y": y}).to_netcdf(tmp_path / "w.nc")
    with pytest.raises(InputError, match=words):
        read_value_map(tmp_path / "w.nc", LOCAL, 1.0)


def test_other_files_are_refused(tmp_path):
    (tmp_path / "w.txt").write_text("1")
    with pytest.raises(
        InputError, match=r"w.txt: a map of values must be a raster, a CSV of points or a file of polygons"
    ):
        read_value_map(tmp_path / "w.txt", LOCAL, 1.0)
    with pytest.raises(InputError, match=r"w.csv"):
        read_value_map(tmp_path / "w.csv", LOCAL, 1.0)
