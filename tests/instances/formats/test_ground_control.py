"""Tours for ground control: coordinates, order and structure of GeoJSON, KML and .plan."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import box

from instances.formats.ground_control import Tour, write_tour
from instances.geodesy import TangentPlane

PLANE = TangentPlane(47.0, 8.0)
POINTS = np.array([[0.0, 0.0], [1000.0, 0.0], [1000.0, 2000.0]])
TOUR = Tour("a <tour>", POINTS, (None, 4, None), 3000.0, 100.0)
POSITIONS = PLANE.geographic(POINTS)


def test_geojson_is_longitude_first_closed_and_numbered(tmp_path: Path) -> None:
    write_tour(TOUR, PLANE, tmp_path / "t.geojson")
    line, *stops = json.loads((tmp_path / "t.geojson").read_text())["features"]
    coordinates = np.array(line["geometry"]["coordinates"])
    np.testing.assert_allclose(coordinates[:3, [1, 0]], POSITIONS, atol=1e-8)
    assert coordinates[0].tolist() == coordinates[3].tolist()
    assert (coordinates[:, 2] == 3000.0).all()
    assert [stop["properties"] for stop in stops] == [
        {"order": 0, "kind": "depot"},
        {"order": 1, "kind": "task", "task": 4},
        {"order": 2, "kind": "path"},
    ]


def test_kml_is_well_formed_with_absolute_altitudes(tmp_path: Path) -> None:
    write_tour(TOUR, PLANE, tmp_path / "t.kml")
    root = ElementTree.parse(tmp_path / "t.kml").getroot()
    space = "{http://www.opengis.net/kml/2.2}"
    line = root.find(f".//{space}LineString")
    assert line is not None
    assert line.findtext(f"{space}altitudeMode") == "absolute"
    written = [tuple(map(float, c.split(","))) for c in (line.findtext(f"{space}coordinates") or "").split()]
    assert len(written) == 4
    assert written[1][:2] == pytest.approx(tuple(POSITIONS[1, ::-1]), abs=1e-8)
    assert [p.findtext(f"{space}name") for p in root.iter(f"{space}Placemark")] == ["a <tour>", "depot", "task 4"]


def test_plan_takes_off_flies_the_waypoints_and_returns(tmp_path: Path) -> None:
    write_tour(TOUR, PLANE, tmp_path / "t.plan", [box(100, 100, 200, 300)])
    plan = json.loads((tmp_path / "t.plan").read_text())
    assert (plan["fileType"], plan["version"], plan["mission"]["version"]) == ("Plan", 1, 2)
    items = plan["mission"]["items"]
    assert [item["command"] for item in items] == [22, 16, 16, 16, 20]
    assert [item["doJumpId"] for item in items] == [1, 2, 3, 4, 5]
    for item, position in zip(items, POSITIONS[[0, 1, 2, 0]], strict=False):
        assert item["params"][4:6] == pytest.approx(position.tolist(), abs=1e-8)
        assert (item["params"][6], item["frame"], item["AltitudeMode"]) == (3000.0, 0, 2)
    (zone,) = plan["geoFence"]["polygons"]
    assert zone["inclusion"] is False
    np.testing.assert_allclose(np.min(zone["polygon"], axis=0), PLANE.geographic([[100.0, 100.0]])[0], atol=1e-7)
