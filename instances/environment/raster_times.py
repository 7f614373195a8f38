"""The times of a NetCDF variable: which of its dimensions is time (CF conventions, section 4.4), in seconds.

xarray decodes ``units = "hours since 2026-01-01"`` to instants, of other calendars to objects of its own.
"""

from __future__ import annotations

from collections.abc import Hashable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from instances.arrays import Floats
from instances.errors import InputError

if TYPE_CHECKING:
    import xarray

MOST_VALUES = 30_000_000
"""Of a variable, over all frames."""


def is_time(field: xarray.DataArray, dimension: Hashable) -> bool:
    """Return whether the values of `field` along `dimension` are at times that it states."""
    found = field.coords.get(dimension)
    return found is not None and found.ndim == 1 and found.dtype.kind in "MmO"


def frames_of(field: xarray.DataArray, path: Path) -> tuple[Floats, list[xarray.DataArray]]:
    """Return the times [s] of a variable after its first, and a slice at each; 0 and itself where it states none."""
    along = next((dimension for dimension in field.dims if is_time(field, dimension)), None)
    if along is None:
        return np.zeros(1), [field]
    times = seconds(field[along], path)
    return times, [field.isel({along: k}) for k in range(len(times))]


def refuse_too_many(frames: int, nodes: int, path: Path) -> None:
    """Raise InputError where `frames` of `nodes` values are more than can be used."""
    if frames * nodes > MOST_VALUES:
        raise InputError(f"{path}: {frames} frames of {nodes} nodes are more than can be used")


def seconds(times: xarray.DataArray, path: Path) -> Floats:
    """Return `times` in seconds after the first, (k,); InputError where they do not increase."""
    instants = times.to_numpy()
    if instants.dtype.kind == "O":
        since = np.array([(each - instants[0]).total_seconds() for each in instants])
    else:
        since = (instants - instants[0]) / np.timedelta64(1, "s")
    if not (np.diff(since) > 0).all():
        late = int(np.argmin(np.diff(since) > 0)) + 1
        raise InputError(
            f"{path}: coordinate '{times.name}' must increase from frame to frame, frame {late} is at "
            f"{instants[late]}, after {instants[late - 1]}"
        )
    return np.asarray(since, dtype=np.float64)
