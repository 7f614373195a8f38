"""RadioMap: the strength of a radio signal over the region, what the paper's UAVs measure (§RF Signal Intensity Data).

Received power [dBm] = transmitted power + antenna gains − path loss + shadowing (`propagation.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.declared.reading import given, read_declared
from instances.declared.scenario import RadioTable
from instances.environment.raster import bilinear, check_grid
from instances.errors import InputError
from instances.extent import LARGEST, LEAST, check_positions

SPEED_OF_LIGHT = 299_792_458.0
"""[m/s]"""


@dataclass(frozen=True)
class RadioSource:
    """An omni-directional transmitter and the receiver's antenna; the defaults are the paper's.

    Parameters
    ----------
    position
        (x, y) [m].
    height
        Of the mast above ground [m], positive.
    frequency
        Of the signal [Hz], positive.
    power_dbm
        Transmitted power [dBm].
    transmitter_gain_dbi, receiver_gain_dbi
        Gains of the antennas [dBi].

    Raises
    ------
    InputError
        For a number that is not finite, or not positive where it must be.
    """

    position: tuple[float, float]
    height: float = 10.0
    frequency: float = 146e6
    power_dbm: float = 40.0
    transmitter_gain_dbi: float = 6.0
    receiver_gain_dbi: float = 2.0

    def __post_init__(self) -> None:
        numbers = [*self.position, *(getattr(self, f.name) for f in fields(self) if f.name != "position")]
        if len(self.position) != 2 or not (np.abs(np.array(numbers, dtype=float)) <= LARGEST).all():
            raise InputError(f"radio source: position must be two finite numbers [m] and the rest finite, got {self}")
        check_positions(self.position, "radio source: position")
        for key in ("height", "frequency"):
            if not getattr(self, key) >= LEAST:
                raise InputError(f"radio source: {key} must be positive, got {getattr(self, key)}")

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> RadioSource:
        """Read a scenario's ``[radio]`` table: this class's field names, SI units and dB."""
        if "position" not in table:
            raise InputError("[radio]: position = [x, y] [m] is missing")
        said = read_declared(RadioTable, table, at=["radio"])
        return cls(**given(said))

    @property
    def wavelength(self) -> float:
        """λ [m]."""
        return SPEED_OF_LIGHT / self.frequency


@dataclass(frozen=True, eq=False)
class RadioMap:
    """Signal strength [dBm] at the nodes of a rectangular grid, bilinear between them and constant outside.

    Parameters
    ----------
    x, y
        Node positions [m], ascending and equally spaced, shapes (nx,) and (ny,).
    values
        Shape (ny, nx), rows going north; any scalar field a user wants mapped will do.
    unit
        Of the values.

    Raises
    ------
    InputError
        Where shapes do not fit or a number is not finite.
    """

    x: Floats
    y: Floats
    values: Floats
    unit: str = "dBm"

    def __post_init__(self) -> None:
        for name in ("x", "y", "values"):
            array = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.values.shape != (len(self.y), len(self.x)) or min(self.values.shape) < 2:
            raise InputError(
                f"field: {len(self.x)} × {len(self.y)} nodes, at least 2 × 2, need values of shape "
                f"({len(self.y)}, {len(self.x)}), got {self.values.shape}"
            )
        for name, axis in (("x", self.x), ("y", self.y)):
            check_positions(axis, f"field: {name}")
            step = np.diff(axis)
            if not (step > 0).all() or not np.allclose(step, step[0], rtol=1e-3):
                raise InputError(f"field: {name} must be ascending and equally spaced [m]")
        steps = (float(self.x[1] - self.x[0]), float(self.y[1] - self.y[0]))
        check_grid("field", (float(self.x[0]), float(self.y[0])), steps, self.values)

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the value at `points` (k, 2) [m], shape (k,)."""
        p = np.asarray(points, dtype=float).reshape(-1, 2)
        fx, fy = (p[:, 0] - self.x[0]) / (self.x[1] - self.x[0]), (p[:, 1] - self.y[0]) / (self.y[1] - self.y[0])
        return bilinear(self.values, fx, fy)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max [m] of the nodes."""
        return float(self.x[0]), float(self.y[0]), float(self.x[-1]), float(self.y[-1])
