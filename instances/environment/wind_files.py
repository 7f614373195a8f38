"""Wind grids from files: CF NetCDF (extra ``geo``) and WindNinja's ASCII grids.

NetCDF follows the CF conventions: wind components are found by ``standard_name`` (eastward_wind, x_wind, …) or by
their usual names (ERA5, WRF, …), in m/s, on one-dimensional x and y in metres of a map projection or, for a site whose
place on Earth is known, in degrees or metres of any projection. Components named eastward are along the parallels, all
others along the axes of the grid; both are turned into those of the local plane. A file of several times is a forecast:
a frame each, at any steps.
WindNinja writes ESRI ASCII grids: ``*_vel.asc`` speed, in a unit the file does not state, and ``*_ang.asc``, the
direction the wind blows *from*, degrees clockwise from north.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from instances.arrays import Floats
from instances.environment.raster import Raster, netcdf_raster, node_axes, open_netcdf, read_ascii_grid
from instances.environment.raster_times import frames_of, is_time, refuse_too_many
from instances.environment.site import Site, check_metres
from instances.errors import InputError, naming, shown, suggestion
from instances.geodesy import WGS84

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


def read_wind(path: Path | str, units: str | None = None, site: Site | None = None) -> WindData:
    """Read a wind grid of one time, as `read_frames` does."""
    times, (first, *more) = read_frames(path, units, site)
    if more:
        raise InputError(f"{path}: holds {len(times)} times, where a wind that stays is wanted")
    return first


def read_frames(path: Path | str, units: str | None = None, site: Site | None = None) -> tuple[Floats, list[WindData]]:
    """Read wind grids by the ending of the file's name, for `site`: times [s] after the first, and a grid at each.

    `units` applies to WindNinja's ``.asc`` files only: NetCDF states its own.
    InputError names the file, where it has several frames the frame, and what is wrong.
    """
    path = Path(path)
    times, frames, axes = _components(path, units)
    made: list[WindData] = []
    for number, (u, v) in enumerate(frames):
        made.append(_placed(u, v, axes, f"{path}: frame {number}" if len(frames) > 1 else str(path), site))
        refuse_too_many(len(frames), made[0].u.size, path)
    return times, [frame._replace(source=str(path)) for frame in made]


def _placed(u: Raster, v: Raster, axes: str, label: str, site: Site | None) -> WindData:
    """Return the components of a frame on a grid of the plane of `site`, along its axes; InputError names `label`."""
    if site is None:
        with naming(label):
            check_metres(u.crs)
        return WindData(u.origin, u.spacing, u.values, v.values, label, u.crs)
    u, v = site.local(u, label), site.local(v, label)
    x, y = node_axes(u.origin, u.spacing, u.values.shape)
    east = site.axes_east(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2), axes).reshape(*u.values.shape, 2)
    along_x = u.values * east[..., 0] - v.values * east[..., 1]
    along_y = u.values * east[..., 1] + v.values * east[..., 0]
    return WindData(u.origin, u.spacing, along_x, along_y, label, u.crs)


def _components(path: Path, units: str | None) -> tuple[Floats, list[tuple[Raster, Raster]], str]:
    """Return the times [s] of a file, both components [m/s] at each, and the system along whose axes they are."""
    if path.suffix == ".asc":
        u, v, axes = read_windninja(path, units or "m/s")
        return np.zeros(1), [(u, v)], axes
    if path.suffix not in (".nc", ".nc4", ".cdf", ".h5"):
        raise InputError(f"{path}: a wind file must be NetCDF (.nc) or a WindNinja grid (.asc)")
    if units is not None:
        raise InputError(f"{path}: units of a NetCDF file are stated in the file, not in the scenario")
    return read_netcdf(path)


def read_netcdf(path: Path) -> tuple[Floats, list[tuple[Raster, Raster]], str]:
    """Read a CF NetCDF wind grid, or several over time."""
    with open_netcdf(path) as data:
        u, v = (_component(data, path, *names) for names in COMPONENTS)
        if u.dims != v.dims:
            raise InputError(f"{path}: the wind components lie on different grids, {u.dims} and {v.dims}")
        units = [str(w.attrs.get("units", "")) for w in (u, v)]
        for w, unit in zip((u, v), units, strict=True):
            if unit not in METRES_PER_SECOND:
                raise InputError(f"{path}: variable '{w.name}' must be in m/s, its units are '{unit or 'not stated'}'")
        eastward = u.attrs.get("standard_name") == "eastward_wind"
        (times, along_u), (_, along_v) = frames_of(u, path), frames_of(v, path)
        frames = []
        for pair in zip(along_u, along_v, strict=True):
            east, north = (netcdf_raster(data, w, path) for w in pair)
            frames.append((east, north))
        return times, frames, WGS84 if eastward and frames[0][0].crs else frames[0][0].crs


def _component(data: xarray.Dataset, path: Path, standard: tuple[str, ...], usual: tuple[str, ...]) -> xarray.DataArray:
    """Return the wind component found by standard name, else by usual name, without dimensions of size 1."""
    found = [w for w in data.data_vars.values() if w.attrs.get("standard_name") in standard]
    found = found or [data[name] for name in usual if name in data.data_vars]
    if not found:
        have = ", ".join(f"'{name}'" for name in data.data_vars) or "none"
        raise InputError(f"{path}: no variable with standard_name {standard[0]} or named {usual[0]} (it has: {have})")
    w = found[0].squeeze(drop=True)
    if w.ndim - sum(is_time(w, dimension) for dimension in w.dims) != 2:
        extra = ", ".join(f"{d} ({n})" for d, n in w.sizes.items())
        raise InputError(
            f"{path}: variable '{w.name}' must be one horizontal slice, its dimensions are {extra}, or one at each of "
            "the times since an instant that its coordinate states"
        )
    return w


def read_windninja(path: Path, units: str) -> tuple[Raster, Raster, str]:
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
    east, north = (replace(speed, values=s * part(towards)) for part in (np.sin, np.cos))
    return east, north, speed.crs
