"""Between the local plane, latitude and longitude, and map projections: the tangent plane of WGS 84 at an origin.

A point (x east, y north) [m] of the plane that touches the ellipsoid at the origin has the latitude and longitude of
the foot of its perpendicular on the ellipsoid. PROJ computes both steps: the conversion ``topocentric``, here at height
0, and geocentric to geographic coordinates. Distances in the plane are true to 1e-5 within 20 km of the origin;
altitudes are stated apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.errors import InputError, shown

if TYPE_CHECKING:
    from pyproj import CRS, Transformer

WGS84 = "EPSG:4326"
"""The coordinate reference system of GPS, KML and GeoJSON; here always longitude first."""


@dataclass(frozen=True)
class TangentPlane:
    """The local plane at `latitude`, `longitude` [degrees] of its origin."""

    latitude: float
    longitude: float

    def __post_init__(self) -> None:
        if not (abs(self.latitude) <= 89.0 and abs(self.longitude) <= 180.0):
            raise InputError(
                f"origin must be [latitude, longitude] in degrees, at most 89 and 180, got "
                f"[{self.latitude}, {self.longitude}]"
            )

    def geographic(self, points: ArrayLike) -> Floats:
        """Return latitude and longitude [degrees] of `points` (k, 2) [m], shape (k, 2)."""
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        longitude, latitude, _ = _to_geographic(self).transform(p[:, 0], p[:, 1], np.zeros(len(p)))
        return np.column_stack([latitude, longitude])

    def local(self, positions: ArrayLike) -> Floats:
        """Return the points (k, 2) [m] of the plane at latitudes and longitudes (k, 2) [degrees].

        The perpendicular of the ellipsoid there meets the plane in the point: `geographic` backwards.
        """
        q = np.asarray(positions, dtype=float).reshape(-1, 2)
        foot, above = (
            np.stack(_to_geographic(self).transform(q[:, 1], q[:, 0], np.full(len(q), height), direction="INVERSE"))
            for height in (0.0, 1.0)
        )
        upwards = above - foot
        return np.asarray((foot - foot[2] / upwards[2] * upwards)[:2].T)

    @property
    def projection(self) -> str:
        """The azimuthal equidistant projection at the origin, as a PROJ string, for rasters.

        A place of the plane lies in it 0.1 m nearer to the origin at 20 km, 0.3 m at 30 km: d − R atan(d / R).
        """
        return f"+proj=aeqd +lat_0={self.latitude!r} +lon_0={self.longitude!r} +datum=WGS84 +units=m +no_defs"


def on_earth(plane: TangentPlane | None, point: ArrayLike) -> str:
    """Return ", longitude …, latitude …" of a `point` (2,) [m] for a sentence; "" where nobody knows where that is."""
    if plane is None:
        return ""
    latitude, longitude = plane.geographic(point)[0]
    return f", longitude {longitude:.5f}, latitude {latitude:.5f}"


@cache
def _to_geographic(plane: TangentPlane) -> Transformer:
    from pyproj import Transformer  # here: it takes a tenth of a second, and few commands need it

    return Transformer.from_pipeline(
        "+proj=pipeline"
        f" +step +inv +proj=topocentric +ellps=WGS84 +lat_0={plane.latitude!r} +lon_0={plane.longitude!r}"
        " +step +inv +proj=cart +ellps=WGS84"
        " +step +proj=unitconvert +xy_in=rad +xy_out=deg"
    )


def reference_system(name: str) -> CRS:
    """Return the coordinate reference system of this name (EPSG code, WKT or PROJ string).

    InputError where it is not known, or its coordinates are neither longitude and latitude nor those of a map.
    """
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    try:
        found = CRS.from_user_input(name)
    except CRSError:
        raise InputError(
            f'crs must be a coordinate reference system such as "EPSG:4326", or "local", got {shown(name)}'
        ) from None
    if not (found.is_geographic or found.is_projected):
        raise InputError(f"crs: {shown(found.name)} is no map: give one in degrees or metres on the ground")
    return found


def grid_mapping(crs: str) -> dict[str, str | float]:
    """Return the attributes of a CF grid mapping that describe the reference system `crs`."""
    return dict(reference_system(crs).to_cf())


def mapped_crs(attributes: Mapping[str, Any]) -> str:
    """Return the reference system that the attributes of a CF grid mapping describe, as WKT, or ""."""
    from pyproj import CRS

    try:
        return str(CRS.from_cf(dict(attributes)).to_wkt())
    except Exception:  # a name it does not know, numbers that are none: PROJ and pyproj raise anything
        return ""


def in_degrees(crs: str) -> bool:
    """Return whether the coordinates of the reference system `crs` are longitude and latitude."""
    return bool(reference_system(crs).is_geographic)


def to_degrees(points: ArrayLike, crs: str) -> Floats:
    """Return latitude and longitude [degrees, WGS 84] of `points` (k, 2) in `crs`, east first; shape (k, 2).

    What lies outside of where the projection is defined is infinite.
    """
    p = np.asarray(points, dtype=float).reshape(-1, 2)
    longitude, latitude = _between(crs, WGS84).transform(p[:, 0], p[:, 1])
    return np.column_stack([latitude, longitude])


def from_degrees(positions: ArrayLike, crs: str) -> Floats:
    """Return the points (k, 2) in `crs`, east first, at latitudes and longitudes (k, 2) [degrees, WGS 84]."""
    q = np.asarray(positions, dtype=float).reshape(-1, 2)
    return np.column_stack(_between(WGS84, crs).transform(q[:, 1], q[:, 0]))


@cache
def _between(one: str, other: str) -> Transformer:
    from pyproj import Transformer
    from pyproj.exceptions import ProjError

    systems = reference_system(one), reference_system(other)
    try:
        return Transformer.from_crs(*systems, always_xy=True)
    except ProjError:  # of another planet
        raise InputError(f"crs: nothing leads from {shown(systems[0].name)} to {shown(systems[1].name)}") from None
