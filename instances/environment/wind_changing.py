"""Winds that change with time, each in closed form: turning, breathing in a valley, a passing front, drifting vortices.

Such a wind is a wind field as well, the one at take-off, which is what a plan that knows no clock goes by. Where the
wind is the same everywhere the air's displacement since take-off, W(t) = ∫₀ᵗ w, decides how long a leg takes
(`instances.wind_arrivals`):

    turning   w = R(ωt) w₀                           W = t · sinc(ωt/2) · R(ωt/2) w₀      (the chord of an arc)
    valley    w = w₀ + a sin(2π(t/P + φ))            W = w₀t + a P/(2π) · [cos 2πφ − cos 2π(t/P + φ)]

and where it is not

    front     w = w₀ + (w₁ − w₀) · ½(1 + tanh((x_F(t) − n·x)/d)),   x_F = x₀ + ct,   n the way the front moves
    drifting  w = w₀ + Σ vortices(x − u t)
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.wind import TableWind, Uniform, WindField, number, pair, points_of
from instances.environment.wind_vortices import Vortices
from instances.errors import InputError


@runtime_checkable
class ChangingWind(WindField, Protocol):
    """A wind that changes with time; called as a wind field it is the one at take-off."""

    def velocities(self, points: Floats, times: Floats) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m], each at its time (k,) [s] after take-off, shape (k, 2)."""
        ...

    def at(self, time: float) -> WindField:
        """Return the wind of `time` [s] after take-off, as if it stayed."""
        ...


