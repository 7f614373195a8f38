"""The places of a scenario, as people have them: region, no-fly zones, depots and tasks, in metres of the local plane.

region = "area.kml"                      # or .kmz, .geojson, .gpkg, .shp, .zip (a Shapefile), or size = [x, y] [m]
no_fly = "zones.gpkg|layername=zones"    # a layer (a KML folder) where the file has several
depots = [[-84.2, 36.6], ...]            # longitude, latitude; or "depots.kml", its points
tasks = "tasks.geojson"                  # its points; or a list, or how many are to be placed
crs = "EPSG:4326"                        # of lists, and of files that state none (`instances.georeference`)
origin = [36.6, -84.2]                   # latitude, longitude of (0, 0); the region's centre unless given
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.geometry import Point, Polygon
from shapely.geometry.base import BaseGeometry

from instances.arrays import Floats
from instances.declared.scenario import ScenarioKeys
from instances.declared.types import Pair
from instances.environment.region import Region, only
from instances.errors import InputError, naming, shown, suggestion
from instances.extent import FARTHEST
from instances.formats.layers import ENDINGS, LAYER, Layer, read_layers
from instances.geodesy import WGS84, TangentPlane, reference_system
from instances.georeference import LOCAL, Georeference, could_be_degrees, plane_at, positions

NEAR = 0.1
"""Degrees around a region beyond which no-fly zones are left out: files of them may span the Earth."""


@dataclass(frozen=True, eq=False)
class Places:
    """Region, no-fly zones and points [m]; `plane` is None where they are in local metres alone.

    depots and tasks are as given where they were local metres, which the Scenario checks; `tasks` is None or a number
    where they are to be placed.
    """

    region: Region
    no_fly: tuple[Polygon, ...]
    depots: Any
    tasks: Any
    reference: Georeference


def read_places(said: ScenarioKeys, folder: Path) -> Places:
    """Return the places that a scenario names, its files relative to `folder`; InputError names the key."""
    crs = said.crs or ""
    if said.crs is not None and crs != LOCAL:
        reference_system(crs)
    origin = None if said.origin is None else TangentPlane(*said.origin)
    if said.size is None:
        region, reference = read_region(folder / str(said.region), crs, origin)
    else:
        region, reference = Region.rectangle(*said.size), Georeference(origin, crs)
    depots, tasks = (
        _points_of(value, key, folder, region, reference)
        for key, value in (("depots", said.depots), ("tasks", said.tasks))
    )
    return Places(region, read_zones(said.no_fly, folder, region, reference), depots, tasks, reference)


def read_region(path: Path, crs: str = "", origin: TangentPlane | None = None) -> tuple[Region, Georeference]:
    """Read a region's file, whose numbers are in `crs` where it states none; InputError names it and what is wrong."""
    with naming(_file_of(path)):
        layer = layer_of(path, "region", Polygon)
        polygon = Region(only(layer.parts)).polygon  # type: ignore[arg-type]  # valid where it is given
        degrees = crs != LOCAL and could_be_degrees(polygon)
        system = layer.crs or (WGS84 if degrees else crs or LOCAL)
        if system == LOCAL:
            return Region(polygon), Georeference(origin, crs)
        reference = Georeference(plane_at(polygon, system, origin), crs, system)
        return Region(reference.local_polygon(polygon, system)), reference


def local_pair(value: Pair, label: str, places: Places) -> Pair:
    """Return a place of the table in the plane; what is nowhere, or in local metres, as it is given.

    It may lie outside of the region, but not where the other way round it would lie inside.
    """
    reference = places.reference
    system = reference.system_of(value) if _is_place(value) else LOCAL
    if system == LOCAL:
        return value
    with naming(label):
        outside = not _inside(value, system, places.region, reference)
        if outside and _inside(value[::-1], system, places.region, reference):
            raise InputError(f"{[*value]} lies outside the region, the other way round inside; longitude comes first")
        x, y = reference.local(value, system)[0].tolist()
        return x, y


