"""Wind fields: what they must offer, and the analytic ones whose velocity is linear in position.

The moving cost (paper, eq. moving_cost) needs the wind only through ∫ w·dσ along a path, so every field gives
that integral along straight segments exactly, not by sampling. Plane coordinates in metres, x east, y north;
velocities in m/s, blowing *towards* (u, v).
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.errors import InputError, suggestion


@runtime_checkable
class WindField(Protocol):
    """A stationary horizontal wind."""

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m], shape (k, 2)."""
        ...

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the straight segments `a` → `b`, each (k, 2) [m], shape (k,)."""
        ...

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the scenario file's ``[wind]`` table; a field that is data writes its file into `folder`."""
        ...

    @classmethod
    def from_toml(cls, table: Mapping[str, Any], folder: Path) -> WindField:
        """Return the field described by `table`, its files relative to `folder`; InputError names what is wrong."""
        ...


def only_fields(table: Mapping[str, Any], kind: str, known: tuple[str, ...]) -> None:
    """Raise InputError where `table` has a field that a wind of this kind does not have."""
    for key in table:
        if key not in known:
            raise InputError(
                f"wind: kind '{kind}' has no field '{key}'{suggestion(key, known)} (it has: {', '.join(known)})"
            )


def number(value: Any, what: str) -> float:
    """Return `value` as a finite float, else raise InputError naming `what`."""
    real = not isinstance(value, bool) and isinstance(value, (int, float, np.number))
    if not real or not abs(value) <= sys.float_info.max:  # also whole numbers no float can hold
        raise InputError(f"wind: {what} must be a finite number, got {value!r}")
    return float(value)


def pair(value: Any, what: str) -> tuple[float, float]:
    """Return `value` as two finite floats, else raise InputError naming `what`."""
    if isinstance(value, (str, Mapping)) or not hasattr(value, "__len__") or len(value) != 2:
        raise InputError(f"wind: {what} must be two numbers, got {value!r}")
    return number(value[0], what), number(value[1], what)


def points_of(points: ArrayLike) -> Floats:
    """Return `points` as an array of shape (k, 2)."""
    return np.asarray(points, dtype=np.float64).reshape(-1, 2)


class _Linear:
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

    velocity: tuple[float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", pair(self.velocity, "velocity [m/s]"))

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        return np.tile(np.array(self.velocity), (len(points_of(points)), 1))

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the ``[wind]`` table."""
        return {"kind": "uniform", "velocity": list(self.velocity)}

    @classmethod
    def from_toml(cls, table: Mapping[str, Any], folder: Path) -> Uniform:
        """Return the field of a ``[wind]`` table."""
        only_fields(table, "uniform", ("velocity",))
        return cls(table.get("velocity"))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Shear(_Linear):
    """Linear shear w = (rate·(y − y0), 0): rate [1/s], centre (x0, y0) [m]; curl −rate."""

    rate: float
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", number(self.rate, "rate [1/s]"))
        object.__setattr__(self, "centre", pair(self.centre, "centre [m]"))

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        p = points_of(points)
        return np.column_stack([self.rate * (p[:, 1] - self.centre[1]), np.zeros(len(p))])

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the ``[wind]`` table."""
        return {"kind": "shear", "rate": self.rate, "centre": list(self.centre)}

    @classmethod
    def from_toml(cls, table: Mapping[str, Any], folder: Path) -> Shear:
        """Return the field of a ``[wind]`` table."""
        only_fields(table, "shear", ("rate", "centre"))
        return cls(table.get("rate"), table.get("centre", (0.0, 0.0)))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Rotation(_Linear):
    """Rigid rotation w = rate·(−(y − y0), x − x0): rate [1/s] anticlockwise, centre (x0, y0) [m]; curl 2·rate."""

    rate: float
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", number(self.rate, "rate [1/s]"))
        object.__setattr__(self, "centre", pair(self.centre, "centre [m]"))

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        d = points_of(points) - np.array(self.centre)
        return self.rate * np.column_stack([-d[:, 1], d[:, 0]])

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the ``[wind]`` table."""
        return {"kind": "rotation", "rate": self.rate, "centre": list(self.centre)}

    @classmethod
    def from_toml(cls, table: Mapping[str, Any], folder: Path) -> Rotation:
        """Return the field of a ``[wind]`` table."""
        only_fields(table, "rotation", ("rate", "centre"))
        return cls(table.get("rate"), table.get("centre", (0.0, 0.0)))  # type: ignore[arg-type]
