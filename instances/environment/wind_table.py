"""Winds as a scenario's ``[wind]`` table names them: every kind, and sums of them.

This file knows all kinds of wind; they know `wind` only, so that nothing goes in a circle.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.declared.reading import given, read_declared
from instances.declared.winds import SumTable, Wind, WindTable
from instances.environment.site import Site
from instances.environment.wind import WindField, points_of
from instances.environment.wind_changing import ChangingWind
from instances.errors import InputError

KINDS = {
    "uniform": "instances.environment.wind:Uniform",
    "shear": "instances.environment.wind:Shear",
    "rotation": "instances.environment.wind:Rotation",
    "sum": "instances.environment.wind_table:Sum",
    "vortices": "instances.environment.wind_vortices:Vortices",
    "turbulence": "instances.environment.wind_turbulence:Turbulence",
    "grid": "instances.environment.wind_forecast:Forecast",
    "terrain": "instances.environment.wind_terrain:TerrainWind",
    "turning": "instances.environment.wind_changing:Turning",
    "valley": "instances.environment.wind_changing:Valley",
    "front": "instances.environment.wind_changing:Front",
    "drifting": "instances.environment.wind_changing:Drifting",
}
"""``kind`` in a scenario's ``[wind]`` table → ``"module:Class"``, imported when met: numba takes its time."""


READ = ("grid", "terrain")
"""Kinds that read files of places, and are told the site."""


def wind_from_toml(table: Mapping[str, Any], folder: Path | str = ".", site: Site | None = None) -> WindField:
    """Return the wind field of a scenario's ``[wind]`` table; files in it are relative to `folder`, read for `site`.

    Raises InputError for an unknown kind or field (with the near miss) and for unusable values.
    """
    said: WindTable = read_declared(Wind, table, at=["wind"])  # type: ignore[arg-type]  # a union is no type to mypy
    return wind_of(said, Path(folder), site)


def wind_of(said: WindTable, folder: Path, site: Site | None = None) -> WindField:
    """Return the wind field that a table describes; files in it are relative to `folder`, read for `site`."""
    if isinstance(said, SumTable):
        return Sum(tuple(wind_of(part, folder, site) for part in said.parts))
    kind = str(said.__struct_config__.tag)
    module, _, name = KINDS[kind].partition(":")
    cls: type[Any] = getattr(importlib.import_module(module), name)
    told = {"folder": folder, "site": site} if kind in READ else {}
    made: WindField = cls.from_toml(given(said), **told)
    return made


@dataclass(frozen=True)
class Sum:
    """The sum of several winds, for example a uniform wind and vortices."""

    parts: tuple[WindField, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", tuple(self.parts))
        if not self.parts:
            raise InputError("wind: a sum needs at least one part")
        if any(isinstance(part, ChangingWind) for part in self.parts):
            raise InputError("wind: a sum cannot hold a wind that changes with time")

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        p = points_of(points)
        return np.sum([part(p) for part in self.parts], axis=0)

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b`."""
        return np.sum([part.line_integral(a, b) for part in self.parts], axis=0)

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the ``[wind]`` table, one table a part."""
        return {"kind": "sum", "parts": [part.to_toml(folder) for part in self.parts]}
