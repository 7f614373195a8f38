"""Products of a mission, read from the folders of its stages where they are asked for.

Each is checked as it is read: what is missing, no number or of another shape is an InputError that names the file.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instances.arrays import Floats
from instances.environment.radio import RadioMap
from instances.environment.radio_changing import ChangingField
from instances.environment.terrain import Terrain
from instances.environment.value_map import ValueMap
from instances.errors import InputError, naming
from instances.files import read_instance
from instances.formats.netcdf import read_grids
from instances.instance import Instance
from instances.scenario import Scenario
from instances.scenario_folder import kept_field, kept_scenario, kept_terrain, kept_value_map
from reports.damage import reading
from reports.figures.field import Extent, extent_of
from reports.kinds import is_number
from reports.numbers import missing
from reports.product_tables import LARGEST, read_table
from reports.record import Run, read_json, read_run
from reports.verdicts import MISSION

FOLDERS = ("environment", "place", "costs", "routes", "flight", "map", "compare")
"""The stages that have products."""

POLISHED = ("costs_before", "costs_after", "budgets", "lengths_before", "lengths_after")
"""Of ``polish.json``, a number of each UAV."""


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
        with reading(self.folders["environment"] / "scenario.toml", "a scenario"):
            return kept_scenario(self.folders["environment"])

    @cached_property
    def terrain(self) -> Terrain | None:
        """The ground, or None."""
        with reading(self.folders["environment"] / "terrain.nc", "the ground"):
            return kept_terrain(self.folders["environment"])

    @cached_property
    def field(self) -> RadioMap:
        """The field that was measured, at take-off."""
        kept = self._kept_field
        return kept.at(0.0) if isinstance(kept, ChangingField) else kept

    @cached_property
    def field_lasts(self) -> float | None:
        """When the last frame of a field that changes is [s]; None where it has none."""
        return self._kept_field.lasts if isinstance(self._kept_field, ChangingField) else None

    @cached_property
    def _kept_field(self) -> RadioMap | ChangingField:
        with reading(self.folders["environment"] / "field.nc", "a field"):
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
        path = self.folders["map"] / "maps.nc"
        with reading(path, "maps"):
            axes, values = read_grids(path)
            maps = Maps(axes["time"], axes["x"], axes["y"], *(values[name].values for name in ("mean", "sd", "truth")))
            _check_maps(maps)
            return maps

    @cached_property
    def ticks(self) -> pd.DataFrame:
        """What the map was worth over time, a row a tick, those of the kept maps among them."""
        ticks = self.table("map", "ticks.csv").drop_duplicates("time")
        if not np.isin(self.maps.time, ticks["time"]).all():
            raise InputError(f"{self.folders['map'] / 'ticks.csv'}: has no row for some of the maps kept beside it")
        return ticks

    @cached_property
    def compared(self) -> pd.DataFrame:
        """The plans compared, a row each, the mission first."""
        table = self.table("compare", "compare.csv")
        if table["name"].iloc[0] != MISSION or table["name"].duplicated().any():
            raise InputError(f"{self.folders['compare'] / 'compare.csv'}: must have a row a plan, the mission first")
        return table

    @cached_property
    def draws(self) -> pd.DataFrame:
        """Every plan over every draw of field and noise; `refused` is "" where it may be flown."""
        table = self.table("compare", "compare-draws.csv")
        with reading(self.folders["compare"] / "compare-draws.csv", "draws"):
            table["refused"] = ["" if missing(why) else str(why) for why in table["refused"]]
            of = {name: sorted(rows["draw"]) for name, rows in table.groupby("name", sort=False)}
            if list(of) != list(self.compared["name"]) or any(each != of[MISSION] for each in of.values()):
                raise InputError("must have a row for each plan of compare.csv and each draw")
        return table

    @cached_property
    def over(self) -> str:
        """Over what the draws are, in words."""
        path = self.folders["compare"] / "compare.json"
        with reading(path, "a comparison"):
            return str(read_json(path)["over"])

    def of_plans(self, file: str) -> pd.DataFrame:
        """Return a table about the plans compared, without rows of others."""
        return self.table("compare", file).merge(self.compared[["name"]], on="name")

    @cached_property
    def placement(self) -> dict[str, Any]:
        """What the placing of tasks said: method and points; of a method's own also what they are worth."""
        path = self.folders["place"] / "placement.json"
        with reading(path, "a placement"):
            said: dict[str, Any] = read_json(path)
            numbers: tuple[str, ...] = () if said["method"] == "given" else ("mutual_information",)
            numbers += ("certificate", "ratio") if said.get("certificate") else ()
            numbers += ("average_variance", "average_variance_bound") if "average_variance" in said else ()
            if not all(is_number(said[name]) for name in numbers) or not isinstance(said["points"], list):
                raise InputError("must hold points and finite numbers")
            return said

    @cached_property
    def value_maps(self) -> dict[str, ValueMap | None]:
        """How much places count, ``weights``, and what was known of them, ``prior_sd``; None where nothing was told."""
        folder = self.folders["place"]
        with reading(folder, "maps of values"):
            return {name: kept_value_map(name, folder) for name in ("weights", "prior_sd")}

    @cached_property
    def routes(self) -> Run:
        """The run that made the routes."""
        path = self.folders["routes"] / "run.json"
        with naming(path):
            run = read_run(path)
            if run.objective is None:
                raise InputError("holds no routes")
            return run

    @cached_property
    def bound(self) -> dict[str, Any]:
        """What bounds the routes: numbers `objective`, `bound` [s] and `gap`, and `by` whom."""
        path = self.folders["routes"] / "bound.json"
        with reading(path, "a bound"):
            said: dict[str, Any] = read_json(path)
            if not all(is_number(said[name]) for name in ("objective", "bound", "gap")):
                raise InputError("must hold finite numbers")
            return said | {"by": str(said["by"])}

    @cached_property
    def selection(self) -> dict[str, Any] | None:
        """What was left out because endurance does not suffice; None where all tasks are flown."""
        path = self.folders["routes"] / "selection.json"
        if not path.exists():
            return None
        with reading(path, "a selection"):
            said: dict[str, Any] = read_json(path)
            if not all(is_number(said[name]) for name in ("worth", "bound", "everything")):
                raise InputError("must hold finite numbers")
            return said | {"left_out": [int(task) for task in said["left_out"]]}

    @cached_property
    def spacing(self) -> dict[str, Any] | None:
        """The spacing `ratio`, the turning `radius` [m], `advice` in words and whether the plan is `coupled`.

        None where an older version made the flights.
        """
        path = self.folders["flight"] / "spacing.json"
        if not path.exists():
            return None
        with reading(path, "a spacing ratio"):
            said: dict[str, Any] = read_json(path)
            if not (is_number(said["ratio"]) and is_number(said["radius"])):
                raise InputError("must hold finite numbers")
            return said | {"advice": str(said["advice"]), "coupled": bool(said["coupled"])}

    @cached_property
    def headings(self) -> dict[str, Any] | None:
        """The longest tours [s] of the plans whose headings were chosen, `longest`, and which is flown, `by`.

        A plan that cannot be flown has None. The whole is None where headings were not planned with the routes.
        """
        path = self.folders["routes"] / "headings.json"
        if not path.exists():
            return None
        with reading(path, "headings"):
            said: dict[str, Any] = read_json(path)
            longest = {str(name): time for name, time in said["longest"].items()}
            if not all(time is None or is_number(time) for time in longest.values()):
                raise InputError("must hold finite numbers")
            return {"longest": longest, "by": str(said["by"])}

    @cached_property
    def laps(self) -> dict[str, Any] | None:
        """Laps of each UAV, `turned` saying which way round; None where each tour is flown once, as it was routed.

        sd, unturned_sd : what these promise at the end and what they would unturned, None where nothing drifts.
        """
        path = self.folders["flight"] / "laps.json"
        if not path.exists():
            return None
        with reading(path, "laps"):
            said: dict[str, Any] = read_json(path)
            if not all(said[name] is None or is_number(said[name]) for name in ("sd", "unturned_sd")):
                raise InputError("must hold finite numbers")
            return said | {"turned": [[bool(turn) for turn in each] for each in said["turned"]]}

    @cached_property
    def replans(self) -> dict[str, Any] | None:
        """What re-planning did in flight; None where none was asked for."""
        path = self.folders["map"] / "replans.json"
        if not path.exists():
            return None
        with reading(path, "re-plans"):
            said: dict[str, Any] = read_json(path)
            for row in said["replans"]:
                promised = [row[name] for name in ("sd_before", "sd_after") if row[name] is not None]
                if not all(map(is_number, (row["time"], row["samples"], *row["length_scales"], *promised))):
                    raise InputError("must hold finite numbers")
                if len(row["length_scales"]) != 2 or not all(isinstance(row[name], str) for name in ("reason", "why")):
                    raise InputError("re-plans have two length_scales, a reason and a why")
            if not said["budgets"] or not all(map(is_number, said["budgets"])):
                raise InputError("budgets must be finite numbers")
            return said | {"late": [str(words) for words in said["late"]]}

    @property
    def flown(self) -> pd.DataFrame:
        """The tracks as they were flown in the end: re-planned, or as at take-off."""
        return self.table("flight" if self.replans is None else "map", "flown.csv")

    @cached_property
    def static_plan(self) -> dict[str, float] | None:
        """What a plan for the wind of take-off is worth [s], as ``static.json`` says; None where the wind stays."""
        path = self.folders["compare"] / "static.json"
        if not path.exists():
            return None
        with reading(path, "a static plan"):
            said = read_json(path)
            found = {name: said[name] for name in ("promised", "taken", "directed", "clocked")}
            if not all(is_number(value) and value > 0 for value in found.values()):
                raise InputError("must hold positive numbers")
            return found

    @cached_property
    def ensemble(self) -> dict[str, Any] | None:
        """What the longest tour takes over an ensemble's members [s]; None where there is none.

        Where routes were chosen by a `risk` it also says what others, `without` it, would take.
        """
        path = self.folders["routes"] / "ensemble.json"
        if not path.exists():
            return None
        with reading(path, "an ensemble"):
            said: dict[str, Any] = read_json(path)
            for spread in (said, said["without"]) if "risk" in said else (said,):
                numbers = [*spread["members"], *(spread[name] for name in ("planned", "mean", "worst", "cvar"))]
                if not spread["members"] or not all(map(is_number, numbers)):
                    raise InputError("must hold members and finite numbers")
            return said

    @cached_property
    def polish(self) -> dict[str, Any] | None:
        """What path polish did, as ``polish.json`` says, a list's entries being UAVs; None where tours stayed."""
        path = self.folders["flight"] / "polish.json"
        if not path.exists():
            return None
        with reading(path, "a path polish"):
            said: dict[str, Any] = read_json(path)
            lists = [said[name] for name in POLISHED]
            single = [said[name] for name in ("rms_sd_before", "rms_sd_after", "bound", "samples_after")]
            if not all(is_number(value) for value in (*single, *chain.from_iterable(lists))):
                raise InputError("must hold finite numbers")
            if not said["rms_sd_before"] > 0 or len({len(each) for each in (*lists, said["endurance_given"])}) != 1:
                raise InputError("must hold a positive rms_sd_before and as many values of each UAV")
            return said

    @cached_property
    def flown_tasks(self) -> Floats:
        """Where tasks are as they are flown (n, 2) [m]: moved by path polish, or as they were placed."""
        if self.polish is None:
            return self.table("place", "tasks.csv")[["x", "y"]].to_numpy()
        waypoints = self.table("flight", "polished.csv")
        return waypoints.loc[waypoints["task"] >= 0, ["x", "y"]].to_numpy()

    @cached_property
    def field_tau(self) -> float | None:
        """In what time the correlation of the field that is measured falls to 1/e [s]; None where it stays."""
        path = self.folders["environment"] / "environment.json"
        with reading(path, "an environment"):
            tau = read_json(path)["field"].get("tau")
            if tau is not None and not (is_number(tau) and tau > 0):
                raise InputError("tau of the field must be a positive number")
            return tau if tau is None else float(tau)

    @cached_property
    def map_model(self) -> dict[str, Any] | None:
        """What the last map believes and the likelihoods that it was chosen by; None in missions made before these."""
        path = self.folders["map"] / "model.json"
        if not path.exists():
            return None
        with reading(path, "a map's model"):
            said: dict[str, Any] = read_json(path)
            found = [row["log_likelihood"] for row in said["evidence"]]
            found += [*said["length_scales"], *said["coefficients"], said["signal_sd"], said["nugget_sd"]]
            found += [said[name] for name in ("tau", "drift", "direction", "contrast", "in_sight") if name in said]
            if len(said["length_scales"]) != 2 or not all(is_number(value) for value in found):
                raise InputError("must hold finite numbers")
            scales = [*said["length_scales"], *(said[name] for name in ("tau", "contrast") if name in said)]
            if not all(scale > 0 for scale in scales):
                raise InputError("length_scales, tau and contrast must be positive")
            names = [said, *said["evidence"]]
            if not all(isinstance(each[key], str) for each in names for key in ("kernel", "mean")):
                raise InputError("kernel and mean must be names")
            return said

    def table(self, stage: str, file: str) -> pd.DataFrame:
        """Return a CSV product as a frame, its `NUMBERS` being numbers."""
        return read_table(self.folders[stage] / file)


def _check_maps(maps: Maps) -> None:
    """Raise InputError where the arrays do not fit together or hold nothing."""
    shape = (len(maps.y), len(maps.x))
    for axis, least in ((maps.time, 1), (maps.x, 2), (maps.y, 2)):
        if len(axis) < least or not (np.abs(axis) <= LARGEST).all() or (np.diff(axis) <= 0).any():
            raise InputError("an axis does not increase, or is too short")
    for values, wanted in (
        (maps.mean, (len(maps.time), *shape)),
        (maps.sd, (len(maps.time), *shape)),
        (maps.truth, shape),
    ):
        if values.shape != wanted:
            raise InputError(f"the maps have the shape {values.shape}, their axes {wanted}")
        inside = ~np.isnan(values)
        if not inside.any(axis=(-2, -1)).all() or (np.abs(values[inside]) > LARGEST).any():
            raise InputError("a map is empty or not finite")
