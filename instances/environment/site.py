"""Site: the region of a scenario and where on Earth it is, and how rasters of any projection are brought there.

A raster with a reference system is sampled, bilinear, at the nodes of a grid of the local plane over the region and a
margin, finer than its own: a peak is cut by what the ground falls within a part of a cell. Others are in metres of the
plane already and stay whole. Only then are they judged: a hole that touches the region is an error; what is missing
elsewhere, where nobody flies, is taken from the nearest node that is known. Beyond its border a raster goes on as it
ends, but the region must lie within it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely

from instances.arrays import Floats
from instances.environment.raster import METRES, Raster, bilinear, node_axes
from instances.environment.region import Region
from instances.errors import InputError, naming
from instances.extent import FINEST, LARGEST
from instances.geodesy import TangentPlane, from_degrees, in_degrees, on_earth, reference_system, to_degrees

MARGIN = 0.25
"""Of the region's longer side: what of a raster is kept around the region."""
FINER = 2
"""Nodes of the plane's grid along each cell of the raster, unless that are too many."""
MANY_NODES = 2_000_000
"""Of a grid in the plane that is finer than its raster."""
MOST_NODES = 30_000_000
"""Of any grid in the plane."""
SLACK = 0.51
"""Cells by which a region may reach beyond the outermost nodes: they may be the centres of cells."""
EDGE = 50
"""Points of each side of a raster, or of a region, that say where its border runs in another projection."""


@dataclass(frozen=True, eq=False)
class Site:
    """`region` [m] in the local plane; `plane` is None where nobody says where on Earth that is."""

    region: Region
    plane: TangentPlane | None = None

    def local(self, raster: Raster, path: Path | str, finer: int = FINER) -> Raster:
        """Return `raster` on a grid of the local plane [m], no value missing; InputError names `path`.

        finer : nodes along each of its cells; less where they would be more than MANY_NODES.
        """
        with naming(path), np.errstate(all="ignore"):  # what is nowhere is infinite, and refused
            if raster.crs and self.plane is not None:
                raster = _sampled(raster, self.region, self.plane, finer)
            else:
                check_metres(raster.crs)
            return _filled(raster, self)

    def axes_east(self, nodes: Floats, crs: str) -> Floats:
        """Return the unit vectors (k, 2) in the plane that point along the first axis of `crs` at `nodes` (k, 2) [m].

        They are turned against the plane's by the convergence of the meridians, and of a projection's grid.
        """
        if not crs or self.plane is None:
            return np.tile([1.0, 0.0], (len(nodes), 1))
        here = from_degrees(self.plane.geographic(nodes), crs)
        step = np.array([1e-4 if in_degrees(crs) else 10.0, 0.0])
        along = self.plane.local(to_degrees(here + step, crs)) - self.plane.local(to_degrees(here - step, crs))
        return np.asarray(along / np.hypot(*along.T)[:, None])


def check_metres(crs: str) -> None:
    """Raise InputError where a raster is not in metres."""
    if not crs:
        return
    try:
        system = reference_system(crs)
    except InputError:
        return  # a name of others for a projection: only compared
    if system.is_geographic:
        raise InputError(
            f"the raster is in degrees ({system.name}); project it to metres first, or say where on Earth the region "
            "is: a region in degrees, or origin = [latitude, longitude]"
        )
    unit = system.axis_info[0].unit_name
    if unit.lower() not in METRES:
        raise InputError(f"the raster's coordinates are in {unit}, not in metres")


