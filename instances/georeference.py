"""Where on Earth a scenario is: how the numbers in its files and lists become metres of its local plane.

A file that states its coordinate reference system is in that. One that states none is in degrees (RFC 7946) where it
could be: a region where `could_be_degrees` says so, others, beside a region on Earth, where they are `within_degrees`.
All other numbers are in the scenario's key ``crs``; "local" there are metres of the plane, and no file is taken for
degrees. Where that key is not given, numbers beside a region in local metres are local metres too; beside a region on
Earth they are degrees if all of them could be, else in the region's own reference system.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry import Polygon

from instances.arrays import Floats
from instances.errors import InputError, shown
from instances.geodesy import WGS84, TangentPlane, in_degrees, to_degrees

LOCAL = "local"
"""The reference system of metres in the local plane."""
SMALLEST_SIDE = 10.0
"""A smaller region whose coordinates could be degrees is taken to be in degrees: no mission fits into 10 m."""
MOST_ACROSS = 500e3
"""Metres across a region; beyond, distances in a plane are wrong by more than a thousandth."""
BEND = 0.1
"""Metres by which an edge, straight in its reference system, may stray from one that is straight in the plane."""
MOST_PIECES = 1000
"""Of one edge."""


@dataclass(frozen=True)
class Georeference:
    """plane : None where the scenario is in local metres alone. crs : its key, or "". region : the region's system."""

    plane: TangentPlane | None = None
    crs: str = ""
    region: str = LOCAL

    def system_of(self, points: ArrayLike) -> str:
        """Return the reference system of the `points` (k, 2) of a list."""
        if self.crs or self.region == LOCAL:
            return self.crs or LOCAL
        return WGS84 if within_degrees(points) else self.region

    def system_of_file(self, points: ArrayLike, stated: str) -> str:
        """Return the reference system of the `points` (k, 2) of a file, which it states or not ("")."""
        degrees = LOCAL not in (self.crs, self.region) and within_degrees(points)
        return stated or (WGS84 if degrees else self.system_of(points))

    def local(self, points: ArrayLike, crs: str) -> Floats:
        """Return `points` (k, 2) of the reference system `crs` in the plane [m]; InputError where they are nowhere."""
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        return p if crs == LOCAL else self.known_plane(crs).local(positions(p, crs))

    def local_polygon(self, polygon: Polygon, crs: str) -> Polygon:
        """Return `polygon` in the plane [m], its edges broken where they would stray by more than BEND."""
        if crs == LOCAL:
            return polygon
        rings = [
            _straight(np.asarray(ring.coords), lambda points: self.local(points, crs))
            for ring in (polygon.exterior, *polygon.interiors)
        ]
        return Polygon(rings[0], rings[1:])

    def known_plane(self, crs: str) -> TangentPlane:
        """Return the plane; InputError where coordinates in `crs` have no place beside local metres."""
        if self.plane is None:
            raise InputError(
                f"coordinates in {shown(crs)} beside a region in local metres: say where on Earth its point (0, 0) is, "
                "origin = [latitude, longitude]"
            )
        return self.plane


def within_degrees(points: ArrayLike) -> bool:
    """Return whether all of `points` (k, 2) could be longitude and latitude."""
    p = np.asarray(points, dtype=float).reshape(-1, 2)
    return bool((np.abs(p) <= (180.0, 90.0)).all())


def could_be_degrees(region: Polygon) -> bool:
    """Return whether a region that states no reference system is taken to be in degrees.

    That is where it is less than SMALLEST_SIDE across, or reaches from one side of the antimeridian to the other.
    """
    x0, y0, x1, y1 = region.bounds
    fits = within_degrees([[x0, y0], [x1, y1]])
    return fits and y1 - y0 < SMALLEST_SIDE and not SMALLEST_SIDE <= x1 - x0 <= 180.0


def positions(points: ArrayLike, crs: str) -> Floats:
    """Return latitude and longitude (k, 2) [degrees] of `points` (k, 2) in `crs`; InputError where they are nowhere."""
    p = np.asarray(points, dtype=float).reshape(-1, 2)
    if in_degrees(crs) and not within_degrees(p):
        wrong = p[int(np.argmax((np.abs(p) > (180.0, 90.0)).any(axis=1)))].tolist()
        raise InputError(f"{wrong} is no [longitude, latitude]: they are at most 180 and 90 degrees, longitude first")
    found = to_degrees(p, crs)
    for i in np.flatnonzero(~np.isfinite(found).all(axis=1)).tolist():
        raise InputError(f"{p[i].tolist()} lies outside of where {shown(crs)} is defined")
    return found


def plane_at(region: Polygon, crs: str, origin: TangentPlane | None) -> TangentPlane:
    """Return `origin`, or the plane at the centre of a region in `crs`; InputError where the region fits into none."""
    p = positions(shapely.get_coordinates(region), crs)
    (south, west), (north, east) = p.min(axis=0).tolist(), p.max(axis=0).tolist()
    spans = f"longitude {west:g} to {east:g}, latitude {south:g} to {north:g}"
    if east - west > 180.0:
        raise InputError(f"region: it spans {spans}: regions across the antimeridian or round a pole are not supported")
    if max(abs(south), abs(north)) > 89.0:
        raise InputError(f"region: it spans {spans}: within a degree of a pole is not supported")
    plane = origin or TangentPlane(round((south + north) / 2, 6), round((west + east) / 2, 6))
    off = np.abs(p - (plane.latitude, plane.longitude)).max()
    across = np.ptp(plane.local(p), axis=0).max() if off < SMALLEST_SIDE else np.inf
    if across > MOST_ACROSS and origin is not None:
        raise InputError(
            f"origin = [{origin.latitude:g}, {origin.longitude:g}] is too far from the region, {spans}: it is "
            "[latitude, longitude]"
        )
    if across > MOST_ACROSS:
        raise InputError(f"region: it spans {spans}: at most {MOST_ACROSS / 1e3:g} km fit into a local plane")
    return plane


def _straight(ring: Floats, local: Callable[[Floats], Floats]) -> Floats:
    """Return a closed ring in the plane, with points between its corners where its edges bend."""
    corners = local(ring)
    middles = local((ring[:-1] + ring[1:]) / 2)
    bend = np.hypot(*(middles - (corners[:-1] + corners[1:]) / 2).T)
    pieces = np.clip(np.ceil(np.sqrt(bend / BEND)), 1, MOST_PIECES).astype(int)
    if pieces.max(initial=1) == 1:
        return corners
    steps = [
        a + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (b - a)
        for a, b, count in zip(ring[:-1], ring[1:], pieces, strict=True)
    ]
    broken = local(np.concatenate(steps))
    return np.concatenate([broken, broken[:1]])
