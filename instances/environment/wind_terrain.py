"""Wind over terrain: a horizontal slice of the mass-consistent flow, described by what it is made from.

    [wind]
    kind = "terrain"
    dem = "dem.tif"                       # or mountains = {seed = 1, relief = 1500, ...}
    velocity = [-7.07, -7.07]             # [m/s], 10 m/s from the north-east
    altitude = 3000                       # [m] above the datum
    profile = "log"                       # "uniform", "log" or "power", with reference, roughness, exponent
    cells = 200                           # along the longer side

The flow is solved when the wind is first asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from inspect import signature
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.mass_consistent import Inflow, solve_flow
from instances.environment.site import Site
from instances.environment.terrain import Terrain, mountains, read_terrain
from instances.environment.wind import number, pair
from instances.environment.wind_grid import Grid
from instances.errors import InputError, shown, suggestion
from instances.registry import refuse_unknown

INFLOW = tuple(f.name for f in fields(Inflow))
MOUNTAINS = tuple(signature(mountains).parameters)
MOST_CELLS = 10_000_000
"""Cells of a flow: eight times as many as are usual."""
FIELDS = ("dem", "mountains", "altitude", "cells", "layers", *INFLOW)


@dataclass(frozen=True, eq=False)
class TerrainWind:
    """The wind at `altitude` [m] over a digital elevation model `dem`, at `site`, or over synthetic `mountains`."""

    inflow: Inflow
    altitude: float
    dem: Path | None = None
    mountains: Mapping[str, Any] = field(default_factory=dict)
    cells: int = 200
    layers: int = 30
    site: Site | None = None

    @cached_property
    def terrain(self) -> Terrain:
        """The ground, on the grid the flow is solved on."""
        if self.dem is not None:
            return read_terrain(self.dem, self.site).resampled(self.cells)
        return mountains(**{**self.mountains, "cells": self.cells})

    @cached_property
    def grid(self) -> Grid:
        """The solved wind."""
        return solve_flow(self.terrain, self.inflow, layers=self.layers).slice(self.altitude)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max [m] of the terrain."""
        return self.terrain.bounds

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m]."""
        return self.grid(points)

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b`."""
        return self.grid.line_integral(a, b)

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the ``[wind]`` table; the elevation model is named by its absolute path."""
        ground = {"mountains": dict(self.mountains)} if self.dem is None else {"dem": str(self.dem.resolve())}
        inflow = {name: getattr(self.inflow, name) for name in INFLOW}
        inflow["velocity"] = list(self.inflow.velocity)
        return {
            "kind": "terrain",
            **ground,
            **inflow,
            "altitude": self.altitude,
            "cells": self.cells,
            "layers": self.layers,
        }

    @classmethod
    def from_toml(cls, table: Mapping[str, Any], folder: Path, site: Site | None = None) -> TerrainWind:
        """Return the wind of a ``[wind]`` table."""
        refuse_unknown("wind: kind 'terrain'", "field", table, FIELDS)
        if ("dem" in table) == ("mountains" in table):
            raise InputError("wind: kind 'terrain' needs either 'dem', a file, or 'mountains', a table")
        made = table.get("mountains", {})
        if not isinstance(made, Mapping):
            raise InputError(f"wind: mountains must be a table, got {shown(made)}")
        for key, value in made.items():
            if key not in MOUNTAINS or key == "cells":
                raise InputError(f"wind: mountains have no '{key}'{suggestion(key, MOUNTAINS)}")
            number(value, f"mountains.{key}")
        if type(made.get("seed", 0)) is not int or made.get("seed", 0) < 0:
            raise InputError(f"wind: mountains.seed must be a whole number ≥ 0, got {shown(made['seed'])}")
        if "dem" in table and not isinstance(table["dem"], str):
            raise InputError(f"wind: dem must be the name of a file, got {shown(table['dem'])}")
        for name in ("cells", "layers"):
            if name in table and (type(table[name]) is not int or table[name] < 2):
                raise InputError(f"wind: {name} must be a whole number of at least 2, got {shown(table[name])}")
        cells, layers = table.get("cells", 200), table.get("layers", 30)
        if cells * cells * layers > MOST_CELLS:
            raise InputError(f"wind: cells = {shown(cells)} and layers = {shown(layers)} are more than can be solved")
        inflow = {name: table[name] for name in INFLOW if name in table}
        inflow["velocity"] = pair(table.get("velocity"), "velocity [m/s]")
        for name in ("reference", "roughness", "exponent"):
            if name in inflow:
                number(inflow[name], name)
        return cls(
            Inflow(**inflow),
            number(table.get("altitude"), "altitude [m]"),
            folder / table["dem"] if "dem" in table else None,
            dict(made),
            cells,
            layers,
            site,
        )
