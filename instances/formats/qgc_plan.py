"""QGroundControl's ``.plan``: mission items, geofence and rally point as JSON.

The format is that of QGroundControl's developer guide, Plan File Format
(https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html): home's altitude is above mean sea
level, a rally point's above home; the corners of a fence go clockwise. ``AltitudeMode`` is 1 above home, 2 above mean
sea level, 3 above mean sea level made from a height above the ground, 4 above the ground; 0 in
``globalPlanAltitudeMode`` says that the items differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.polygon import orient

from instances.arrays import Floats
from instances.formats.mavlink_items import ABOVE_GROUND, ABOVE_HOME, AMSL, FIRMWARE, KINDS, Item, Vehicle
from instances.formats.tour import Tour
from instances.geodesy import TangentPlane

MIXED, RELATIVE, ABSOLUTE, CALCULATED, TERRAIN = range(5)
MODE = {AMSL: ABSOLUTE, ABOVE_HOME: RELATIVE, ABOVE_GROUND: TERRAIN}


def plan(
    tour: Tour, home: Floats, items: Sequence[Item], climb: float | None, vehicle: Vehicle, fence: dict[str, Any]
) -> dict[str, Any]:
    """Return the plan of `tour` from `home` (latitude, longitude).

    climb : height of the rally point over home [m]; None: none is written, and a vehicle that returns comes home.
    """
    written = [_item(number, item) for number, item in enumerate(items, 1)]
    modes = {item["AltitudeMode"] for item in written if "AltitudeMode" in item}
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "geoFence": fence,
        "rallyPoints": {"version": 2, "points": [] if climb is None else [[*home.tolist(), climb]]},
        "mission": {
            "version": 2,
            "firmwareType": FIRMWARE[vehicle.firmware],
            "vehicleType": KINDS[vehicle.kind],
            "cruiseSpeed": tour.speed,
            "hoverSpeed": tour.speed,
            "globalPlanAltitudeMode": modes.pop() if len(modes) == 1 else MIXED,
            "plannedHomePosition": [*home.tolist(), tour.home],
            "items": written,
        },
    }


def _item(number: int, item: Item) -> dict[str, Any]:
    place = (0.0, 0.0) if item.place is None else item.place
    written = {
        "type": "SimpleItem",
        "autoContinue": True,
        "command": item.command,
        "doJumpId": number,
        "frame": item.frame,
        "params": [*item.params, *place, item.height],
    }
    if item.place is None:
        return written
    if item.above_ground is None:
        return written | {"AltitudeMode": MODE[item.frame], "Altitude": item.height, "AMSLAltAboveTerrain": None}
    return written | {"AltitudeMode": CALCULATED, "Altitude": item.above_ground, "AMSLAltAboveTerrain": item.height}


def fence(plane: TangentPlane, region: Polygon | None, no_fly: Sequence[Polygon], digits: int) -> dict[str, Any]:
    """Return the geofence: inside `region`, outside `no_fly` and the region's holes; holes of `no_fly` stay closed."""
    inside = [] if region is None else [(True, region)]
    holes = [] if region is None else [Polygon(ring) for ring in region.interiors]
    polygons = [*inside, *((False, zone) for zone in (*holes, *no_fly))]
    return {
        "version": 2,
        "circles": [],
        "polygons": [
            {"version": 1, "inclusion": inclusion, "polygon": _corners(plane, polygon, digits)}
            for inclusion, polygon in polygons
        ],
    }


def _corners(plane: TangentPlane, polygon: Polygon, digits: int) -> list[list[float]]:
    """Return latitude and longitude of the outer corners, clockwise, the first not repeated."""
    ring = np.asarray(orient(polygon, -1.0).exterior.coords)[:-1, :2]
    corners: list[list[float]] = plane.geographic(ring).round(digits).tolist()
    return corners
