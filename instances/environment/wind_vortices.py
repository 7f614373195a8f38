"""Vortices: the sum of Scully (Kaufmann) vortices, a standard model of a vortex with a viscous core.

Tangential velocity Γ/(2π) · r/(r² + c²) at distance r from the centre; c = 0 is the point vortex. Vorticity
Γ/π · c²/(r² + c²)². Source: M. P. Scully, MIT ASRL TR 178-1 (1975); W. Kaufmann, Ing.-Arch. 31 (1962).

Along a straight line at signed distance h from the centre, with s the coordinate along it,
∫ w·dσ = Γ/(2π) · h/√(h² + c²) · [atan(s/√(h² + c²))], so line integrals are elementary.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.wind import TableWind, ends_of, number, pair, points_of
from instances.errors import InputError


@dataclass(frozen=True)
class Vortices(TableWind):
    """Vortices at `centres` [m], each with its `circulation` Γ [m²/s] (anticlockwise positive) and `core` c [m]."""

    kind = "vortices"
    centres: tuple[tuple[float, float], ...]
    circulation: tuple[float, ...]
    core: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "centres", tuple(pair(c, "a vortex centre [m]") for c in self.centres))
        object.__setattr__(self, "circulation", tuple(number(g, "circulation [m²/s]") for g in self.circulation))
        object.__setattr__(self, "core", tuple(number(c, "core [m]") for c in self.core))
        if not len(self.centres) == len(self.circulation) == len(self.core) > 0:
            raise InputError(
                f"wind: vortices need as many centres, circulations and cores, at least one; got "
                f"{len(self.centres)}, {len(self.circulation)} and {len(self.core)}"
            )
        if min(self.core) < 0:
            raise InputError(f"wind: core [m] must not be negative, got {min(self.core)}")

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]; zero at the centre of a point vortex."""
        p = points_of(points)
        return np.column_stack(self.components(p[:, 0], p[:, 1]))

    def components(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return u and v [m/s] at `x`, `y` (k,) [m], as `__call__` does."""
        u, v = np.zeros(len(x)), np.zeros(len(x))
        for (x0, y0), g, c in zip(self.centres, self.circulation, self.core, strict=True):
            dx, dy = x - x0, y - y0
            r2 = dx * dx + dy * dy + c * c
            gamma = g / (2 * np.pi)
            k = gamma / r2 if c * c > 0 else np.divide(gamma, r2, out=np.zeros_like(r2), where=r2 > 0)
            u -= k * dy
            v += k * dx
        return u, v

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b`."""
        p, q = ends_of(a, b)
        d = q - p
        length = np.hypot(d[:, 0], d[:, 1])
        t = np.divide(d, length[:, None], out=np.zeros_like(d), where=length[:, None] > 0)
        total = np.zeros(len(p))
        for (x, y), g, c in zip(self.centres, self.circulation, self.core, strict=True):
            dx, dy = p[:, 0] - x, p[:, 1] - y
            h = dx * t[:, 1] - dy * t[:, 0]
            start = dx * t[:, 0] + dy * t[:, 1]
            rho = np.sqrt(h * h + c * c)
            # One atan2 for atan(b/ρ) − atan(a/ρ), which lies within ±π.
            swept = np.arctan2(rho * length, rho * rho + start * (start + length))
            total += g / (2 * np.pi) * np.divide(h, rho, out=np.zeros_like(h), where=rho > 0) * swept
        return total

    @classmethod
    def from_toml(cls, table: Mapping[str, Any]) -> Self:
        """Return the field of a ``[wind]`` table; without `core` they are point vortices."""
        return super().from_toml({"core": [0.0] * len(table["circulation"]), **table})