def layer_of(path: Path, key: str, kind: type[BaseGeometry]) -> Layer:
    """Return what a file holds of one kind of geometry: of the layer its name asks for, or the only one that has some.

    Where several layers have some, that with the name of `key`; InputError where there is none or it cannot be told.
    """
    name, asked, wanted = str(path).partition(LAYER)
    what = kind.__name__.lower()
    if not name.lower().endswith(ENDINGS):
        raise InputError(f"{key}: must be a file of places ({', '.join(ENDINGS)})")
    layers = read_layers(Path(name))
    if asked and wanted not in [layer.name for layer in layers]:
        known = [layer.name for layer in layers]
        raise InputError(f"there is no layer {shown(wanted)}{suggestion(wanted, known)} (layers: {', '.join(known)})")
    kept = [layer for layer in layers if not asked or layer.name == wanted]
    found = [layer for layer in (layer.of(kind) for layer in kept) if layer.parts]
    if not found:
        held = sorted({part.geom_type for layer in kept for part in layer.parts})
        raise InputError(f"{key}: must hold a {what}, it holds {', '.join(held) or 'nothing'}")
    named = [layer for layer in found if _plain(layer.name) == _plain(key)]
    if len(found) > 1 and len(named) != 1:
        raise InputError(
            f"{key}: holds {what}s in several layers ({', '.join(layer.name for layer in found)}): name one, "
            f'{key} = "{Path(name).name}{LAYER}{found[0].name}"'
        )
    return found[0] if len(found) == 1 else named[0]


def _file_of(path: Path) -> str:
    """Return the name of the file that `path` names a layer of."""
    return str(path).partition(LAYER)[0]


def _plain(name: str) -> str:
    return "".join(c for c in name.lower() if c.isalnum())


def read_zones(file: str | None, folder: Path, region: Region, reference: Georeference) -> tuple[Polygon, ...]:
    """Return the no-fly zones [m] of a file, none where none is named; InputError names it and what is wrong."""
    if file is None:
        return ()
    path = folder / file
    with naming(_file_of(path)):
        layer = layer_of(path, "no_fly", Polygon)
        system = reference.system_of_file(shapely.get_coordinates(layer.parts), layer.crs)
        zones = [zone for zone in layer.parts if isinstance(zone, Polygon)]
        for zone in zones:
            Region(zone)  # each must be valid
        if system == LOCAL:
            return tuple(zones)
        plane = reference.known_plane(system)
        near = shapely.box(*_bounds_in_degrees(region, plane)).buffer(NEAR)
        kept = [z for z in zones if near.intersects(shapely.box(*_box(positions(shapely.get_coordinates(z), system))))]
        return tuple(reference.local_polygon(zone, system) for zone in kept)


def _points_of(value: Any, key: str, folder: Path, region: Region, reference: Georeference) -> Any:
    """Return the points under `key`: of a file or a list, in the plane; what else is there as it is."""
    if isinstance(value, str):
        path = folder / value
        with naming(_file_of(path)):
            layer = layer_of(path, key, Point)
            points = shapely.get_coordinates(layer.parts)
            return _local_points(points, key, reference.system_of_file(points, layer.crs), region, reference)
    if not isinstance(value, list) or not all(map(_is_place, value)):
        return value
    system = reference.system_of(value)
    if system == LOCAL:
        return value
    return _local_points(np.array(value, dtype=float), key, system, region, reference)


def _local_points(points: Floats, key: str, system: str, region: Region, reference: Georeference) -> Floats:
    """Return `points` of a reference system in the plane; InputError names one outside the region, as it was given."""
    if system == LOCAL:
        return points
    plane = reference.known_plane(system)
    for i, point in enumerate(points.tolist()):
        if not _inside(point, system, region, reference):
            west, south, east, north = _bounds_in_degrees(region, plane)
            swapped = _inside(point[::-1], system, region, reference)
            raise InputError(
                f"{key}[{i}] = {point} ({shown(system)}) lies outside the region, longitude {west:.5f} to {east:.5f}, "
                f"latitude {south:.5f} to {north:.5f}"
                + (": the other way round it lies inside; longitude comes first" if swapped else "")
            )
    return reference.local(points, system)


def _inside(point: Sequence[float], system: str, region: Region, reference: Georeference) -> bool:
    try:
        return bool(region.contains(reference.local(point, system))[0])
    except InputError:  # nowhere
        return False


def _bounds_in_degrees(region: Region, plane: TangentPlane) -> tuple[float, float, float, float]:
    return _box(plane.geographic(shapely.get_coordinates(region.polygon)))


def _box(found: Floats) -> tuple[float, float, float, float]:
    """Return west, south, east and north of latitudes and longitudes (k, 2)."""
    (south, west), (north, east) = found.min(axis=0).tolist(), found.max(axis=0).tolist()
    return west, south, east, north


def _is_place(point: Pair) -> bool:
    return all(abs(c) <= FARTHEST for c in point)
