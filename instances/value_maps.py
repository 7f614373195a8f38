"""Files of a ValueMap: how much each place counts, or the prior standard deviation there, as people have it.

* GeoTIFF or NetCDF: its values, bilinear between the nodes. The region must lie within it.
* Polygons with a property ``value`` (GeoJSON, KML, KMZ, GeoPackage, Shapefile): a node of the map takes the value of
  the last polygon in the file that meets its cell; where none lies, `elsewhere`.
* CSV with columns x, y, value [m] or lon, lat, value [degrees]: linear between the points (on their Delaunay
  triangles), beyond their hull the value of the nearest one.

A file that states its reference system is in that. Polygons that state none are in degrees where the place of the local
plane is known and all of them could be, else in metres of the plane. Values are at least 0.
"""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.geometry import Polygon

from instances.arrays import Floats
from instances.disk import read_text
from instances.environment.radio_files import read_field
from instances.environment.region import Region
from instances.environment.site import Site
from instances.environment.value_map import ValueMap
from instances.errors import InputError, naming, shown
from instances.extent import LARGEST
from instances.formats.layers import ENDINGS, LAYER
from instances.geodesy import WGS84
from instances.georeference import LOCAL, Georeference, within_degrees
from instances.places import layer_of

NODES = 401
"""Of a map made from polygons or points, along the longer side of the region."""
RASTERS = (".tif", ".tiff", ".nc")


def read_value_map(path: Path, site: Site, elsewhere: float) -> ValueMap:
    """Read a map over `site` by the ending of its name; InputError names the file, and what is wrong.

    elsewhere : the value where no polygon of a file of polygons lies.
    """
    name = str(path).partition(LAYER)[0]
    ending = Path(name).suffix.lower()
    with naming(name):
        if ending in RASTERS:
            return _of_raster(path, site)
        if ending == ".csv":
            return _of_points(path, site)
        if ending in ENDINGS:
            return _of_polygons(path, site, elsewhere)
        known = ", ".join((*RASTERS, ".csv", *ENDINGS))
        raise InputError(f"a map of values must be a raster, a CSV of points or a file of polygons ({known})")


def _of_raster(path: Path, site: Site) -> ValueMap:
    """Return the nodes of a raster over the region, and those next to it."""
    field = read_field(path, site)
    (x0, y0, x1, y1), (a0, b0, a1, b1) = site.region.bounds, field.bounds
    sx, sy = field.x[1] - field.x[0], field.y[1] - field.y[0]  # nodes may be cell centres: half a cell may be missing
    if x0 < a0 - sx or y0 < b0 - sy or x1 > a1 + sx or y1 > b1 + sy:
        raise InputError(
            f"covers ({a0:g}, {b0:g}) to ({a1:g}, {b1:g}) m and not all of the region, ({x0:g}, {y0:g}) to "
            f"({x1:g}, {y1:g}) m: are both in the same projection and unit?"
        )
    columns, rows = _within(field.x, x0, x1), _within(field.y, y0, y1)
    return ValueMap(field.x[columns], field.y[rows], field.values[rows, columns], field.unit)


def _within(axis: Floats, low: float, high: float) -> slice:
    """Return the nodes of an axis from the last one below `low` to the first one above `high`, at least two."""
    first = int(np.clip(np.searchsorted(axis, low, "right") - 1, 0, len(axis) - 2))
    last = int(np.clip(np.searchsorted(axis, high), first + 1, len(axis) - 1))
    return slice(first, last + 1)


def _axes(region: Region) -> tuple[Floats, Floats]:
    """Return the nodes x and y [m] of a map over the bounding box of `region`, in cells as square as they come."""
    x0, y0, x1, y1 = region.bounds
    cell = max(x1 - x0, y1 - y0) / (NODES - 1)
    counts = [max(2, math.ceil(side / cell - 1e-9) + 1) for side in (x1 - x0, y1 - y0)]
    return np.linspace(x0, x1, counts[0]), np.linspace(y0, y1, counts[1])


