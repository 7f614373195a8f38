"""Rasters as GeoTIFF in the mission's local map projection (extra ``geo``), for geographic information systems."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from instances.arrays import Floats
from instances.disk import write_aside
from instances.environment.raster import geo
from instances.geodesy import TangentPlane


def write_geotiff(
    path: Path | str, values: Floats, x: Floats, y: Floats, plane: TangentPlane, *, name: str, unit: str
) -> None:
    """Write `values` (ny, nx) at the cell centres x, y [m], equally spaced and rising; NaN is no data.

    InputError without the extra ``geo``.
    """
    path = Path(path)
    rasterio = geo("rasterio", path, "writing GeoTIFF")
    dx, dy = x[1] - x[0], y[1] - y[0]
    corner = rasterio.transform.from_origin(x[0] - dx / 2, y[-1] + dy / 2, dx, dy)  # rows go south
    shape = {"height": len(y), "width": len(x), "count": 1, "dtype": "float32"}
    with rasterio.MemoryFile() as memory:
        where = {"crs": plane.projection, "transform": corner, "nodata": np.nan}
        with memory.open(driver="GTiff", compress="deflate", **shape, **where) as data:
            data.write(values[::-1].astype(np.float32), 1)
            data.set_band_description(1, name)
            data.units = (unit,)
        content = memory.read()
    write_aside(path, content)
