"""Wind fields: what they must offer, and the analytic ones whose velocity is linear in position.

The moving cost (paper, eq. moving_cost) needs the wind only through ∫ w·dσ along a path, so every field gives
that integral along straight segments exactly, not by sampling. Plane coordinates in metres, x east, y north;
velocities in m/s, blowing *towards* (u, v).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, ClassVar, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.errors import InputError, shown
from instances.extent import LARGEST


@runtime_checkable
class WindField(Protocol):
    """A stationary horizontal wind."""

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m], shape (k, 2)."""
        ...

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the straight segments `a` → `b`, (k, 2) [m] or one point for all, shape (k,)."""
        ...

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the scenario file's ``[wind]`` table; a field that is data writes its file into `folder`."""
        ...


def number(value: Any, what: str) -> float:
    """Return `value` as a float of at most `extent.LARGEST`, else raise InputError naming `what`."""
    real = not isinstance(value, bool) and isinstance(value, (int, float, np.number))
    if not real or not abs(value) <= LARGEST:
        raise InputError(f"wind: {what} must be a finite number of at most {LARGEST:g}, got {shown(value)}")
    return float(value)


def pair(value: Any, what: str) -> tuple[float, float]:
    """Return `value` as two finite floats, else raise InputError naming `what`."""
    if isinstance(value, (str, Mapping)) or not hasattr(value, "__len__") or len(value) != 2:
        raise InputError(f"wind: {what} must be two numbers, got {shown(value)}")
    return number(value[0], what), number(value[1], what)


def points_of(points: ArrayLike) -> Floats:
    """Return `points` as an array of shape (k, 2)."""
    return np.asarray(points, dtype=np.float64).reshape(-1, 2)


def ends_of(a: ArrayLike, b: ArrayLike) -> tuple[Floats, Floats]:
    """Return the ends of segments as two arrays of shape (k, 2); a single point is an end of all of them.

    Raises ValueError where the numbers of points differ otherwise.
    """
    p, q = np.broadcast_arrays(points_of(a), points_of(b))
    return np.ascontiguousarray(p), np.ascontiguousarray(q)


@dataclass(frozen=True)
class TableWind:
    """A wind described by its fields alone, which stand in the ``[wind]`` table under their names."""

    kind: ClassVar[str]

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the ``[wind]`` table."""
        return {"kind": self.kind, **{f.name: _lists(getattr(self, f.name)) for f in fields(self)}}

    @classmethod
    def from_toml(cls, table: Mapping[str, Any]) -> Self:
        """Return the field of a ``[wind]`` table as it is declared."""
        return cls(**table)


def _lists(value: Any) -> Any:
    return [_lists(part) for part in value] if isinstance(value, tuple) else value


class _Linear(TableWind):
    """What winds linear in position share: the midpoint rule is exact along straight segments."""

    def __call__(self, points: ArrayLike) -> Floats:
        raise NotImplementedError

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b`: w(midpoint)·(b − a), exact for a linear field."""
        p, q = points_of(a), points_of(b)
        return np.einsum("ij,ij->i", self(0.5 * (p + q)), q - p)


@dataclass(frozen=True)
class Uniform(_Linear):
    """The same wind everywhere: velocity (u, v) [m/s]."""

    kind = "uniform"
    velocity: tuple[float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", pair(self.velocity, "velocity [m/s]"))

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        return np.tile(np.array(self.velocity), (len(points_of(points)), 1))


@dataclass(frozen=True)
class _Centred(_Linear):
    """A wind linear about a point: rate [1/s], centre (x0, y0) [m]."""

    rate: float
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", number(self.rate, "rate [1/s]"))
        object.__setattr__(self, "centre", pair(self.centre, "centre [m]"))


class Shear(_Centred):
    """Linear shear w = (rate·(y − y0), 0): rate [1/s], centre (x0, y0) [m]; curl −rate."""

    kind = "shear"

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        p = points_of(points)
        return np.column_stack([self.rate * (p[:, 1] - self.centre[1]), np.zeros(len(p))])


class Rotation(_Centred):
    """Rigid rotation w = rate·(−(y − y0), x − x0): rate [1/s] anticlockwise, centre (x0, y0) [m]; curl 2·rate."""

    kind = "rotation"

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        d = points_of(points) - np.array(self.centre)
        return self.rate * np.column_stack([-d[:, 1], d[:, 0]])
