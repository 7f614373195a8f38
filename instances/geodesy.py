"""From the local plane to latitude and longitude: the tangent plane of WGS 84 at an origin.

A point (x east, y north) [m] of the plane that touches the ellipsoid at the origin has the latitude and longitude of
the foot of its perpendicular on the ellipsoid. PROJ computes both steps: the conversion ``topocentric``, here at height
0, and geocentric to geographic coordinates. Distances in the plane are true to 1e-5 within 20 km of the origin;
altitudes are stated apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.errors import InputError

if TYPE_CHECKING:
    from pyproj import Transformer

A = 6_378_137.0
"""Semi-major axis of WGS 84 [m]."""
FLATTENING = 1 / 298.257223563


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

    @property
    def projection(self) -> str:
        """The azimuthal equidistant projection at the origin, as a PROJ string, for rasters.

        A place of the plane lies in it 0.1 m nearer to the origin at 20 km, 0.3 m at 30 km: d − R atan(d / R).
        """
        return f"+proj=aeqd +lat_0={self.latitude!r} +lon_0={self.longitude!r} +datum=WGS84 +units=m +no_defs"


@cache
def _to_geographic(plane: TangentPlane) -> Transformer:
    from pyproj import Transformer  # here: it takes a tenth of a second, and few commands need it

    return Transformer.from_pipeline(
        "+proj=pipeline"
        f" +step +inv +proj=topocentric +ellps=WGS84 +lat_0={plane.latitude!r} +lon_0={plane.longitude!r}"
        " +step +inv +proj=cart +ellps=WGS84"
        " +step +proj=unitconvert +xy_in=rad +xy_out=deg"
    )
