"""Gridded products as NetCDF-3 (classic) files with CF attributes, through scipy: they need no extra.

Axes are one-dimensional coordinate variables in the order of a variable's dimensions, for example (time, y, x). Where
the place of the local plane is known, a grid mapping (CF conventions, appendix F) says it.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from instances.arrays import Floats
from instances.disk import read_bytes, write_aside
from instances.errors import InputError
from instances.geodesy import TangentPlane, grid_mapping

if TYPE_CHECKING:  # imported where it is used: most commands read no grids, and it takes longer than they do
    from scipy.io import netcdf_file

AXES = {
    "x": {"standard_name": "projection_x_coordinate", "units": "m"},
    "y": {"standard_name": "projection_y_coordinate", "units": "m"},
    "time": {"long_name": "time since take-off", "units": "s"},
}
"""Attributes of the known axes."""
GRID_MAPPING = "crs"
"""Variable that holds the grid mapping."""


@dataclass(frozen=True, eq=False)
class Variable:
    """Values over named axes, and their unit and names as CF wants them."""

    axes: tuple[str, ...]
    values: Floats
    attributes: Mapping[str, str] = field(default_factory=dict)


def write_grids(
    path: Path | str,
    axes: Mapping[str, Floats],
    variables: Mapping[str, Variable],
    plane: TangentPlane | None = None,
    time_unit: str = "s",
) -> None:
    """Write `variables` over `axes`; values are kept as float64. plane : where on Earth x and y are, if known.

    time_unit : of the axis "time"; one since an instant where it is to be read as a wind or field that changes.
    """
    from scipy.io import netcdf_file

    buffer = io.BytesIO()
    with netcdf_file(buffer, "w", mmap=False) as data:
        setattr(data, "Conventions", "CF-1.8")  # noqa: B010 - a global attribute of the file
        for name, values in axes.items():
            data.createDimension(name, len(values))
            about = AXES.get(name, {}) | ({"units": time_unit} if name == "time" else {})
            _write(data, name, (name,), np.asarray(values), about)
        mapped = {} if plane is None else {"grid_mapping": GRID_MAPPING}
        for name, variable in variables.items():
            _write(data, name, variable.axes, variable.values, {**variable.attributes, **mapped})
        if plane is not None:
            _write_grid_mapping(data, plane)
        data.flush()
        content = buffer.getvalue()
    write_aside(path, content)


def _write(data: netcdf_file, name: str, axes: tuple[str, ...], values: Floats, attributes: Mapping[str, str]) -> None:
    made = data.createVariable(name, "d", axes)
    made[:] = values
    for key, text in attributes.items():
        setattr(made, key, text)


def _write_grid_mapping(data: netcdf_file, plane: TangentPlane) -> None:
    """Write the projection of `TangentPlane.projection` as CF names it."""
    made = data.createVariable(GRID_MAPPING, "i", ())
    made[...] = 0
    for key, value in grid_mapping(plane.projection).items():
        setattr(made, key, value if isinstance(value, str) else np.float64(value))  # a float is kept as float32


def read_grids(
    path: Path | str, expected: Mapping[str, tuple[str, ...]] | None = None
) -> tuple[dict[str, Floats], dict[str, Variable]]:
    """Return the axes and the variables of a file that `write_grids` wrote; InputError where it cannot be read.

    expected : variable → its axes; what the file must hold, over finite axes that rise.
    """
    from scipy.io import netcdf_file

    content = read_bytes(path)
    try:
        with netcdf_file(io.BytesIO(content), "r", mmap=False) as data:
            found = {
                name: Variable(tuple(v.dimensions), np.array(v.data, dtype=np.float64), _attributes(v))
                for name, v in data.variables.items()
            }
    except Exception as error:  # a damaged file meets scipy anywhere, and it raises anything
        raise InputError(f"{path}: cannot be read as NetCDF-3 ({error})") from None
    axes = {name: v.values for name, v in found.items() if v.axes == (name,)}
    for name, wanted in (expected or {}).items():
        if name not in found or found[name].axes != wanted:
            raise InputError(f"{path}: holds no variable '{name}' over {', '.join(wanted)}")
        for axis in wanted:
            if axis not in axes or not (np.diff(axes[axis]) > 0).all() or not np.isfinite(axes[axis]).all():
                raise InputError(f"{path}: the axis '{axis}' of '{name}' must hold finite numbers that rise")
    return axes, {name: v for name, v in found.items() if v.axes and name not in axes}


def _attributes(variable: object) -> dict[str, str]:
    attributes = getattr(variable, "_attributes", {})
    return {key: value.decode() if isinstance(value, bytes) else str(value) for key, value in attributes.items()}
