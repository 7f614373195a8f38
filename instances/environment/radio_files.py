"""Files of a RadioMap, or of any scalar field a user wants mapped: CSV, NetCDF and GeoTIFF.

CSV: a header ``x,y,<unit>`` and a line a grid node, in metres and the field's unit, in any order; or ``lon,lat,<unit>``
in degrees. A NetCDF file of several times is a field that changes, a frame each, at any steps.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from instances.arrays import Floats
from instances.disk import read_text, write_aside
from instances.environment.radio import RadioMap
from instances.environment.radio_changing import ChangingField
from instances.environment.raster import Raster, netcdf_raster, node_axes, open_netcdf, read_geotiff, write_netcdf
from instances.environment.raster_times import frames_of, is_time, refuse_too_many
from instances.environment.site import Site, check_metres
from instances.errors import InputError, naming, shown
from instances.geodesy import WGS84


def read_field(path: Path | str, site: Site | None = None, unit: str | None = None) -> RadioMap:
    """Read a field of one time, as `read_measured` does."""
    field = read_measured(path, site, unit)
    if isinstance(field, ChangingField):
        raise InputError(f"{path}: holds {len(field.times)} times, where a field that stays is wanted")
    return field


def read_measured(path: Path | str, site: Site | None = None, unit: str | None = None) -> RadioMap | ChangingField:
    """Read a field by the ending of its name: .csv, .nc or .tif; NetCDF of several times is one that changes.

    site : where it is brought to. unit : of the values, what the file says unless given.
    InputError names the file, where it has several frames the frame, and what is wrong.
    """
    path = Path(path)
    readers = {".csv": _read_csv, ".tif": read_geotiff, ".tiff": read_geotiff}
    if path.suffix.lower() not in (*readers, ".nc"):
        raise InputError(f"{path}: a field file must be CSV (.csv), NetCDF (.nc) or GeoTIFF (.tif)")
    with naming(path):
        if path.suffix.lower() != ".nc":
            return _placed(readers[path.suffix.lower()](path), str(path), site, unit)
        times, rasters = _read_netcdf(path)
        if len(rasters) == 1:
            return _placed(rasters[0], str(path), site, unit)
        made: list[RadioMap] = []
        for number, raster in enumerate(rasters):
            label = f"{path}: frame {number}"
            with naming(label):
                made.append(_placed(raster, label, site, unit))
            refuse_too_many(len(rasters), made[0].values.size, path)
        return ChangingField(times, made)


def _placed(raster: Raster, label: str, site: Site | None, unit: str | None) -> RadioMap:
    """Return a raster as a map in the plane of `site`; InputError names `label`."""
    if site is not None:
        raster = site.local(raster, label)
    else:
        check_metres(raster.crs)
    axes = node_axes(raster.origin, raster.spacing, raster.values.shape)
    return RadioMap(*axes, raster.values, raster.unit if unit is None else unit)


def write_field(field: RadioMap, path: Path | str) -> None:
    """Write a field as .csv or .nc (extra ``geo``), aside and renamed."""
    path = Path(path)
    if path.suffix.lower() == ".csv":
        write_aside(path, _csv(field))
    elif path.suffix.lower() == ".nc":
        signal = {"field": (field.values, {"long_name": "field", "units": field.unit})}
        write_netcdf(path, field.x, field.y, signal, {})
    else:
        raise InputError(f"{path}: a field is written as CSV (.csv) or NetCDF (.nc)")


def _csv(field: RadioMap) -> str:
    xs, ys = np.meshgrid(field.x, field.y)
    rows = np.column_stack([xs.ravel(), ys.ravel(), field.values.ravel()])
    out = io.StringIO()
    out.write(f"x,y,{field.unit}\n")
    np.savetxt(out, rows, delimiter=",", fmt="%.17g")
    return out.getvalue()


def _read_csv(path: Path) -> Raster:
    lines = read_text(path).splitlines()
    head = [name.strip() for name in lines[0].split(",")] if lines else []
    degrees = [name.lower() for name in head[:2]] == ["lon", "lat"]
    if len(head) != 3 or not (degrees or [name.lower() for name in head[:2]] == ["x", "y"]):
        raise InputError(f"{path}: the first line must be 'x,y,<unit>', got {shown(lines[0] if lines else '')}")
    rows = np.array([_three(line, number, path) for number, line in enumerate(lines[1:], 2) if line.strip()])
    if not len(rows):
        raise InputError(f"{path}: every line must hold three numbers x, y and a value, but there is none")
    (x, i), (y, j) = (np.unique(rows[:, axis], return_inverse=True) for axis in (0, 1))
    if len(rows) != len(x) * len(y):
        raise InputError(f"{path}: {len(x)} × {len(y)} grid nodes need {len(x) * len(y)} lines, got {len(rows)}")
    values = np.full((len(y), len(x)), np.nan)
    values[j, i] = rows[:, 2]
    spacing = [_spacing(axis, name) for axis, name in ((x, head[0]), (y, head[1]))]
    return Raster((float(x[0]), float(y[0])), (spacing[0], spacing[1]), values, WGS84 if degrees else "", head[2])


def _spacing(axis: Floats, name: str) -> float:
    """Return the distance between nodes; InputError where it varies."""
    step = np.diff(axis)
    if len(step) == 0 or not np.allclose(step, step[0], rtol=1e-3):
        raise InputError(f"field: {name} must be equally spaced, at least 2 values")
    return float((axis[-1] - axis[0]) / (len(axis) - 1))


def _three(line: str, number: int, path: Path) -> list[float]:
    try:
        x, y, value = map(float, line.split(","))
    except ValueError:
        raise InputError(
            f"{path}: line {number}: every line must hold three numbers x, y and a value, got {shown(line)}"
        ) from None
    return [x, y, value]


def _read_netcdf(path: Path) -> tuple[Floats, list[Raster]]:
    """Return the times [s] of a file after its first, and a raster at each."""
    with open_netcdf(path) as data:
        slices = [v.squeeze(drop=True) for v in data.data_vars.values()]
        over = [sum(is_time(v, dimension) for dimension in v.dims) for v in slices]
        flat = [v for v, times in zip(slices, over, strict=True) if v.ndim == 2 and not times]
        flat = flat or [v for v, times in zip(slices, over, strict=True) if (v.ndim, times) == (3, 1)]
        if len(flat) != 1:
            have = ", ".join(f"'{name}'" for name in data.data_vars) or "none"
            raise InputError(
                f"{path}: must hold one variable of two dimensions, or of these and the times since an instant that "
                f"its coordinate states, it has {have}"
            )
        times, frames = frames_of(flat[0], path)
        return times, [netcdf_raster(data, frame, path) for frame in frames]
