"""Region: the bounded, possibly non-convex area A that is surveyed, with holes (no-fly zones).

Coordinates are metres in a local plane, x east and y north; files are read by `instances.places`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry import Polygon, mapping
from shapely.ops import nearest_points
from shapely.validation import explain_validity

from instances.arrays import Bools, Floats
from instances.disk import write_aside
from instances.errors import InputError
from instances.extent import check_positions
from instances.formats.geojson import parts_of

LEAST_SHARE = 1e-6
"""Of its bounding box that a region must fill for points to be drawn in it: one try in a million succeeds."""


@dataclass(frozen=True, eq=False)
class Region:
    """A polygon with holes.

    Parameters
    ----------
    polygon
        In metres of the local plane, valid and with a non-empty interior.

    Raises
    ------
    InputError
        Where it is not.
    """

    polygon: Polygon

    def __post_init__(self) -> None:
        if not isinstance(self.polygon, Polygon):
            raise InputError(f"region: must be one polygon, got {self.polygon.geom_type}")
        check_positions(shapely.get_coordinates(self.polygon), "region: coordinates")
        if not self.polygon.is_valid:
            raise InputError(f"region: the polygon is not valid: {explain_validity(self.polygon)}")
        if not self.polygon.area > 0:
            raise InputError("region: the polygon has an empty interior")
        shapely.prepare(self.polygon)

    @classmethod
    def rectangle(cls, width: float, height: float) -> Region:
        """Return the rectangle of `width` × `height` [m] with its lower left corner at the origin."""
        if not (width > 0 and height > 0):
            raise InputError(f"region: size must be positive [m], got [{width}, {height}]")
        return cls(shapely.box(0.0, 0.0, width, height))

    def write(self, path: Path | str) -> None:
        """Write the region as a GeoJSON feature; every coordinate reads back as the same float64."""
        feature = {"type": "Feature", "properties": {}, "geometry": mapping(self.polygon)}
        write_aside(path, json.dumps(feature))

    def minus(self, zones: list[Polygon]) -> Region:
        """Return the region without `zones` (no-fly zones); InputError where that leaves no single polygon."""
        parts = self.parts_without(zones)
        if len(parts) != 1:
            raise InputError("region: the no-fly zones cut it into parts or leave nothing of it")
        return parts[0]

    def parts_without(self, zones: list[Polygon]) -> list[Region]:
        """Return the parts that `zones` (no-fly zones) leave of the region; InputError for a zone that is not valid."""
        for zone in zones:
            if not zone.is_valid:
                raise InputError(f"region: a no-fly zone is not valid: {explain_validity(zone)}")
        rest = self.polygon.difference(shapely.union_all(zones)) if zones else self.polygon
        return [Region(part) for part in shapely.get_parts(rest) if isinstance(part, Polygon) and part.area > 0]

    @property
    def area(self) -> float:
        """Area [m²]."""
        return float(self.polygon.area)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max [m]."""
        x0, y0, x1, y1 = self.polygon.bounds
        return float(x0), float(y0), float(x1), float(y1)

    @cached_property
    def rings(self) -> list[Floats]:
        """Outer ring, then holes; each closed, shape (k, 2) [m]."""
        return [np.asarray(r.coords)[:, :2] for r in (self.polygon.exterior, *self.polygon.interiors)]

    def contains(self, points: ArrayLike) -> Bools:
        """Return which of `points` (k, 2) [m] lie inside or on the border, shape (k,)."""
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        return np.asarray(shapely.intersects_xy(self.polygon, *p.T), dtype=bool)  # a tenth of the time points take

    def signed_distance(self, points: ArrayLike) -> Floats:
        """Return the distance to the border [m], positive inside and negative outside, shape (k,)."""
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        d = np.asarray(shapely.distance(self.polygon.boundary, shapely.points(p)))
        return np.where(self.contains(p), d, -d)

    def snap(self, points: ArrayLike) -> Floats:
        """Return `points` (k, 2) [m] with those outside moved to the nearest point of the region (up to rounding)."""
        p = np.array(points, dtype=float).reshape(-1, 2)
        for i in np.flatnonzero(~self.contains(p)):
            near, _ = nearest_points(self.polygon, shapely.Point(p[i]))
            p[i] = near.x, near.y
        return p

    def sample(self, count: int, rng: np.random.Generator) -> Floats:
        """Return points uniform in the region.

        Parameters
        ----------
        count
            How many.
        rng
            Where they are drawn from.

        Returns
        -------
        numpy.ndarray
            Shape (count, 2) [m].

        Raises
        ------
        InputError
            Where the region fills less than a millionth of its bounding box.
        """
        x0, y0, x1, y1 = self.bounds
        if self.area < LEAST_SHARE * (x1 - x0) * (y1 - y0):
            raise InputError(f"region: it is too thin to draw points in, {self.area:g} m² in all")
        # thin regions need many tries a point; a million at a time keeps the memory small
        size = int(min(2 * count * (x1 - x0) * (y1 - y0) / self.area + 16, 1e6))
        found = np.empty((0, 2))
        while len(found) < count:
            p = rng.uniform((x0, y0), (x1, y1), (size, 2))
            found = np.concatenate([found, p[self.contains(p)]])
        return found[:count]

    def cell_centres(self, columns: int, rows: int) -> Floats:
        """Return the centres of columns × rows equal cells of the bounding box, those inside, shape (k, 2) [m]."""
        x0, y0, x1, y1 = self.bounds
        xs = x0 + (np.arange(columns) + 0.5) * (x1 - x0) / columns
        ys = y0 + (np.arange(rows) + 0.5) * (y1 - y0) / rows
        grid = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
        return grid[self.contains(grid)]


def single_polygon(data: Any) -> Polygon:
    """Return the one polygon in GeoJSON `data`."""
    return only([part for part in parts_of(data) if isinstance(part, Polygon)])


def only(found: Sequence[Polygon]) -> Polygon:
    """Return the one polygon that `found` are, those side by side made one; InputError for any other number."""
    if len(found) > 1 and all(polygon.is_valid for polygon in found):
        united = shapely.union_all(list(found))
        beside = united.area > (1 - 1e-6) * sum(polygon.area for polygon in found)  # one inside another may be a hole
        if isinstance(united, Polygon) and beside:
            return united
    if len(found) != 1:
        raise InputError(f"must hold one polygon, got {len(found)}")
    return found[0]