class _Everywhere(TableWind):
    """A wind that is the same everywhere at a time."""

    def velocity_at(self, times: Floats) -> Floats:
        """Return w(t) [m/s] at `times` (k,) [s], shape (k, 2)."""
        raise NotImplementedError

    def displacement(self, times: Floats) -> Floats:
        """Return W(t) = ∫₀ᵗ w [m] at `times` (k,) [s], shape (k, 2)."""
        raise NotImplementedError

    @property
    def rate(self) -> float:
        """The angular rate of its change [1/s]."""
        raise NotImplementedError

    def velocities(self, points: Floats, times: Floats) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m], each at its time (k,) [s], shape (k, 2)."""
        return self.velocity_at(times)

    def at(self, time: float) -> Uniform:
        """Return the wind of `time` [s], as if it stayed."""
        u, v = self.velocity_at(np.array([time]))[0].tolist()
        return Uniform((u, v))

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m] at take-off."""
        return self.velocity_at(np.zeros(len(points_of(points))))

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b` at take-off."""
        d = points_of(b) - points_of(a)
        return np.einsum("ij,ij->i", self(d), d)


@dataclass(frozen=True)
class Turning(_Everywhere):
    """A wind that keeps its speed and turns: `velocity` at take-off [m/s], `turning` anticlockwise [rad/s]."""

    kind: ClassVar[str] = "turning"
    velocity: tuple[float, float]
    turning: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", pair(self.velocity, "velocity [m/s]"))
        object.__setattr__(self, "turning", number(self.turning, "turning [rad/s]"))

    @property
    def rate(self) -> float:
        """|ω| [1/s]."""
        return abs(self.turning)

    def velocity_at(self, times: Floats) -> Floats:
        """Return w(t) [m/s] at `times` (k,) [s], shape (k, 2)."""
        return _turned(self.velocity, self.turning * times)

    def displacement(self, times: Floats) -> Floats:
        """Return W(t) [m] at `times` (k,) [s], shape (k, 2)."""
        half = 0.5 * self.turning * times
        return (times * np.sinc(half / np.pi))[:, None] * _turned(self.velocity, half)


@dataclass(frozen=True)
class Valley(_Everywhere):
    """A wind up and down a valley: mean `velocity` [m/s], `amplitude` (u, v) [m/s], `period` [s].

    `phase` is the share of a period that has passed at take-off: 0 where the amplitude is about to grow.
    """

    kind: ClassVar[str] = "valley"
    velocity: tuple[float, float]
    amplitude: tuple[float, float]
    period: float = 86400.0
    phase: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", pair(self.velocity, "velocity [m/s]"))
        object.__setattr__(self, "amplitude", pair(self.amplitude, "amplitude [m/s]"))
        object.__setattr__(self, "period", number(self.period, "period [s]"))
        object.__setattr__(self, "phase", number(self.phase, "phase"))
        if self.period <= 0:
            raise InputError(f"wind: period [s] must be positive, got {self.period:g}")

    @property
    def rate(self) -> float:
        """2π/P [1/s]."""
        return 2 * math.pi / self.period

    def velocity_at(self, times: Floats) -> Floats:
        """Return w(t) [m/s] at `times` (k,) [s], shape (k, 2)."""
        swing = np.sin(self.rate * times + 2 * math.pi * self.phase)
        return np.array(self.velocity) + swing[:, None] * np.array(self.amplitude)

    def displacement(self, times: Floats) -> Floats:
        """Return W(t) [m] at `times` (k,) [s], shape (k, 2)."""
        half = 0.5 * self.rate * times  # cos α − cos(α + 2h) = 2 sin(α + h) sin h: no difference of near numbers
        swung = times * np.sinc(half / np.pi) * np.sin(half + 2 * math.pi * self.phase)
        return times[:, None] * np.array(self.velocity) + swung[:, None] * np.array(self.amplitude)


@dataclass(frozen=True)
class Front(TableWind):
    """A front: wind `before` and `after` it [m/s]; it moves at `speed` [m/s] towards `direction` [degree].

    Directions count anticlockwise from east. `position` [m] is where the front is at take-off along its direction,
    from the origin; `width` [m] is half of that of the transition.
    """

    kind: ClassVar[str] = "front"
    before: tuple[float, float]
    after: tuple[float, float]
    speed: float
    direction: float = 0.0
    position: float = 0.0
    width: float = 2000.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "before", pair(self.before, "before [m/s]"))
        object.__setattr__(self, "after", pair(self.after, "after [m/s]"))
        units = {"speed": "m/s", "direction": "degree", "position": "m", "width": "m"}
        for name, unit in units.items():
            object.__setattr__(self, name, number(getattr(self, name), f"{name} [{unit}]"))
        if self.width <= 0:
            raise InputError(f"wind: width [m] must be positive, got {self.width:g}")

    def velocities(self, points: Floats, times: Floats) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m], each at its time (k,) [s], shape (k, 2)."""
        passed = 0.5 * (1.0 + np.tanh(self._depth(points, times)))
        return np.array(self.before) + passed[:, None] * (np.array(self.after) - np.array(self.before))

    def at(self, time: float) -> Front:
        """Return the wind of `time` [s], as if it stayed: one called as a wind field is the one at take-off."""
        return replace(self, position=self.position + self.speed * time)

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m] at take-off."""
        p = points_of(points)
        return self.velocities(p, np.zeros(len(p)))

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b` at take-off: the mean of tanh is that of ln cosh."""
        p, q = points_of(a), points_of(b)
        start, end = self._depth(p, np.zeros(len(p))), self._depth(q, np.zeros(len(q)))
        way = end - start
        level = np.abs(way) < 1e-6
        area = np.logaddexp(end, -end) - np.logaddexp(start, -start)
        mean = np.where(level, np.tanh(0.5 * (start + end)), area / np.where(level, 1.0, way))
        change = np.array(self.after) - np.array(self.before)
        mean_wind = np.array(self.before) + (0.5 * (1.0 + mean))[:, None] * change
        return np.einsum("ij,ij->i", mean_wind, q - p)

    def _depth(self, points: Floats, times: Floats) -> Floats:
        """Return how far the front has passed `points` at `times`, in widths."""
        angle = math.radians(self.direction)
        along = points[:, 0] * math.cos(angle) + points[:, 1] * math.sin(angle)
        return (self.position + self.speed * times - along) / self.width


@dataclass(frozen=True)
class Drifting(TableWind):
    """Vortices that drift through a mean wind: `velocity` [m/s], `drift` [m/s], and the vortices at take-off.

    `centres` [m], `circulation` [m²/s] and `core` [m] are those of `Vortices`.
    """

    kind: ClassVar[str] = "drifting"
    velocity: tuple[float, float]
    drift: tuple[float, float]
    centres: tuple[tuple[float, float], ...]
    circulation: tuple[float, ...]
    core: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", pair(self.velocity, "velocity [m/s]"))
        object.__setattr__(self, "drift", pair(self.drift, "drift [m/s]"))
        vortices = self._vortices
        for name in ("centres", "circulation", "core"):
            object.__setattr__(self, name, getattr(vortices, name))

    def velocities(self, points: Floats, times: Floats) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m], each at its time (k,) [s], shape (k, 2)."""
        moved = (points[:, axis] - times * self.drift[axis] for axis in (0, 1))
        u, v = self._vortices.components(*moved)
        return np.column_stack([self.velocity[0] + u, self.velocity[1] + v])

    def at(self, time: float) -> Drifting:
        """Return the wind of `time` [s], as if it stayed: one called as a wind field is the one at take-off."""
        moved = np.array(self.centres) + time * np.array(self.drift)
        return replace(self, centres=tuple((x, y) for x, y in moved.tolist()))

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m] at take-off."""
        p = points_of(points)
        return self.velocities(p, np.zeros(len(p)))

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b` at take-off."""
        return self._vortices.line_integral(a, b) + (points_of(b) - points_of(a)) @ np.array(self.velocity)

    @classmethod
    def from_toml(cls, table: Mapping[str, Any]) -> Self:
        """Return the field of a ``[wind]`` table; without `core` they are point vortices."""
        return super().from_toml({"core": [0.0] * len(table["circulation"]), **table})

    @cached_property
    def _vortices(self) -> Vortices:
        return Vortices(self.centres, self.circulation, self.core)


def _turned(vector: tuple[float, float], angles: Floats) -> Floats:
    """Return `vector` turned anticlockwise by `angles` (k,) [rad], shape (k, 2)."""
    c, s = np.cos(angles), np.sin(angles)
    return np.column_stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
