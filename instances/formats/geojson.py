"""GeoJSON by RFC 7946: WGS 84, longitude first, exterior rings counter-clockwise, no ``crs``.

Positions have no third element: there it is the height above the ellipsoid, which differs from one above mean sea level
by up to 100 m; heights are properties, and say above what they are. What is read may also be in another reference
system, as GeoJSON of 2008 allowed; heights in it are not used.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import shapely
from shapely import transform
from shapely.geometry import Polygon, mapping, shape
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from instances.arrays import Floats
from instances.disk import write_aside
from instances.errors import InputError, shown
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


def parts_of(data: Any) -> Iterator[BaseGeometry]:
    """Return every point, line and polygon in GeoJSON `data` (geometry, Feature or FeatureCollection)."""
    return (part for part, _ in valued_parts_of(data))


def valued_parts_of(data: Any, value: Any = None) -> Iterator[tuple[BaseGeometry, Any]]:
    """Return `parts_of`, each with the property ``value`` of its feature; `value` where it has none."""
    kind = data.get("type") if isinstance(data, dict) else None
    if kind == "FeatureCollection":
        features = data.get("features")
        if not isinstance(features, list):
            raise InputError("GeoJSON: a FeatureCollection must hold a list of features")
        for feature in features:
            yield from valued_parts_of(feature)
        return
    if kind == "Feature":
        if data.get("geometry") is not None:  # a feature may be without a place
            properties = data.get("properties")
            own = properties.get("value") if isinstance(properties, dict) else None
            yield from valued_parts_of(data["geometry"], own)
        return
    try:
        yield from ((part, value) for part in single_parts(shape(data)))
    except (ValueError, TypeError, LookupError, AttributeError, OverflowError, shapely.errors.ShapelyError) as error:
        raise InputError(f"GeoJSON of type {shown(kind)} cannot be read ({error})") from None


def crs_of(data: Any) -> str:
    """Return the reference system that GeoJSON of 2008 names, or ""."""
    try:
        return str(data["crs"]["properties"]["name"])
    except (LookupError, TypeError):
        return ""


def single_parts(geometry: BaseGeometry | None) -> list[BaseGeometry]:
    """Return what a geometry or a collection of them holds, without heights; nothing of what is empty."""
    if geometry is None or geometry.is_empty:
        return []
    if hasattr(geometry, "geoms"):
        return [part for each in geometry.geoms for part in single_parts(each)]
    return [shapely.force_2d(geometry)]
