"""The files of a mission that other software reads, as links, and what their heights start from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import quote

from markupsafe import Markup

from reports.damage import reading
from reports.pages.blocks import Block
from reports.pages.page import fragment
from reports.record import read_json

FILES = (
    ("flight", "uav-*.plan", "QGroundControl: mission, geofence and rally point"),
    ("flight", "uav-*.waypoints", "MAVLink waypoints: Mission Planner, MAVProxy, QGroundControl"),
    ("flight", "uav-*.kml", "KML: Google Earth"),
    ("flight", "uav-*.geojson", "GeoJSON, tours: QGIS"),
    ("flight", "flown.geojson", "GeoJSON, flown tracks: QGIS"),
    ("flight", "area.geojson", "GeoJSON, region and no-fly zones: QGIS"),
    ("map", "uav-*.plan", "QGroundControl, as flown in the end"),
    ("map", "uav-*.waypoints", "MAVLink waypoints, as flown in the end"),
    ("map", "uav-*.kml", "KML, as flown in the end"),
    ("map", "uav-*.geojson", "GeoJSON, tours as flown in the end: QGIS"),
    ("map", "flown.geojson", "GeoJSON, tracks as flown in the end: QGIS"),
    ("map", "area.geojson", "GeoJSON, region and no-fly zones in the end: QGIS"),
    ("place", "tasks.geojson", "GeoJSON, tasks: QGIS"),
    ("map", "*.tif", "GeoTIFF, the last map and the field: QGIS"),
    ("map", "maps.nc", "NetCDF, the maps over time: QGIS, xarray"),
    ("environment", "*.nc", "NetCDF, the field, the ground and the wind: QGIS, xarray"),
)
"""Stage, pattern of its files, what they are."""


def exported(folders: Mapping[str, Path]) -> list[Block]:
    """Return the linked list of exported files; links start where the folders of the stages are."""
    if not any(folders["flight"].glob("uav-*.plan")):
        return ["Without an origin = [latitude, longitude] in the mission file there are no files for other software."]
    rows = []
    for stage, pattern, what in FILES:
        found = sorted(path.name for path in folders[stage].glob(pattern))
        if found:
            rows.append((what, [(name, quote(f"{folders[stage].name}/{name}")) for name in found]))
    links: Markup = fragment("exported.html.j2", rows=rows)
    return [links, *_heights(folders["flight"] / "exports.json"), *_without(folders["map"] / "exports.json")]


def _without(path: Path) -> list[str]:
    """Return which flights are not exported as flown in the end; nothing where nothing was re-planned."""
    if not path.is_file():
        return []
    with reading(path, "exports"):
        said: dict[str, str] = read_json(path).get("without", {})
        return [f"{name}, as flown in the end: {sentence}." for name, sentence in said.items()]


def _heights(path: Path) -> list[str]:
    """Return what the heights of the tours start from; nothing for missions made before that was written."""
    if not path.is_file():
        return []
    with reading(path, "exports"):
        said: dict[str, str] = read_json(path)["heights"]
        return [f"{name}: {sentence}" for name, sentence in said.items()]