def _sampled(raster: Raster, region: Region, plane: TangentPlane, finer: int) -> Raster:
    """Return `raster` on a grid of the plane over the region and a margin; InputError where it does not cover it."""

    def cells(points: Floats) -> Floats:
        """Columns and rows (k, 2) of the raster at points of the plane."""
        p = from_degrees(plane.geographic(points), raster.crs)
        if in_degrees(raster.crs):  # some count longitudes from 0 to 360
            west = raster.origin[0] - SLACK * raster.spacing[0]
            p[:, 0] = west + (p[:, 0] - west) % 360.0
        return (p - raster.origin) / raster.spacing

    def points(cells: Floats) -> Floats:
        return plane.local(to_degrees(raster.origin + cells * raster.spacing, raster.crs))

    rows, columns = raster.values.shape
    if min(rows, columns) < 2 or not min(raster.spacing) >= FINEST:
        raise InputError(f"must hold a grid of at least 2 × 2 nodes, it holds {columns} × {rows}")
    _check_covered(raster, region, plane, cells)
    x0, y0, x1, y1 = region.bounds
    reach = MARGIN * max(x1 - x0, y1 - y0)
    edge = points(_sides(-0.5, -0.5, columns - 0.5, rows - 0.5))
    edge = edge[np.isfinite(edge).all(axis=1)]  # parts of a raster of the Earth are nowhere in the plane
    lower = np.fmax(np.array([x0, y0]) - reach, edge.min(axis=0, initial=np.inf))
    upper = np.fmin(np.array([x1, y1]) + reach, edge.max(axis=0, initial=-np.inf))
    centre = cells(np.array([[(x0 + x1) / 2, (y0 + y1) / 2]]))
    steps = points(np.add(centre, [[0, 0], [1, 0], [0, 1]]))
    cell = np.hypot(*(steps[1:] - steps[0]).T)
    if not (np.isfinite([*cell, *lower, *upper]).all() and (upper > lower).all() and (cell >= FINEST).all()):
        raise InputError("its grid cannot be brought to the region")
    fitting = int(np.sqrt(MANY_NODES / np.prod((upper - lower) / cell)))
    dx, dy = (cell / max(1, min(finer, fitting))).tolist()
    nx, ny = (np.ceil((upper - lower) / (dx, dy)) + 1).astype(int).tolist()
    if nx * ny > MOST_NODES:
        raise InputError(f"{nx} × {ny} nodes over the region are more than can be used; resample it")
    x, y = node_axes((float(lower[0]), float(lower[1])), (dx, dy), (ny, nx))
    at = cells(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    values = bilinear(raster.values, at[:, 0], at[:, 1]).reshape(ny, nx)
    return Raster((float(x[0]), float(y[0])), (dx, dy), values, plane.projection, raster.unit)


def _check_covered(raster: Raster, region: Region, plane: TangentPlane, cells: Callable[[Floats], Floats]) -> None:
    """Raise InputError where the region does not lie within `raster`."""
    border = np.concatenate([_along(ring) for ring in region.rings])
    rows, columns = raster.values.shape
    at = cells(border)
    if not (at >= -SLACK).all() or not (at <= np.array([columns, rows]) - 1 + SLACK).all():
        ends = raster.origin + np.array([[0, 0], [columns - 1, rows - 1]]) * raster.spacing
        (s0, w0), (s1, w1) = to_degrees(ends, raster.crs).tolist()
        (south, west), (north, east) = np.sort([*plane.geographic(border)], axis=0)[[0, -1]].tolist()
        raise InputError(
            f"covers longitude {w0:.4f} to {w1:.4f}, latitude {s0:.4f} to {s1:.4f} and not all of the region, "
            f"longitude {west:.4f} to {east:.4f}, latitude {south:.4f} to {north:.4f}"
        )


def _along(ring: Floats) -> Floats:
    """Return points of a ring, its corners among them."""
    line = shapely.linestrings(ring)
    return np.asarray(shapely.get_coordinates(shapely.segmentize(line, shapely.length(line) / (4 * EDGE))))


def _sides(x0: float, y0: float, x1: float, y1: float) -> Floats:
    """Return points of the border of a rectangle, its corners among them."""
    return _along(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]))


def _filled(raster: Raster, site: Site) -> Raster:
    """Return `raster` without holes; InputError where one touches the region."""
    missing = ~(np.abs(raster.values) <= LARGEST)
    if not missing.any():
        return raster
    x, y = node_axes(raster.origin, raster.spacing, raster.values.shape)
    j, i = np.nonzero(missing)
    holes = np.column_stack([x[i], y[j]])
    touching = shapely.dwithin(site.region.polygon, shapely.points(holes), float(np.hypot(*raster.spacing)))
    if touching.any():
        first = holes[np.argmax(touching)]
        where = f"({first[0]:g}, {first[1]:g}) m{on_earth(site.plane, first)}"
        raise InputError(
            f"{int(touching.sum())} values in the region are missing (NaN or no data), first at {where}; fill "
            "the holes first"
        )
    from scipy.ndimage import distance_transform_edt  # here: it takes its time, and few rasters have holes

    near = distance_transform_edt(missing, sampling=raster.spacing[::-1], return_distances=False, return_indices=True)
    return replace(raster, values=raster.values[tuple(near)])