def _of_polygons(path: Path, site: Site, elsewhere: float) -> ValueMap:
    layer = layer_of(path, "value", Polygon)
    points = shapely.get_coordinates(layer.parts)
    system = layer.crs or (WGS84 if site.plane is not None and within_degrees(points) else LOCAL)
    reference = Georeference(site.plane)
    xs, ys = _axes(site.region)
    values, touched = np.full((len(ys), len(xs)), elsewhere), False
    dx, dy = (xs[1] - xs[0]) / 2, (ys[1] - ys[0]) / 2
    for number, (part, given) in enumerate(zip(layer.parts, layer.values, strict=True)):
        value = _number(given, f"polygon {number}: its property 'value'")
        assert isinstance(part, Polygon)
        polygon = Region(reference.local_polygon(part, system)).polygon  # it must be valid
        x0, y0, x1, y1 = polygon.bounds
        i, j = np.flatnonzero((xs >= x0 - dx) & (xs <= x1 + dx)), np.flatnonzero((ys >= y0 - dy) & (ys <= y1 + dy))
        if not len(i) or not len(j):
            continue
        x, y = np.meshgrid(xs[i], ys[j])
        met = shapely.intersects(polygon, shapely.box(x - dx, y - dy, x + dx, y + dy))
        values[np.ix_(j, i)] = np.where(met, value, values[np.ix_(j, i)])
        touched |= bool(met.any())
    if not touched:
        raise InputError("none of its polygons meets the region: are both in the same reference system?")
    return ValueMap(xs, ys, values)


def _of_points(path: Path, site: Site) -> ValueMap:
    degrees, rows = _rows(path)
    points = Georeference(site.plane).local(rows[:, :2], WGS84 if degrees else LOCAL)
    x0, y0, x1, y1 = site.region.bounds
    if not ((points >= (x0, y0)) & (points <= (x1, y1))).all(axis=1).any():
        raise InputError(
            f"none of its {len(points)} points lies within ({x0:g}, {y0:g}) to ({x1:g}, {y1:g}) m, where the region is"
        )
    xs, ys = _axes(site.region)
    nodes = np.stack(np.meshgrid(xs, ys), axis=-1)
    return ValueMap(xs, ys, _between(points, rows[:, 2], nodes))


def _between(points: Floats, values: Floats, nodes: Floats) -> Floats:
    """Return `values` of `points` at `nodes` (…, 2), linear on triangles, that of the nearest point beyond them."""
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator  # here: few missions have maps
    from scipy.spatial import QhullError

    nearest = np.asarray(NearestNDInterpolator(points, values)(nodes))
    try:
        linear = np.asarray(LinearNDInterpolator(points, values)(nodes))
    except (QhullError, ValueError):  # fewer than three points, or all on a line
        return nearest
    return np.where(np.isfinite(linear), np.maximum(linear, 0.0), nearest)  # rounding may pass 0


def _rows(path: Path) -> tuple[bool, Floats]:
    """Return whether the first two columns of a CSV are in degrees, and its rows (k, 3)."""
    rows = csv.DictReader(io.StringIO(read_text(path), newline=""))
    found: dict[tuple[float, float], float] = {}
    try:
        columns = [name.strip().lower() for name in rows.fieldnames or ()]
        names = next((names for names in (("x", "y"), ("lon", "lat")) if {*names, "value"} <= {*columns}), None)
        if names is None:
            raise InputError(f"must have columns x, y, value or lon, lat, value, it has {', '.join(columns) or 'none'}")
        rows.fieldnames = columns
        for row in rows:
            line = f"line {rows.line_num}: "
            x, y = (_number(row[name], f"{line}{name}", signed=True) for name in names)
            if (x, y) in found:
                raise InputError(f"{line}the point ({x:g}, {y:g}) is given twice")
            found[x, y] = _number(row["value"], f"{line}value")
    except csv.Error as error:
        raise InputError(f"line {rows.line_num}: {error}") from None
    if not found:
        raise InputError("holds no point")
    return names == ("lon", "lat"), np.array([(*point, value) for point, value in found.items()])


def _number(given: Any, label: str, signed: bool = False) -> float:
    """Return a number of a file; InputError where it is none, too large, or negative and not `signed`."""
    try:
        value = float(given)
    except (TypeError, ValueError):
        value = math.nan
    if isinstance(given, bool) or not abs(value) <= LARGEST or (value < 0 and not signed):
        got = "it is missing" if given is None else f"got {shown(given)}"
        raise InputError(f"{label} must be a number{'' if signed else ' of at least 0'}, {got}")
    return value
