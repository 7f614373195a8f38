"""Products of a mission, read from the folders of its stages where they are asked for."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from instances.arrays import Floats
from instances.disk import read_json, read_text
from instances.environment.radio import RadioMap
from instances.environment.terrain import Terrain
from instances.errors import InputError
from instances.files import read_instance
from instances.formats.netcdf import read_grids
from instances.instance import Instance
from instances.scenario import Scenario
from instances.scenario_folder import kept_field, kept_scenario, kept_terrain
from reports.figures.field import Extent, extent_of

FOLDERS = ("environment", "place", "costs", "routes", "flight", "map", "compare")
"""The stages that have products."""


@dataclass(frozen=True, eq=False)
class Maps:
    """The maps that were kept: `time` (k,) [s]; cell centres x (nx,), y (ny,) [m]; mean and sd (k, ny, nx); truth."""

    time: Floats
    x: Floats
    y: Floats
    mean: Floats
    sd: Floats
    truth: Floats

    @property
    def extent(self) -> Extent:
        """Borders of the cells."""
        return extent_of(self.x, self.y)


@dataclass(frozen=True, eq=False)
class Products:
    """A mission's products, read where they are asked for. `folders` maps stages to their folders."""

    folders: dict[str, Path]

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario, its wind as it was solved."""
        return kept_scenario(self.folders["environment"])

    @cached_property
    def terrain(self) -> Terrain | None:
        """The ground, or None."""
        return kept_terrain(self.folders["environment"])

    @cached_property
    def field(self) -> RadioMap:
        """The field that was measured."""
        return kept_field(self.folders["environment"])

    @cached_property
    def unit(self) -> str:
        """Unit of the field."""
        return self.field.unit

    @cached_property
    def instance(self) -> Instance:
        """Tasks, depots and moving costs."""
        return read_instance(self.folders["costs"] / "instance.json")

    @cached_property
    def maps(self) -> Maps:
        """The maps that were kept, the last included."""
        over = dict.fromkeys(("mean", "sd"), ("time", "y", "x")) | {"truth": ("y", "x")}
        axes, values = read_grids(self.folders["map"] / "maps.nc", over)
        arrays = (values[name].values for name in ("mean", "sd", "truth"))
        return Maps(axes["time"], axes["x"], axes["y"], *arrays)

    def table(self, stage: str, file: str) -> pd.DataFrame:
        """Return a CSV product as a frame."""
        path = self.folders[stage] / file
        try:
            return pd.read_csv(io.StringIO(read_text(path)))
        except InputError:
            raise
        except ValueError as error:
            raise InputError(f"{path}: cannot be read as a table ({error})") from None

    def values(self, stage: str, file: str) -> Any:
        """Return a JSON product."""
        return read_json(self.folders[stage] / file)
