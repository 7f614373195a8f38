"""Placements to files: points as GeoJSON or CSV, everything as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from formulations.task_location.placement import Placement
from instances.disk import write_aside

ENDINGS = (".geojson", ".json", ".csv")


def write_placement(placement: Placement, path: Path) -> None:
    """Write the points as GeoJSON, everything as JSON, or x, y as CSV, by the ending of `path`."""
    if path.suffix == ".csv":
        text = "x,y\n" + "".join(f"{x!r},{y!r}\n" for x, y in placement.points.tolist())
    elif path.suffix == ".geojson":
        text = json.dumps(geojson(placement))
    else:
        text = json.dumps(placement.as_dict())
    write_aside(path, text)


def geojson(placement: Placement) -> dict[str, Any]:
    """Return the tasks as a FeatureCollection of points, numbered from 0."""
    features = [
        {"type": "Feature", "properties": {"task": i}, "geometry": {"type": "Point", "coordinates": point}}
        for i, point in enumerate(placement.points.tolist())
    ]
    return {"type": "FeatureCollection", "features": features}
