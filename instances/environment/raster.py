"""Rasters, what wind, terrain and fields share: their nodes, ESRI ASCII grids, GeoTIFF, NetCDF, map projections.

What they hold stays in the coordinates of the file here; `instances.environment.site` brings it to where it is used.
"""

from __future__ import annotations

import importlib
import io
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from instances.arrays import Bools, Floats
from instances.disk import check_file, read_bytes, read_text, write_aside
from instances.documents import most_opened
from instances.errors import InputError, shown
from instances.extent import FINEST, LARGEST, check_positions
from instances.geodesy import WGS84, mapped_crs

if TYPE_CHECKING:
    import xarray

METRES = ("m", "metre", "meter", "metres", "meters")
DEGREES = ("degrees_east", "degrees_north", "degree", "degrees", "degree_east", "degree_north")


@dataclass(frozen=True, eq=False)
class Raster:
    """Values on an equally spaced grid in the coordinates of its reference system.

    origin : node (0, 0); spacing (dx, dy); values (rows, columns), rows going north, NaN for no data.
    crs : reference system, "" where the file states none. unit : of the values, "" where the file states none.
    """

    origin: tuple[float, float]
    spacing: tuple[float, float]
    values: Floats
    crs: str
    unit: str = ""


def node_axes(
    origin: tuple[float, float], spacing: tuple[float, float], shape: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """Return x (columns,) and y (rows,) [m] of the nodes of a grid of `shape` (rows, columns)."""
    rows, columns = shape
    x: Floats = origin[0] + spacing[0] * np.arange(columns, dtype=np.float64)
    return x, np.asarray(origin[1] + spacing[1] * np.arange(rows, dtype=np.float64))


def node_bounds(
    origin: tuple[float, float], spacing: tuple[float, float], shape: tuple[int, ...]
) -> tuple[float, float, float, float]:
    """Return x_min, y_min, x_max, y_max [m] of the nodes of a grid of `shape` (rows, columns)."""
    (x, y), (dx, dy), (rows, columns) = origin, spacing, shape
    return x, y, x + (columns - 1) * dx, y + (rows - 1) * dy


def bilinear(values: Floats, fx: Floats, fy: Floats) -> Floats:
    """Return the values at columns `fx` and rows `fy` of a grid, constant outside, shape (k,)."""
    rows, columns = values.shape
    fx, fy = np.clip(fx, 0, columns - 1), np.clip(fy, 0, rows - 1)
    i, j = np.minimum(fx.astype(int), columns - 2), np.minimum(fy.astype(int), rows - 2)
    s, t = fx - i, fy - j
    south = (1 - s) * values[j, i] + s * values[j, i + 1]
    north = (1 - s) * values[j + 1, i] + s * values[j + 1, i + 1]
    return np.asarray((1 - t) * south + t * north)


def check_grid(what: str, origin: tuple[float, float], spacing: tuple[float, float], *values: Floats) -> None:
    """Raise InputError where nodes lie too far away or too close together, or `values` (rows, columns) are no data.

    It says how many values are missing (not finite, or beyond `extent.LARGEST`), and where the first is.
    """
    if not min(spacing) >= FINEST:
        raise InputError(f"{what}: spacing must be positive, at least {FINEST:g} m, got {spacing}")
    check_positions(node_bounds(origin, spacing, values[0].shape), f"{what}: coordinates")
    usable: Bools = np.all([np.abs(array) <= LARGEST for array in values], axis=0)
    if not usable.all():
        j, i = np.argwhere(~usable)[0]
        x, y = origin[0] + i * spacing[0], origin[1] + j * spacing[1]
        raise InputError(
            f"{what}: {int((~usable).sum())} of {usable.size} values are missing (NaN or no data), first at "
            f"({x:g}, {y:g}) m; fill the holes first"
        )


def geo(module: str, path: Path, doing: str) -> Any:
    """Import a module of the extra ``geo``; where that is not installed, InputError says that `path` needs it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError(f"{path}: {doing} needs the extra 'geo' (pip install 'mmmdmtsp-workbench[geo]')") from None


def read_ascii_grid(path: Path) -> Raster:
    """Read an ESRI ASCII grid, and the projection from the ``.prj`` beside it; InputError names what is wrong."""
    lines = read_text(path).splitlines()
    head = _ascii_head(lines, path)
    try:
        values = np.array(" ".join(lines[len(head) :]).split(), dtype=float)
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
    rows, columns, cell = int(head["nrows"]), int(head["ncols"]), head["cellsize"]
    if min(rows, columns) < 1 or values.size != rows * columns:
        raise InputError(f"{path}: {rows} × {columns} values announced, {values.size} found")
    values = values.reshape(rows, columns)[::-1].copy()  # the file's first row is the northern one
    values[values == head.get("nodata_value", -9999.0)] = np.nan
    x, y = (head.get(f"{axis}llcenter", head.get(f"{axis}llcorner", 0.0) + cell / 2) for axis in "xy")
    prj = path.with_suffix(".prj")
    crs = read_text(prj).strip() if prj.exists() else ""
    return Raster((x, y), (cell, cell), values, crs)


def _ascii_head(lines: list[str], path: Path) -> dict[str, float]:
    """Return the header of an ESRI ASCII grid, a keyword and a finite number a line."""
    head: dict[str, float] = {}
    for number, line in enumerate(lines):
        words = line.split()
        if len(words) != 2 or not words[0][:1].isalpha():
            break
        try:
            value = float(words[1])
        except ValueError:
            value = math.nan
        key = words[0].lower()
        if not math.isfinite(value) and key != "nodata_value":
            raise InputError(f"{path}: line {number + 1}: {shown(words[0])} must be a number, got {shown(words[1])}")
        if key in head:
            raise InputError(f"{path}: line {number + 1}: {shown(words[0])} is given twice")
        head[key] = value
    for key in ("ncols", "nrows", "cellsize"):
        if key not in head:
            raise InputError(f"{path}: the header of the ASCII grid has no {key}")
    return head


@contextmanager
def open_netcdf(path: Path) -> Iterator[xarray.Dataset]:
    """Give the content of a NetCDF file; InputError where it cannot be read or the extra ``geo`` is not installed."""
    content = read_bytes(path)
    xarray, netcdf4 = (geo(module, path, "reading NetCDF") for module in ("xarray", "netCDF4"))
    try:
        if content[:4] in (b"CDF\x01", b"CDF\x02"):  # a damaged header makes the C library take gigabytes, scipy not
            with xarray.open_dataset(io.BytesIO(content), engine="scipy") as data:
                yield data
            return
        if content[1:4] != b"HDF":
            raise ValueError("neither NetCDF-4 nor classic NetCDF")
        with netcdf4.Dataset(path.name, memory=content) as raw:
            for name, variable in raw.variables.items():
                _check_opened(f"{path}: variable {shown(name)}", len(content), variable.shape)
            yield xarray.open_dataset(xarray.backends.NetCDF4DataStore(raw))
    except InputError:
        raise
    except Exception as error:  # damaged files meet the libraries anywhere, and they raise anything
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: cannot be read as NetCDF ({reason})") from None


def _check_opened(what: str, size: int, shape: tuple[int, ...]) -> None:
    """Raise InputError where values of `shape` are more than a file of `size` bytes can have packed."""
    if 8 * math.prod(shape) > most_opened(size):
        raise InputError(f"{what} is of shape {shape}, which is more than a file of {size:,} bytes can hold")


def coordinate(field: xarray.DataArray, axis: str, path: Path) -> tuple[xarray.DataArray, bool]:
    """Return the one-dimensional coordinate of `field` along `axis` ("x" or "y"), equally spaced in metres or degrees.

    With it, whether it is in degrees.
    """
    dims = {"x": ("x", "lon", "longitude", "easting"), "y": ("y", "lat", "latitude", "northing")}[axis]
    for name in field.dims:
        found = field.coords.get(name)
        if found is None:
            continue
        standard = found.attrs.get("standard_name", "")
        if (
            standard not in (f"projection_{axis}_coordinate", dims[2])
            and found.attrs.get("axis", "").lower() != axis
            and name not in dims
        ):
            continue
        unit = str(found.attrs.get("units", "m"))
        degrees = unit in DEGREES or name in dims[1:3]
        if not degrees and unit not in METRES:
            raise InputError(f"{path}: coordinate '{name}' must be in metres, its units are '{unit}'")
        step = np.diff(found.values.astype(float))
        if len(step) == 0 or not np.allclose(step, step[0], rtol=1e-3) or step[0] == 0:
            raise InputError(f"{path}: coordinate '{name}' must be equally spaced, at least 2 values")
        return found, degrees
    raise InputError(
        f"{path}: variable '{field.name}' has no {axis} coordinate (its dimensions: {', '.join(map(str, field.dims))})"
    )


def netcdf_raster(data: xarray.Dataset, field: xarray.DataArray, path: Path) -> Raster:
    """Return a two-dimensional `field` of the file `data` with its reference system and its units."""
    (x, x_degrees), (y, y_degrees) = coordinate(field, "x", path), coordinate(field, "y", path)
    if x_degrees != y_degrees:
        raise InputError(f"{path}: one of the coordinates '{x.name}' and '{y.name}' is in degrees, the other is not")
    field = field.sortby([x.name, y.name]).transpose(y.dims[0], x.dims[0])
    (x0, x1), (y0, y1) = ((float(axis.min()), float(axis.max())) for axis in (x, y))
    spacing = ((x1 - x0) / (x.size - 1), (y1 - y0) / (y.size - 1))
    crs = projection(data, field) or (WGS84 if x_degrees else "")
    return Raster((x0, y0), spacing, field.values.astype(np.float64), crs, str(field.attrs.get("units", "")))


SINCE = "seconds since 2000-01-01"
"""Unit of times that are written: CF wants an instant to count from, and take-off is at none."""


def write_netcdf(
    path: Path,
    x: Floats,
    y: Floats,
    fields: Mapping[str, tuple[Floats, dict[str, str]]],
    about: Mapping[str, str],
    times: Floats | None = None,
) -> None:
    """Write values (rows, columns) and attributes by name over the nodes x, y [m] as CF NetCDF, aside and renamed.

    times : where given, values are (times, rows, columns), at so many seconds.
    """
    xarray = geo("xarray", path, "writing NetCDF")
    axes = {
        name: (name, values, {"standard_name": f"projection_{name}_coordinate", "units": "m"})
        for name, values in (("x", x), ("y", y))
    }
    over: tuple[str, ...] = ("y", "x")
    if times is not None:
        over, axes["time"] = ("time", *over), ("time", times, {"standard_name": "time", "units": SINCE})
    variables = {name: (over, *field) for name, field in fields.items()}
    dataset = xarray.Dataset(variables, coords=axes, attrs={"Conventions": "CF-1.8", **about})
    try:
        with TemporaryDirectory() as folder:
            made = Path(folder) / "made.nc"
            dataset.to_netcdf(made, engine="netcdf4")
            content = read_bytes(made)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None
    write_aside(path, content)


def projection(data: xarray.Dataset, field: xarray.DataArray) -> str:
    """Return the projection the file states for `field` (CF grid mapping, or a global ``crs``), or ``""``."""
    mapping = field.attrs.get("grid_mapping", field.encoding.get("grid_mapping"))
    if mapping in data:
        attributes = data[mapping].attrs
        said = attributes.get("crs_wkt") or attributes.get("spatial_ref") or mapped_crs(attributes)
        return str(said or attributes.get("grid_mapping_name", ""))
    return str(data.attrs.get("crs", ""))


def same_projection(one: str, other: str, what: str) -> None:
    """Raise InputError where two rasters state different map projections."""
    if one and other and "".join(one.split()) != "".join(other.split()):
        raise InputError(f"{what}: different map projections, {shown(one)} and {shown(other)}")


def read_geotiff(path: Path) -> Raster:
    """Read the first band of a north-up GeoTIFF in metres; InputError names what is wrong."""
    size = check_file(path)
    rasterio = geo("rasterio", path, "reading GeoTIFF")
    try:
        with rasterio.open(path, driver="GTiff") as data:  # GDAL would follow a virtual raster to other files
            _check_opened(str(path), size, data.shape)
            band = data.read(1, masked=True).astype(np.float64).filled(np.nan)
            transform, crs, unit = data.transform, data.crs, data.units[0]
    except InputError:
        raise
    except Exception as error:  # damaged files meet the library anywhere, and it raises anything
        raise InputError(f"{path}: cannot be read as GeoTIFF ({error})") from None
    if transform.b or transform.d or transform.a <= 0 or transform.e >= 0:
        raise InputError(f"{path}: the raster must be north up, its transform is {tuple(transform)[:6]}")
    dx, dy = transform.a, -transform.e
    # Pixels are areas: the first node is the centre of the lower left one.
    origin = (transform.c + dx / 2, transform.f - dy * (band.shape[0] - 0.5))
    return Raster(origin, (dx, dy), band[::-1], "" if crs is None else crs.to_wkt(), unit or "")
