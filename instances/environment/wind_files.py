"""Wind grids from files: CF NetCDF (extra ``geo``) and WindNinja's ASCII grids.

NetCDF follows the CF conventions: wind components are found by ``standard_name`` (eastward_wind, x_wind, …) or by
their usual names (ERA5, WRF, …), in m/s, on one-dimensional x and y in metres of a map projection.
WindNinja writes ESRI ASCII grids: ``*_vel.asc`` speed, in a unit the file does not state, and ``*_ang.asc``, the
direction the wind blows *from*, degrees clockwise from north.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from instances.arrays import Floats
from instances.environment.raster import nodes_and_values, open_netcdf, projection, read_ascii_grid
from instances.errors import InputError, shown, suggestion

if TYPE_CHECKING:
    import xarray

COMPONENTS = (
    (("eastward_wind", "x_wind", "grid_eastward_wind"), ("u", "u10", "U10", "ua", "uas", "U", "wind_u")),
    (("northward_wind", "y_wind", "grid_northward_wind"), ("v", "v10", "V10", "va", "vas", "V", "wind_v")),
)
"""For u and v: CF standard names, then usual variable names."""

METRES_PER_SECOND = ("m/s", "m s-1", "m s**-1", "ms-1", "m.s-1", "meter second-1", "metre second-1", "m s^-1")
SPEED = {"m/s": 1.0, "mps": 1.0, "mph": 0.44704, "kph": 1 / 3.6, "km/h": 1 / 3.6, "knots": 1852 / 3600}
"""Unit of a WindNinja file → m/s."""


class WindData(NamedTuple):
    """What a file says, and what a `wind_grid.Grid` is made of: u, v [m/s] (rows, columns), x and y rising."""

    origin: tuple[float, float]
    spacing: tuple[float, float]
    u: Floats
    v: Floats
    source: str
    crs: str


def read_wind(path: Path | str, units: str | None = None) -> WindData:
    """Read a wind grid by the ending of its name; InputError names the file and what is wrong.

    `units` applies to WindNinja's ``.asc`` files only: NetCDF states its own.
    """
    path = Path(path)
    if path.suffix == ".asc":
        return read_windninja(path, units or "m/s")
    if path.suffix not in (".nc", ".nc4", ".cdf", ".h5"):
        raise InputError(f"{path}: a wind file must be NetCDF (.nc) or a WindNinja grid (.asc)")
    if units is not None:
        raise InputError(f"{path}: units of a NetCDF file are stated in the file, not in the scenario")
    return read_netcdf(path)


def read_netcdf(path: Path) -> WindData:
    """Read a CF NetCDF wind grid."""
    with open_netcdf(path) as data:
        u, v = (_component(data, path, *names) for names in COMPONENTS)
        if u.dims != v.dims:
            raise InputError(f"{path}: the wind components lie on different grids, {u.dims} and {v.dims}")
        units = [str(w.attrs.get("units", "")) for w in (u, v)]
        for w, unit in zip((u, v), units, strict=True):
            if unit not in METRES_PER_SECOND:
                raise InputError(f"{path}: variable '{w.name}' must be in m/s, its units are '{unit or 'not stated'}'")
        (x, y, east), (_, _, north) = (nodes_and_values(w, path) for w in (u, v))
        spacing = (float((x[-1] - x[0]) / (len(x) - 1)), float((y[-1] - y[0]) / (len(y) - 1)))
        return WindData((float(x[0]), float(y[0])), spacing, east, north, str(path), projection(data, u))


def _component(data: xarray.Dataset, path: Path, standard: tuple[str, ...], usual: tuple[str, ...]) -> xarray.DataArray:
    """Return the wind component found by standard name, else by usual name, without dimensions of size 1."""
    found = [w for w in data.data_vars.values() if w.attrs.get("standard_name") in standard]
    found = found or [data[name] for name in usual if name in data.data_vars]
    if not found:
        have = ", ".join(f"'{name}'" for name in data.data_vars) or "none"
        raise InputError(f"{path}: no variable with standard_name {standard[0]} or named {usual[0]} (it has: {have})")
    w = found[0].squeeze(drop=True)
    if w.ndim != 2:
        extra = ", ".join(f"{d} ({n})" for d, n in w.sizes.items())
        raise InputError(f"{path}: variable '{w.name}' must be one horizontal slice, its dimensions are {extra}")
    return w


def read_windninja(path: Path, units: str) -> WindData:
    """Read WindNinja's ``*_vel.asc`` together with the ``*_ang.asc`` beside it."""
    if not isinstance(units, str) or units not in SPEED:
        raise InputError(
            f"{path}: unknown units {shown(units)}{suggestion(str(units), SPEED)} (known: {', '.join(SPEED)})"
        )
    stem = path.name.removesuffix("_vel.asc").removesuffix("_ang.asc")
    if stem == path.name:
        raise InputError(f"{path}: a WindNinja grid must be named *_vel.asc, with *_ang.asc beside it")
    speed, direction = (read_ascii_grid(path.with_name(f"{stem}{end}")) for end in ("_vel.asc", "_ang.asc"))
    here, there = ((grid.origin, grid.spacing, grid.values.shape) for grid in (speed, direction))
    if here != there:
        raise InputError(f"{path}: speed and direction lie on different grids")
    towards = np.radians(direction.values) + np.pi
    s = speed.values * SPEED[units]
    return WindData(speed.origin, speed.spacing, s * np.sin(towards), s * np.cos(towards), str(path), speed.crs)
