"""The item of a survey study: a field with the seed of its noise, over a region, perhaps in a wind, and a setting."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from formulations.kernel import SquaredExponential
from formulations.moving_cost.costing import query_of
from formulations.surveying.problem import SurveyProblem
from instances.disk import write_aside
from instances.environment.radio import RadioMap
from instances.environment.region import Region, single_polygon
from instances.environment.wind import WindField
from instances.errors import InputError
from instances.moving_cost import CostKind, CostMeasure
from instances.scenario import Scenario, read_scenario
from instances.scenario_folder import keep_scenario, kept_scenario
from reports.damage import reading
from reports.record import read_json

MOST_READINGS = 2000
"""Of all UAVs: a map's cost grows with their cube."""
MOST_CELLS = 1000
"""Along the longer side of the judged map."""
SAMPLED = 65
"""Points a side at which a wind enters the digest."""


@dataclass(frozen=True)
class Setting:
    """What a study says of all its items: SI units.

    cells : of the judged map along the region's longer side. The others are a study's keys of the same names.
    """

    depots: list[list[float]]
    endurance: float
    speed: float
    period: float
    noise_sd: float
    signal_sd: float
    length_scale: float
    cells: int


@dataclass(frozen=True, eq=False)
class SurveyItem:
    """A field with the seed of its noise, over a region (GeoJSON polygon [m]), and what is known before take-off.

    family : name of the field without its seed. wind : None in calm air.
    """

    family: str
    seed: int
    polygon: dict[str, Any]
    field: RadioMap
    setting: Setting
    wind: WindField | None = None

    def __post_init__(self) -> None:
        said, region = self.setting, self.problem.region
        if not (isinstance(said.cells, int) and 4 <= said.cells <= MOST_CELLS and said.noise_sd > 0):
            raise InputError(f"cells must be from 4 to {MOST_CELLS} and noise_sd positive, got {said}")
        most = said.endurance / said.period * len(said.depots)
        if not said.endurance / said.period >= 1.0 or not most <= MOST_READINGS:
            raise InputError(
                f"endurance {said.endurance:g} s and period {said.period:g} s make {most:.4g} readings of all UAVs; "
                f"each must take one, and all at most {MOST_READINGS}"
            )
        if not len(said.depots) or not region.contains(self.problem.depots).all():
            raise InputError("depots: there must be one, and all must lie in the region")

    def __reduce__(self) -> tuple[type[SurveyItem], tuple[Any, ...]]:
        """Pickle without what is cached."""
        return SurveyItem, (self.family, self.seed, self.polygon, self.field, self.setting, self.wind)

    @property
    def name(self) -> str:
        """Field, its seed and the endurance."""
        return f"{self.family}-s{self.seed}-{self.setting.endurance:g}s"

    @cached_property
    def digest(self) -> str:
        """First 12 hexadecimal digits of the SHA-256 of everything but the names."""
        h = hashlib.sha256(json.dumps([self.seed, self.polygon, asdict(self.setting)], sort_keys=True).encode())
        for array in (self.field.x, self.field.y, self.field.values):
            h.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
        if self.wind is not None:
            x0, y0, x1, y1 = self.problem.region.bounds
            lattice = np.meshgrid(np.linspace(x0, x1, SAMPLED), np.linspace(y0, y1, SAMPLED))
            wind = self.wind(np.stack(lattice, axis=-1).reshape(-1, 2))
            h.update(np.ascontiguousarray(wind, dtype="<f8").tobytes())
        return h.hexdigest()[:12]

    @cached_property
    def problem(self) -> SurveyProblem:
        """What a planner is given."""
        said = self.setting
        return SurveyProblem(
            Region(single_polygon(self.polygon)),
            np.array(said.depots, dtype=float).reshape(-1, 2),
            said.endurance * said.speed,
            said.period * said.speed,
            SquaredExponential(said.signal_sd, (said.length_scale, said.length_scale)),
            said.noise_sd,
            None if self.wind is None else CostMeasure(CostKind.ENERGY, self.wind, said.speed),
        )

    def load(self) -> SurveyItem:
        """Return itself: nothing is left to make."""
        return self

    def keep(self, path: Path) -> None:
        """Write the survey to `path`, its wind as a scenario beside it."""
        field = {"x": self.field.x.tolist(), "y": self.field.y.tolist(), "values": self.field.values.tolist()}
        content = {"family": self.family, "seed": self.seed, "polygon": self.polygon, "setting": asdict(self.setting)}
        windy = {} if self.wind is None else {"wind": True}
        if self.wind is not None:
            problem = self.problem
            where = Scenario("survey", problem.region, problem.depots, self.setting.speed, self.wind, n_tasks=1)
            keep_scenario(where, path.parent)
        kept = {"schema": 1, "problem": "survey", **content, **windy, "field": {**field, "unit": self.field.unit}}
        write_aside(path, json.dumps(kept))

    @classmethod
    def kept(cls, path: Path) -> SurveyItem:
        """Read what `keep` wrote to `path`; InputError where it is damaged."""
        with reading(path, "a survey"):
            data = read_json(path)
            wind = kept_scenario(path.parent).wind if data.get("wind") else None
            return cls(
                str(data["family"]),
                int(data["seed"]),
                data["polygon"],
                RadioMap(**data["field"]),
                Setting(**data["setting"]),
                wind,
            )


def scenario_to_survey(path: Path) -> Scenario:
    """Return the scenario in a file; InputError where surveys cannot be planned in it."""
    scenario = read_scenario(path)
    fleet = scenario.fleet
    if scenario.cost is not CostKind.ENERGY:
        raise InputError(f'{path}: cost is "{scenario.cost}", and surveys fly at constant ground speed: give "energy"')
    if not fleet.alike or fleet.endurance is not None:
        raise InputError(f"{path}: UAVs of a survey are alike and make no turns, and the study says endurance")
    query_of(replace(scenario, tasks=scenario.depots, n_tasks=0))  # the wind covers the region
    return scenario
