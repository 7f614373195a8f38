"""Tours for ground-control software: GeoJSON (RFC 7946), KML (OGC 2.3) and QGroundControl's ``.plan``.

Coordinates are WGS 84, of the tangent plane at the mission's origin (`instances.geodesy`); altitudes are metres above
mean sea level. A ``.plan`` is JSON as QGroundControl's developer guide describes it (Plan File Format): MAVLink
commands 22 (take off), 16 (waypoint) and 20 (return to launch) in frame 0 (global, above mean sea level), and no-fly
zones as an exclusion geofence.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
from shapely.geometry import Polygon

from instances.arrays import Floats
from instances.disk import write_aside
from instances.geodesy import TangentPlane

DIGITS = 8
"""Digits of a degree that are written: 1 mm."""


@dataclass(frozen=True, eq=False)
class Tour:
    """One UAV's tour as waypoints.

    name; points (k, 2) [m], the first the depot, to which it returns; tasks, which of the points are tasks, as task
    numbers, None for others; altitude [m above mean sea level]; speed [m/s].
    """

    name: str
    points: Floats
    tasks: Sequence[int | None]
    altitude: float
    speed: float


def write_tour(tour: Tour, plane: TangentPlane, path: Path | str, no_fly: Sequence[Polygon] = ()) -> None:
    """Write `tour` as .geojson, .kml or .plan by the ending of `path`; only a .plan carries the no-fly zones."""
    path = Path(path)
    positions = plane.geographic(tour.points).round(DIGITS)
    if path.suffix == ".geojson":
        text = json.dumps(_geojson(tour, positions))
    elif path.suffix == ".kml":
        text = _kml(tour, positions)
    else:
        zones = [plane.geographic(np.asarray(zone.exterior.coords)[:-1, :2]).round(DIGITS) for zone in no_fly]
        text = json.dumps(_plan(tour, positions, zones), indent=1)
    write_aside(path, text)


def _geojson(tour: Tour, positions: Floats) -> dict[str, Any]:
    """Return a line of the whole tour, then its waypoints in flying order; longitude comes first, then altitude."""
    coordinates = [[lon, lat, tour.altitude] for lat, lon in positions.tolist()]
    line = {
        "type": "Feature",
        "properties": {"name": tour.name, "speed": tour.speed},
        "geometry": {"type": "LineString", "coordinates": [*coordinates, coordinates[0]]},
    }
    stops = [
        {
            "type": "Feature",
            "properties": {"order": k, "kind": _kind(k, task), **({} if task is None else {"task": task})},
            "geometry": {"type": "Point", "coordinates": coordinates[k]},
        }
        for k, task in enumerate(tour.tasks)
    ]
    return {"type": "FeatureCollection", "features": [line, *stops]}


def _kind(order: int, task: int | None) -> str:
    return "depot" if order == 0 else "path" if task is None else "task"


def _kml(tour: Tour, positions: Floats) -> str:
    written = [f"{lon:.8f},{lat:.8f},{tour.altitude:g}" for lat, lon in positions.tolist()]
    mode = "<altitudeMode>absolute</altitudeMode>"
    places = "".join(
        f"<Placemark><name>{escape('depot' if k == 0 else f'task {task}')}</name>"
        f"<Point>{mode}<coordinates>{written[k]}</coordinates></Point></Placemark>\n"
        for k, task in enumerate(tour.tasks)
        if k == 0 or task is not None
    )
    line = " ".join([*written, written[0]])
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2"><Document>\n'
        f"<name>{escape(tour.name)}</name>\n<Placemark><name>{escape(tour.name)}</name>"
        f"<LineString>{mode}<coordinates>{line}</coordinates></LineString></Placemark>\n{places}</Document></kml>\n"
    )


def _plan(tour: Tour, positions: Floats, zones: Sequence[Floats]) -> dict[str, Any]:
    home = [*positions[0].tolist(), tour.altitude]
    commands = [(22, home), *((16, [*p, tour.altitude]) for p in positions[1:].tolist()), (16, home), (20, None)]
    items = [_item(number, command, place) for number, (command, place) in enumerate(commands, 1)]
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "geoFence": {
            "version": 2,
            "circles": [],
            "polygons": [{"version": 1, "inclusion": False, "polygon": zone.tolist()} for zone in zones],
        },
        "rallyPoints": {"version": 2, "points": []},
        "mission": {
            "version": 2,
            "firmwareType": 12,  # PX4
            "vehicleType": 1,  # fixed wing
            "cruiseSpeed": tour.speed,
            "hoverSpeed": tour.speed,
            "globalPlanAltitudeMode": 2,  # above mean sea level
            "plannedHomePosition": home,
            "items": items,
        },
    }


def _item(number: int, command: int, place: list[float] | None) -> dict[str, Any]:
    item: dict[str, Any] = {"type": "SimpleItem", "autoContinue": True, "command": command, "doJumpId": number}
    if place is None:  # return to launch
        return item | {"frame": 2, "params": [0, 0, 0, 0, 0, 0, 0]}
    altitude = {"AMSLAltAboveTerrain": None, "Altitude": place[2], "AltitudeMode": 2}
    return item | altitude | {"frame": 0, "params": [0, 0, 0, None, *place]}
