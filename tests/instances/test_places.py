"""Regions, zones, depots and tasks in degrees and in map projections, as people have them."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from pyproj import Geod
from shapely.geometry import MultiPoint, Point, box, mapping

from instances.errors import InputError
from instances.geodesy import TangentPlane, from_degrees
from instances.georeference import BEND
from instances.scenario import read_scenario, scenario_of, write_scenario

pyogrio = pytest.importorskip("pyogrio")

WEST, SOUTH, EAST, NORTH = 8.0, 47.0, 8.2, 47.1
AREA = box(WEST, SOUTH, EAST, NORTH)
DEPOTS = [[8.05, 47.02], [8.15, 47.08]]
GEOD = Geod(ellps="WGS84")


def kml(*folders: tuple[str, str]) -> str:
    inside = "".join(f"<Folder><name>{name}</name>{marks}</Folder>" for name, marks in folders)
    return f'<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document>{inside}</Document></kml>'


def placemark(polygon: shapely.Polygon) -> str:
    def ring(points: Any) -> str:
        text = " ".join(f"{x},{y},512.5" for x, y in points.coords)
        return f"<LinearRing><coordinates>{text}</coordinates></LinearRing>"

    holes = "".join(f"<innerBoundaryIs>{ring(hole)}</innerBoundaryIs>" for hole in polygon.interiors)
    outer = f"<outerBoundaryIs>{ring(polygon.exterior)}</outerBoundaryIs>"
    return f"<Placemark><Polygon>{outer}{holes}</Polygon></Placemark>"


def pins(points: list[list[float]]) -> str:
    return "".join(f"<Placemark><Point><coordinates>{x},{y},0</coordinates></Point></Placemark>" for x, y in points)


def save(path: Path, *layers: tuple[str, list[Any]], crs: str | None = "EPSG:4326") -> None:
    """Write geometries, layer by layer, in the format of the ending."""
    for number, (name, geometries) in enumerate(layers):
        wkb = np.array(shapely.to_wkb(geometries), dtype=object)
        kind = geometries[0].geom_type
        pyogrio.raw.write(path, wkb, [], [], geometry_type=kind, crs=crs, layer=name, append=number > 0)


def scenario(folder: Path, **changes: Any) -> Any:
    table = {"airspeed": 20.0, "depots": DEPOTS, "tasks": 5} | changes
    return scenario_of({key: value for key, value in table.items() if value is not None}, folder, "s")


def write_area(folder: Path, name: str) -> None:
    path = folder / name
    if name.endswith(".kml"):
        path.write_text(kml(("survey", placemark(AREA))))
    elif name.endswith(".kmz"):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("doc.kml", kml(("survey", placemark(AREA))))
    elif name.endswith(".zip"):
        save(folder / "inside.shp", ("inside", [AREA]))
        with zipfile.ZipFile(path, "w") as archive:
            for part in folder.glob("inside.*"):
                archive.write(part, f"folder/{part.name}")
    elif name == "utm.gpkg":
        utm = shapely.transform(AREA, lambda p: from_degrees(p[:, ::-1], "EPSG:32632"))
        save(path, ("survey", [utm]), crs="EPSG:32632")
    elif name == "old.geojson":
        crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32632"}}
        utm = shapely.transform(AREA, lambda p: from_degrees(p[:, ::-1], "EPSG:32632"))
        path.write_text(json.dumps({**mapping(utm), "crs": crs}))
    elif name.endswith(".geojson"):
        path.write_text(json.dumps(mapping(AREA)))
    else:
        save(path, ("survey", [AREA]))


@pytest.mark.parametrize("name", ["a.kml", "a.kmz", "a.geojson", "a.gpkg", "a.shp", "a.zip", "utm.gpkg", "old.geojson"])
def test_a_region_in_every_format(tmp_path: Path, name: str) -> None:
    write_area(tmp_path, name)
    found = scenario(tmp_path, region=name)
    assert (found.plane.latitude, found.plane.longitude) == pytest.approx((47.05, 8.1), abs=1e-4)
    area, _ = GEOD.geometry_area_perimeter(shapely.segmentize(AREA, 0.001))
    assert found.region.area == pytest.approx(abs(area), rel=2e-4)
    back = found.plane.geographic(found.depots)[:, ::-1]
    np.testing.assert_allclose(back, DEPOTS, atol=1e-9)
    away = GEOD.inv(*DEPOTS[0], *DEPOTS[1])[2]
    assert np.hypot(*(found.depots[1] - found.depots[0])) == pytest.approx(away, rel=1e-5)


def test_edges_along_parallels_stay_where_they_are(tmp_path: Path) -> None:
    """A parallel of 15 km is 3 m beside the straight line between its ends."""
    write_area(tmp_path, "a.kml")
    region = scenario(tmp_path, region="a.kml").region
    plane = TangentPlane(47.05, 8.1)
    parallel = plane.local(np.column_stack([np.full(999, NORTH), np.linspace(WEST, EAST, 999)]))
    straight = shapely.distance(shapely.LineString(parallel[[0, -1]]), shapely.points(parallel)).max()
    assert straight > 3.0
    assert np.abs(region.signed_distance(parallel)).max() <= BEND
    assert len(region.rings[0]) < 40


def test_one_file_of_several_folders(tmp_path: Path) -> None:
    hole = box(8.02, 47.04, 8.03, 47.05)
    zones = placemark(box(8.1, 47.03, 8.11, 47.04)) + placemark(box(8.12, 47.03, 8.13, 47.04))
    folders = [("Area", placemark(AREA - hole)), ("No-fly", zones), ("Depots", pins(DEPOTS)), ("Tasks", pins(DEPOTS))]
    (tmp_path / "m.kml").write_text(kml(*folders))
    found = scenario(tmp_path, region="m.kml|layername=Area", no_fly="m.kml", depots="m.kml", tasks="m.kml")
    assert len(found.no_fly) == 2
    assert len(found.region.rings) == 2
    assert found.n_tasks == 2
    np.testing.assert_array_equal(found.depots, scenario(tmp_path, region="m.kml|layername=Area").depots)
    with pytest.raises(InputError, match=r"m\.kml: region: holds polygons in several layers \(Area, No-fly\): name"):
        scenario(tmp_path, region="m.kml")
    with pytest.raises(InputError, match=r"there is no layer 'Aera'; did you mean 'Area'\?"):
        scenario(tmp_path, region="m.kml|layername=Aera")


def test_layers_of_a_geopackage(tmp_path: Path) -> None:
    save(tmp_path / "m.gpkg", ("region", [AREA]), ("zones", [box(8.1, 47.03, 8.11, 47.04)]), ("d", [Point(*DEPOTS[0])]))
    found = scenario(tmp_path, region="m.gpkg", no_fly="m.gpkg|layername=zones", depots="m.gpkg")
    assert len(found.no_fly) == 1
    assert len(found.depots) == 1


def test_points_of_a_collection_are_tasks(tmp_path: Path) -> None:
    collection = {
        "type": "FeatureCollection",
        "features": [
            {"type": "Feature", "properties": {}, "geometry": mapping(geometry)}
            for geometry in (AREA, Point(8.1, 47.05), MultiPoint([(8.11, 47.05, 3.0), (8.12, 47.05, 4.0)]))
        ],
    }
    (tmp_path / "m.geojson").write_text(json.dumps(collection))
    found = scenario(tmp_path, region="m.geojson", tasks="m.geojson")
    np.testing.assert_allclose(found.plane.geographic(found.tasks)[:, 1], [8.1, 8.11, 8.12])


def test_lists_in_the_reference_system_asked_for(tmp_path: Path) -> None:
    write_area(tmp_path, "a.kml")
    utm = from_degrees(np.array(DEPOTS)[:, ::-1], "EPSG:32632").tolist()
    degrees = scenario(tmp_path, region="a.kml")
    metres = scenario(tmp_path, region="a.kml", depots=utm, crs="EPSG:32632")
    np.testing.assert_allclose(degrees.depots, metres.depots, atol=1e-3)
    write_area(tmp_path, "a.geojson")  # in degrees, whatever lists are in
    metres = scenario(tmp_path, region="a.geojson", depots=utm, crs="EPSG:32632")
    np.testing.assert_allclose(degrees.depots, metres.depots, atol=1e-3)
    local = scenario(tmp_path, region="a.kml", depots=[[0.0, 10.0]], crs="local", radio={"position": [5, 5]})
    assert local.depots.tolist() == [[0.0, 10.0]]
    assert local.radio["position"] == [5, 5]
    placed = scenario(tmp_path, region="a.kml", radio={"position": [8.1, 47.05], "height": 3.0})
    assert placed.radio["height"] == 3.0
    np.testing.assert_allclose(placed.radio["position"], [0.0, 0.0], atol=1e-3)


def test_a_region_in_utm_and_lists_beside_it(tmp_path: Path) -> None:
    write_area(tmp_path, "utm.gpkg")
    utm = from_degrees(np.array(DEPOTS)[:, ::-1], "EPSG:32632").tolist()
    degrees = scenario(tmp_path, region="utm.gpkg")
    np.testing.assert_allclose(scenario(tmp_path, region="utm.gpkg", depots=utm).depots, degrees.depots, atol=1e-3)


def test_local_metres_stay_local_metres(tmp_path: Path) -> None:
    (tmp_path / "a.geojson").write_text(json.dumps(mapping(box(0, 0, 170, 80))))
    (tmp_path / "z.geojson").write_text(json.dumps(mapping(box(3, 3, 4, 4))))
    for more in ({}, {"origin": [47.0, 8.0]}):
        found = scenario(tmp_path, region="a.geojson", no_fly="z.geojson", depots=[[8.05, 47.02]], **more)
        assert found.region.bounds == (0, 0, 170, 80)
        assert found.no_fly[0].bounds == (3, 3, 4, 4)
        assert found.depots.tolist() == [[8.05, 47.02]]
    small = {"region": "z.geojson", "crs": "local", "depots": [[3.5, 3.5]]}
    assert scenario(tmp_path, **small).region.bounds == (3, 3, 4, 4)


def test_local_metres_and_files_in_degrees_meet_at_the_origin(tmp_path: Path) -> None:
    (tmp_path / "d.kml").write_text(kml(("depots", pins([[8.001, 47.001]]))))
    found = scenario(tmp_path, size=[4000, 3000], depots="d.kml", origin=[47.0, 8.0])
    np.testing.assert_allclose(found.depots, TangentPlane(47.0, 8.0).local([[47.001, 8.001]]))
    with pytest.raises(InputError, match=r"d\.kml: coordinates in 'EPSG:4326' beside a region in local metres.*origin"):
        scenario(tmp_path, size=[4000, 3000], depots="d.kml")
    degrees = scenario(tmp_path, size=[4000, 3000], depots=[[8.001, 47.001]], origin=[47.0, 8.0], crs="EPSG:4326")
    np.testing.assert_array_equal(degrees.depots, found.depots)


def test_zones_far_away_are_left_out(tmp_path: Path) -> None:
    write_area(tmp_path, "a.kml")
    far, near = placemark(box(-120, -40, -119, -39)), placemark(box(8.1, 47, 8.11, 47.01))
    (tmp_path / "z.kml").write_text(kml(("z", far + near)))
    assert len(scenario(tmp_path, region="a.kml", no_fly="z.kml").no_fly) == 1


def test_the_south_and_the_west(tmp_path: Path) -> None:
    (tmp_path / "a.geojson").write_text(json.dumps(mapping(box(-70.2, -33.1, -70.0, -33.0))))
    found = scenario(tmp_path, region="a.geojson", depots=[[-70.1, -33.05], [-70.1, -33.01]])
    away = GEOD.inv(-70.1, -33.05, -70.1, -33.01)[2]
    assert found.depots[1] - found.depots[0] == pytest.approx([0.0, away], abs=0.1)


def test_what_is_written_reads_back_the_same(tmp_path: Path) -> None:
    write_area(tmp_path, "a.kml")
    (tmp_path / "z.kml").write_text(kml(("z", placemark(box(8.1, 47, 8.11, 47.01)))))
    found = scenario(tmp_path, region="a.kml", no_fly="z.kml", tasks=DEPOTS)
    write_scenario(found, tmp_path / "kept.toml")
    back = read_scenario(tmp_path / "kept.toml")
    assert back.plane == found.plane
    assert back.region.polygon == found.region.polygon
    assert back.no_fly == found.no_fly
    np.testing.assert_array_equal(back.points, found.points)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"depots": [[47.02, 8.05]]},
            r"^depots\[0\] = \[47\.02, 8\.05\] \('EPSG:4326'\) lies outside the region, longitude 8\.0\d* to 8\.2\d*, "
            r"latitude 47\.0\d* to 47\.1\d*: the other way round it lies inside; longitude comes first$",
        ),
        ({"radio": {"position": [47.05, 8.1]}}, r"^radio\.position: \[47\.05, 8\.1\] lies .*longitude comes first$"),
        ({"region": "a.kml|layername=x"}, r"/a\.kml: there is no layer 'x' \(layers: survey\)$"),
        ({"depots": [[9.5, 47.02]]}, r"^depots\[0\] = \[9\.5, 47\.02\] .* latitude [\d.]+ to [\d.]+$"),
        ({"tasks": "b.kml"}, r"b\.kml: tasks\[1\] = \[8\.5, 47\.08\]"),
        ({"tasks": "lines.geojson"}, r"lines\.geojson: tasks: must hold a point, it holds LineString"),
        ({"tasks": "a.xlsx"}, r"a\.xlsx: tasks: must be a file of places"),
        ({"tasks": "none.kml"}, r"none\.kml: cannot be read \(No such file"),
        ({"tasks": "no.kml"}, r"no\.kml: is no KML"),
        ({"tasks": "no.gpkg"}, r"no\.gpkg: is not what its ending \.gpkg says"),
        ({"tasks": "no.kmz"}, r"no\.kmz: cannot be unpacked"),
        ({"crs": "EPSG:nonsense"}, r'crs must be a coordinate reference system such as "EPSG:4326", or "local"'),
        ({"crs": 4326}, r"crs must be a text, got 4326"),
        ({"origin": [8.1, 47.05]}, r"origin = \[8\.1, 47\.05\] is too far from the region, .*\[latitude, longitude\]"),
        ({"origin": 8.1}, r"origin must be \[latitude, longitude\] in degrees, got 8\.1"),
        ({"region": "antimeridian.geojson"}, r"longitude -179\.9 to 179\.9, .*: regions across the antimeridian"),
        ({"region": "beyond.geojson", "crs": "EPSG:4326"}, r"\[179\.9, 47\.0\]|\[180\.1, 47\.0\] is no \[longitude, "),
        ({"region": "pole.geojson"}, r"latitude 89\.2 to 89\.4: within a degree of a pole is not supported"),
        ({"region": "large.kml"}, r"at most 500 km fit into a local plane"),
        ({"region": "two.kml"}, r"two\.kml: must hold one polygon, got 2"),
        ({"region": "bow.geojson"}, r"bow\.geojson: region: the polygon is not valid: Self-intersection"),
    ],
)
def test_places_that_cannot_be_used_are_named(tmp_path: Path, changes: dict[str, Any], words: str) -> None:
    write_area(tmp_path, "a.kml")
    (tmp_path / "b.kml").write_text(kml(("b", pins([[8.05, 47.02], [8.5, 47.08]]))))
    (tmp_path / "lines.geojson").write_text(json.dumps(mapping(shapely.LineString([(8, 47), (9, 48)]))))
    for name in ("no.kml", "no.gpkg", "no.kmz"):
        (tmp_path / name).write_text("<OGRVRTDataSource/>")
    (tmp_path / "antimeridian.geojson").write_text(json.dumps(mapping(box(-179.9, 47, 179.9, 47.1))))
    (tmp_path / "beyond.geojson").write_text(json.dumps(mapping(box(179.9, 47, 180.1, 47.1))))
    (tmp_path / "pole.geojson").write_text(json.dumps(mapping(box(8.0, 89.2, 8.2, 89.4))))
    (tmp_path / "large.kml").write_text(kml(("a", placemark(box(0, 40, 9, 47)))))
    (tmp_path / "two.kml").write_text(kml(("a", placemark(AREA) + placemark(box(8.3, 47, 8.4, 47.1)))))
    bow = {"type": "Polygon", "coordinates": [[[8, 47], [8.2, 47.1], [8.2, 47], [8, 47.1], [8, 47]]]}
    (tmp_path / "bow.geojson").write_text(json.dumps(bow))
    with pytest.raises(InputError, match=words):
        scenario(tmp_path, **{"region": "a.kml", **changes})


def test_polygons_side_by_side_are_one_region(tmp_path: Path) -> None:
    halves = placemark(box(8, 47, 8.1, 47.1)) + placemark(box(8.1, 47, 8.2, 47.1))
    (tmp_path / "a.kml").write_text(kml(("a", f"{halves}")))
    assert scenario(tmp_path, region="a.kml").region.area == pytest.approx(1.69e8, rel=0.01)


def test_an_archive_that_opens_to_too_much(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from instances import documents

    monkeypatch.setattr(documents, "OPENS_AT_LEAST", 1000)
    with zipfile.ZipFile(tmp_path / "a.kmz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("doc.kml", "<kml>" + " " * 100_000)
    with pytest.raises(InputError, match=r"a\.kmz: opens to more than [\d,]+ bytes"):
        scenario(tmp_path, region="a.kmz")
