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
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.mass_consistent import Inflow, solve_flow
from instances.environment.site import Site
from instances.environment.terrain import Terrain, mountains, read_terrain
from instances.environment.wind_grid import Grid
from instances.errors import InputError

INFLOW = tuple(f.name for f in fields(Inflow))
MOST_CELLS = 10_000_000
"""Cells of a flow: eight times as many as are usual."""


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
        cells, layers = table["cells"], table["layers"]
        if cells * cells * layers > MOST_CELLS:
            raise InputError(f"[wind] cells = {cells} and layers = {layers} are more than can be solved")
        return cls(
            Inflow(**{name: table[name] for name in INFLOW}),
            table["altitude"],
            folder / table["dem"] if "dem" in table else None,
            table.get("mountains", {}),
            cells,
            layers,
            site,
        )
