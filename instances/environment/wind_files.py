"""Wind grids in files: CF NetCDF in and out (extra ``geo``), WindNinja's ASCII grids in.

NetCDF follows the CF conventions: wind components are found by ``standard_name`` (eastward_wind, x_wind, …) or by
their usual names (ERA5, WRF, …), in m/s, on one-dimensional x and y in metres of a map projection.
WindNinja writes ESRI ASCII grids: ``*_vel.asc`` speed, in a unit the file does not state, and ``*_ang.asc``, the
direction the wind blows *from*, degrees clockwise from north.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from instances.arrays import Floats
from instances.environment.raster import METRES, coordinate, open_netcdf, projection, read_ascii_grid
from instances.errors import InputError, suggestion

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
        x, y = coordinate(u, "x", path), coordinate(u, "y", path)
        u, v = (w.transpose(y.dims[0], x.dims[0]) for w in (u, v))
        return _oriented(x.values, y.values, u.values, v.values, str(path), projection(data, u))


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


def _oriented(x: Any, y: Any, u: Any, v: Any, source: str, crs: str) -> WindData:
    """Return the grid with x and y rising."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if x[-1] < x[0]:
        x, u, v = x[::-1], u[:, ::-1], v[:, ::-1]
    if y[-1] < y[0]:
        y, u, v = y[::-1], u[::-1], v[::-1]
    spacing = (float((x[-1] - x[0]) / (len(x) - 1)), float((y[-1] - y[0]) / (len(y) - 1)))
    return WindData((float(x[0]), float(y[0])), spacing, u, v, source, crs)


def write_netcdf(grid: WindData, path: Path) -> None:
    """Write `grid` as CF NetCDF, aside and renamed."""
    try:
        import xarray
    except ImportError:
        raise InputError(
            f"{path}: writing NetCDF needs the extra 'geo' (pip install 'mmmdmtsp-workbench[geo]')"
        ) from None
    rows, columns = grid.u.shape
    axis = {
        name: (
            name,
            start + step * np.arange(count),
            {"standard_name": f"projection_{name}_coordinate", "units": METRES[0]},
        )
        for name, start, step, count in (
            ("x", grid.origin[0], grid.spacing[0], columns),
            ("y", grid.origin[1], grid.spacing[1], rows),
        )
    }
    fields = {
        name: (("y", "x"), values, {"standard_name": f"{axis_name}_wind", "units": "m s-1"})
        for name, values, axis_name in (("u", grid.u, "x"), ("v", grid.v, "y"))
    }
    data = xarray.Dataset(fields, coords=axis, attrs={"Conventions": "CF-1.8", "source": grid.source, "crs": grid.crs})
    aside = path.with_name(path.name + ".part")
    data.to_netcdf(aside, engine="netcdf4")
    aside.replace(path)


def read_windninja(path: Path, units: str) -> WindData:
    """Read WindNinja's ``*_vel.asc`` together with the ``*_ang.asc`` beside it."""
    if units not in SPEED:
        raise InputError(f"{path}: unknown units '{units}'{suggestion(units, SPEED)} (known: {', '.join(SPEED)})")
    stem = path.name.removesuffix("_vel.asc").removesuffix("_ang.asc")
    if stem == path.name:
        raise InputError(f"{path}: a WindNinja grid must be named *_vel.asc, with *_ang.asc beside it")
    speed, direction = (read_ascii_grid(path.with_name(f"{stem}{end}")) for end in ("_vel.asc", "_ang.asc"))
    if (speed.origin, speed.spacing, speed.values.shape) != (
        direction.origin,
        direction.spacing,
        direction.values.shape,
    ):
        raise InputError(f"{path}: speed and direction lie on different grids")
    towards = np.radians(direction.values) + np.pi
    s = speed.values * SPEED[units]
    cell = (speed.spacing, speed.spacing)
    return WindData(speed.origin, cell, s * np.sin(towards), s * np.cos(towards), str(path), speed.crs)
