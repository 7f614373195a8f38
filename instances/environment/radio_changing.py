"""A field that changes: maps in frames on one grid, linear in time between them, the last one held.

    f(x, t) = (1 − s) f_k(x) + s f_{k+1}(x),   s = (t − t_k)/(t_{k+1} − t_k)

Steps from frame to frame may differ. UAVs take off at the first frame. How a file states its times is `raster_times`'.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from instances.arrays import Floats
from instances.environment.radio import RadioMap
from instances.errors import InputError


@dataclass(frozen=True, eq=False)
class ChangingField:
    """Maps of a field, `frames`, on the same nodes, at `times` (k,) [s], rising from 0, at least two.

    Raises
    ------
    InputError
        Where times and frames do not fit.
    """

    times: Floats
    frames: Sequence[RadioMap]

    def __post_init__(self) -> None:
        if len(self.times) < 2 or len(self.frames) != len(self.times):
            raise InputError(f"field: {len(self.times)} times need as many frames, at least 2, got {len(self.frames)}")
        if self.times[0] != 0 or not (np.diff(self.times) > 0).all() or not np.isfinite(self.times).all():
            raise InputError(f"field: times must increase from 0 s, got {np.asarray(self.times).tolist()}")

    @property
    def unit(self) -> str:
        """Unit of the field."""
        return self.frames[0].unit

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max [m] of the nodes."""
        return self.frames[0].bounds

    @property
    def lasts(self) -> float:
        """When the last frame is [s]; it is held from then on."""
        return float(self.times[-1])

    def at(self, time: float) -> RadioMap:
        """Return the field at `time` [s] after take-off."""
        frame = float(np.interp(time, self.times, np.arange(len(self.times))))
        k = min(int(frame), len(self.times) - 2)
        s = frame - k
        before, after = self.frames[k], self.frames[k + 1]
        return replace(before, values=(1 - s) * before.values + s * after.values)
