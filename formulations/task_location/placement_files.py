"""Placements to files: points as GeoJSON or CSV, everything as JSON.

GeoJSON is in degrees (RFC 7946) where the place of the local plane is known, else in local metres.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from shapely.geometry import Point

from formulations.task_location.placement import Placement
from instances.disk import write_aside
from instances.formats.geojson import write_features
from instances.geodesy import TangentPlane

ENDINGS = (".geojson", ".json", ".csv")


def write_placement(placement: Placement, path: Path, plane: TangentPlane | None = None) -> None:
    """Write the points as GeoJSON, everything as JSON, or x, y as CSV, by the ending of `path`."""
    if path.suffix == ".geojson" and plane is not None:
        points = placement.points
        write_features(((Point(point), {"task": i}) for i, point in enumerate(points)), plane, path)
        return
    if path.suffix == ".csv":
        text = "x,y\n" + "".join(f"{x!r},{y!r}\n" for x, y in placement.points.tolist())
    elif path.suffix == ".geojson":
        text = json.dumps(geojson(placement))
    else:
        text = json.dumps(placement.as_dict())
    write_aside(path, text)


def geojson(placement: Placement) -> dict[str, Any]:
    """Return the tasks as a FeatureCollection of points in local metres, numbered from 0."""
    features = [
        {"type": "Feature", "properties": {"task": i}, "geometry": {"type": "Point", "coordinates": point}}
        for i, point in enumerate(placement.points.tolist())
    ]
    return {"type": "FeatureCollection", "features": features}
