"""Tours for ground control, read by libraries that are not ours; coordinates, order, heights, fences."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from fastkml import KML, Placemark
from fastkml.enums import AltitudeMode
from fastkml.utils import find_all
from geojson_pydantic import FeatureCollection
from pymavlink.mavwp import MAVWPLoader
from shapely.geometry import Polygon, box

from instances.errors import InputError
from instances.formats.ground_control import ENDINGS, write_tour
from instances.formats.mavlink_items import FIRMWARE, KINDS, Vehicle
from instances.formats.tour import FRAMES, Tour
from instances.geodesy import TangentPlane

PLANE = TangentPlane(47.0, 8.0)
POINTS = np.array([[0.0, 0.0], [1000.0, 0.0], [1000.0, 2000.0]])
POSITIONS = PLANE.geographic(POINTS)
GROUND = np.array([400.0, 500.0, 650.0])
HEIGHTS = np.array([520.0, 620.0, 770.0])
TASKS = (None, 4, None)
TOUR = Tour("a <tour>", POINTS, TASKS, HEIGHTS, 25.0, GROUND)
BLIND = Tour("a <tour>", POINTS, TASKS, np.full(3, 3000.0), 25.0)
REGION = Polygon(box(-500, -500, 2500, 2500).exterior, [box(1500, 1500, 1700, 1700).exterior])
ZONE = Polygon(box(100, 100, 200, 300).exterior, [box(120, 120, 150, 150).exterior])
SCHEMA = json.loads((Path(__file__).parent / "qgc_plan.schema.json").read_text())
IN_FRAME = {"amsl": HEIGHTS, "above-home": HEIGHTS - 400.0, "above-ground": HEIGHTS - GROUND}


def plan(path: Path, tour: Tour = TOUR, **how: Any) -> dict[str, Any]:
    """Write a plan, check it against the schema and return it."""
    write_tour(tour, PLANE, path / "t.plan", **how)
    written = json.loads((path / "t.plan").read_text())
    jsonschema.Draft202012Validator(SCHEMA).validate(written)
    return written


def loaded(path: Path, tour: Tour = TOUR, **how: Any) -> list[Any]:
    """Write a waypoint file and return what pymavlink reads."""
    write_tour(tour, PLANE, path / "t.waypoints", **how)
    loader = MAVWPLoader()
    assert loader.load(str(path / "t.waypoints")) == loader.count()
    return loader.wpoints


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("firmware", FIRMWARE)
@pytest.mark.parametrize("kind", KINDS)
def test_a_plan_takes_off_sets_the_speed_flies_and_comes_home(
    tmp_path: Path, frame: str, firmware: str, kind: str
) -> None:
    written = plan(tmp_path, frame=frame, vehicle=Vehicle(firmware, kind))
    mission, items = written["mission"], written["mission"]["items"]
    assert (mission["firmwareType"], mission["vehicleType"]) == (FIRMWARE[firmware], KINDS[kind])
    assert [item["command"] for item in items] == [22, 178, 16, 16, 16, 20 if kind == "fixed-wing" else 21]
    assert [item["doJumpId"] for item in items] == [1, 2, 3, 4, 5, 6]
    assert mission["plannedHomePosition"] == pytest.approx([*POSITIONS[0], 400.0])
    take_off, speed, *waypoints, _ = items
    assert (take_off["frame"], take_off["params"][6]) == (3, 120.0)
    towards = POSITIONS[1 if kind == "fixed-wing" else 0]
    assert take_off["params"][4:6] == pytest.approx(towards.tolist(), abs=1e-8)
    assert (speed["frame"], speed["params"][:2]) == (2, [0.0 if kind == "fixed-wing" else 1.0, 25.0])
    order = [1, 2, 0]
    for item, k in zip(waypoints, order, strict=True):
        assert item["params"][4:6] == pytest.approx(POSITIONS[k].tolist(), abs=1e-8)
        assert item["Altitude"] == IN_FRAME[frame][k]
    px4_over_ground = (firmware, frame) == ("px4", "above-ground")
    heights = HEIGHTS if px4_over_ground else IN_FRAME[frame]
    assert [item["params"][6] for item in waypoints] == heights[order].tolist()
    wanted = (0, 3) if px4_over_ground else {"amsl": (0, 2), "above-home": (3, 1), "above-ground": (10, 4)}[frame]
    assert {(item["frame"], item["AltitudeMode"]) for item in waypoints} == {wanted}
    assert mission["globalPlanAltitudeMode"] == (1 if frame == "above-home" else 0)


def test_a_multirotor_lands_at_home(tmp_path: Path) -> None:
    land = plan(tmp_path, vehicle=Vehicle("ardupilot", "multirotor"))["mission"]["items"][-1]
    assert (land["command"], land["frame"], land["params"][6]) == (21, 3, 0.0)
    assert land["params"][4:6] == pytest.approx(POSITIONS[0].tolist(), abs=1e-8)


@pytest.mark.parametrize("frame", ["amsl", "above-home"])
def test_home_is_never_at_flight_altitude(tmp_path: Path, frame: str) -> None:
    mission = plan(tmp_path, BLIND, frame=frame)["mission"]
    assert mission["plannedHomePosition"][2] == 0.0
    assert mission["items"][0]["frame"] == {"amsl": 0, "above-home": 3}[frame]
    assert loaded(tmp_path, BLIND, frame=frame)[0].z == 0.0
    write_tour(BLIND, PLANE, tmp_path / "t.kml", frame=frame)
    assert "the height of the ground is not known, so home is put at 0 m" in (tmp_path / "t.kml").read_text()


def test_fences_keep_inside_the_region_and_outside_zones_and_holes(tmp_path: Path) -> None:
    written = plan(tmp_path, region=REGION, no_fly=[ZONE])
    region, hole, zone = written["geoFence"]["polygons"]
    assert [fence["inclusion"] for fence in (region, hole, zone)] == [True, False, False]
    for fence, shape in ((region, REGION), (hole, Polygon(REGION.interiors[0])), (zone, ZONE)):
        outline = Polygon([(lon, lat) for lat, lon in fence["polygon"]])
        assert not outline.exterior.is_ccw
        corners = PLANE.geographic(np.array(shape.exterior.coords))
        assert outline.bounds == pytest.approx([*corners.min(axis=0)[::-1], *corners.max(axis=0)[::-1]], abs=1e-7)
    assert len(zone["polygon"]) == 4


def test_the_rally_point_is_over_the_depot_above_home(tmp_path: Path) -> None:
    (rally,) = plan(tmp_path)["rallyPoints"]["points"]
    assert rally == pytest.approx([*POSITIONS[0], 120.0])
    assert plan(tmp_path, BLIND)["rallyPoints"]["points"] == []  # how high above home is not known
    assert plan(tmp_path, BLIND, frame="above-home")["rallyPoints"]["points"][0][2] == 3000.0


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("firmware", FIRMWARE)
@pytest.mark.parametrize("kind", KINDS)
def test_a_waypoint_file_holds_home_and_the_items_of_the_plan(
    tmp_path: Path, frame: str, firmware: str, kind: str
) -> None:
    how = {"frame": frame, "vehicle": Vehicle(firmware, kind)}
    home, *items = loaded(tmp_path, **how)
    assert (home.seq, home.current, home.command, home.frame, home.z) == (0, 1, 16, 0, 400.0)
    assert [home.x, home.y] == pytest.approx(POSITIONS[0].tolist(), abs=1e-6)
    planned = plan(tmp_path, **how)["mission"]["items"]
    for item, other in zip(items, planned, strict=True):
        assert (item.seq, item.command, item.frame, item.current, item.autocontinue) == (
            other["doJumpId"], other["command"], other["frame"], 0, 1,
        )  # fmt: skip
        own = float("nan") if firmware == "px4" else 0.0
        params = [own if value is None else value for value in other["params"]]
        written = [getattr(item, name) for name in ("param1", "param2", "param3", "param4", "x", "y", "z")]
        assert written == pytest.approx(params, abs=1e-5, nan_ok=True)


@pytest.mark.parametrize("frame", FRAMES)
def test_kml_has_its_heights_in_the_mode_that_says_what_they_are_above(tmp_path: Path, frame: str) -> None:
    write_tour(TOUR, PLANE, tmp_path / "t.kml", frame=frame)
    tour, depot, task = find_all(KML.parse(tmp_path / "t.kml"), of_type=Placemark)
    assert [mark.name for mark in (tour, depot, task)] == ["a <tour>", "depot", "task 4"]
    over_ground = frame == "above-ground"
    mode = AltitudeMode.relative_to_ground if over_ground else AltitudeMode.absolute
    assert {mark.kml_geometry.altitude_mode for mark in (tour, depot, task)} == {mode}
    written = np.array(tour.geometry.coords)
    np.testing.assert_allclose(written[:3, [1, 0]], POSITIONS, atol=1e-8)
    np.testing.assert_array_equal(written[0], written[3])
    np.testing.assert_allclose(written[:3, 2], IN_FRAME["above-ground" if over_ground else "amsl"], atol=0.01)


def test_kml_is_the_same_bytes_again_and_has_no_exponents(tmp_path: Path) -> None:
    for name in ("t.kml", "u.kml"):
        write_tour(TOUR, TangentPlane(1e-7, -1e-7), tmp_path / name)
    assert (tmp_path / "t.kml").read_bytes() == (tmp_path / "u.kml").read_bytes()
    assert "e-" not in (tmp_path / "t.kml").read_text().partition("<coordinates>")[2].partition("<")[0]


def test_geojson_is_longitude_first_closed_and_numbered(tmp_path: Path) -> None:
    write_tour(TOUR, PLANE, tmp_path / "t.geojson")
    text = (tmp_path / "t.geojson").read_text()
    assert "crs" not in json.loads(text)
    line, *stops = FeatureCollection.model_validate_json(text).features
    written = np.array(line.geometry.coordinates)
    np.testing.assert_allclose(written[:3, ::-1], POSITIONS, atol=1e-8)
    assert written[0].tolist() == written[3].tolist()
    assert line.properties["altitudes"] == [520.0, 620.0, 770.0, 520.0]
    assert [stop.properties for stop in stops] == [
        {"order": 0, "kind": "depot", "altitude": 520.0},
        {"order": 1, "kind": "task", "altitude": 620.0, "task": 4},
        {"order": 2, "kind": "path", "altitude": 770.0},
    ]


@pytest.mark.parametrize("ending", [ending for ending in ENDINGS if ending != ".geojson"])
def test_heights_above_unknown_ground_are_refused(tmp_path: Path, ending: str) -> None:
    with pytest.raises(InputError, match="'above-ground' needs the height of the ground"):
        write_tour(BLIND, PLANE, tmp_path / f"t{ending}", frame="above-ground")
    assert not list(tmp_path.iterdir())


def test_a_tour_through_a_mountain_is_refused() -> None:
    with pytest.raises(InputError, match="a: waypoint 2 at 300 m is not above the ground, which is at 650 m"):
        Tour("a", POINTS, TASKS, np.array([500.0, 600.0, 300.0]), 25.0, GROUND)


def test_what_is_no_frame_firmware_or_vehicle(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="frame must be one of amsl, above-home, above-ground, got 'agl'"):
        write_tour(TOUR, PLANE, tmp_path / "t.plan", frame="agl")
    with pytest.raises(InputError, match="firmware must be one of px4, ardupilot, got 'betaflight'"):
        Vehicle("betaflight")
    with pytest.raises(InputError, match="vehicle must be one of fixed-wing, multirotor, got 'boat'"):
        Vehicle(kind="boat")
