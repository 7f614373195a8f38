"""GeoJSON by RFC 7946: WGS 84, longitude first, exterior rings counter-clockwise, no ``crs``.

Positions have no third element: there it is the height above the ellipsoid, which differs from one above mean sea level
by up to 100 m; heights are properties, and say above what they are.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from shapely import transform
from shapely.geometry import Polygon, mapping
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from instances.arrays import Floats
from instances.disk import write_aside
from instances.geodesy import TangentPlane

DIGITS = 8
"""Digits of a degree that are written: 1 mm."""

Features = Iterable[tuple[BaseGeometry, Mapping[str, Any]]]
"""Geometries in the local plane [m], each with its properties."""


def write_features(features: Features, plane: TangentPlane, path: Path | str) -> None:
    """Write `features` of the local plane as a FeatureCollection in degrees."""

    def degrees(points: Floats) -> Floats:
        return plane.geographic(points)[:, ::-1].round(DIGITS)

    written = []
    for geometry, properties in features:
        turned = orient(geometry) if isinstance(geometry, Polygon) else geometry
        placed = mapping(transform(turned, degrees))
        written.append({"type": "Feature", "properties": dict(properties), "geometry": placed})
    write_aside(path, json.dumps({"type": "FeatureCollection", "features": written}))
