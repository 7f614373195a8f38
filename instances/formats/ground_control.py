"""Tours for ground-control software, chosen by the ending: GeoJSON, KML, QGroundControl's ``.plan``, ``.waypoints``.

Coordinates are WGS 84, of the tangent plane at the mission's origin (`instances.geodesy`).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from shapely.geometry import LineString, Point, Polygon

from instances.disk import write_aside
from instances.formats.geojson import DIGITS, Features, write_features
from instances.formats.kml import kml
from instances.formats.mavlink_items import Vehicle, mission_items
from instances.formats.qgc_plan import fence, plan
from instances.formats.tour import Tour
from instances.formats.waypoints import waypoints
from instances.geodesy import TangentPlane

ENDINGS = (".plan", ".waypoints", ".kml", ".geojson")


def write_tour(
    tour: Tour,
    plane: TangentPlane,
    path: Path | str,
    *,
    frame: str = "amsl",
    vehicle: Vehicle | None = None,
    region: Polygon | None = None,
    no_fly: Sequence[Polygon] = (),
) -> None:
    """Write `tour` in the format of the ending of `path`.

    frame : one of `tour.FRAMES`, what the heights are above. vehicle : PX4, fixed wing, unless given.
    region, no_fly : where must be flown and where must not [m]; only a .plan carries them.
    """
    path, vehicle = Path(path), vehicle or Vehicle()
    positions = plane.geographic(tour.points).round(DIGITS)
    if path.suffix == ".geojson":
        write_features(_features(tour), plane, path)
        return
    if path.suffix == ".kml":
        text = kml(tour, positions, frame)
    else:
        items = mission_items(tour, positions, frame, vehicle)
        if path.suffix == ".waypoints":
            text = waypoints(tour, positions[0], items, vehicle)
        else:
            fences = fence(plane, region, no_fly, DIGITS)
            text = json.dumps(plan(tour, positions[0], items, tour.climb(frame), vehicle, fences), indent=1)
    write_aside(path, text)


def _features(tour: Tour) -> Features:
    """Return a line of the whole tour, then its waypoints in flying order."""
    heights = [round(height, 2) for height in tour.heights.tolist()]
    about = {"name": tour.name, "speed": tour.speed, "altitudes": [*heights, heights[0]]}
    yield LineString(np.vstack([tour.points, tour.points[:1]])), about
    for k, (point, task) in enumerate(zip(tour.points, tour.tasks, strict=True)):
        number = {} if task is None else {"task": task}
        yield Point(point), {"order": k, "kind": _kind(k, task), "altitude": heights[k]} | number


def _kind(order: int, task: int | None) -> str:
    return "depot" if order == 0 else "path" if task is None else "task"
