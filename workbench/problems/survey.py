"""The survey problem: where UAVs fly and measure within endurance so that the map of a field is best.

The objective of a run is the RMSE of the map, in the field's unit. The parent flies every tour again, draws the noise
itself, by seed, UAV and number of the reading, and fits the map as it does for everyone; a plan that changes in flight
gets its readings in the child, with the same noise.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from shapely.geometry import mapping

from formulations.limits import Limits
from formulations.mapping.map_grid import MapGrid
from formulations.surveying.problem import Sensor, SurveyPlanner, readings
from formulations.surveying.registry import PLANNERS
from formulations.surveying.verification import Worth, reading_faults, tour_faults, worth_of
from formulations.task_location.setting import site_of
from instances.arrays import Floats
from instances.errors import InputError
from reports.record import ITEM_FILES, Run, study_title
from workbench.jobs.check import check_runs
from workbench.jobs.problem import Claim, Listener, Outputs, Problem, Published, Source
from workbench.jobs.study_table import listed
from workbench.problems.publishing import published, without
from workbench.problems.survey_fields import fields_of
from workbench.problems.survey_item import Setting, SurveyItem, scenario_to_survey
from workbench.problems.tables import SurveyTable
from workbench.summary import Summary

if TYPE_CHECKING:
    from reports.columns import Column
    from reports.pages.survey import SurveyCase

TOLERANCE = 1e-3
"""Relative: what is stored of a map further from the re-computed figure is refuted; fits differ so much by machine."""
FIGURES = ("rmse", "nlpd", "coverage", "promised_sd", "information", "length", "longest", "readings")
"""What is re-computed of every plan."""


class SurveyStudy(Problem[SurveyItem]):
    """Fields, and plans that are flown over them."""

    name = "survey"
    methods = PLANNERS
    item = "survey"
    entries = "methods"
    study = SurveyTable
    default_limit = 60.0
    product = dict[str, list[Any]]
    found = "tours"
    statuses = ("FEASIBLE",)
    outputs = ("figures",)

    def sources(self, study: SurveyTable, base: Path) -> Iterable[Source[SurveyItem]]:
        """Return every field with every seed and endurance."""
        said = {each.name: getattr(study, each.name) for each in fields(Setting)}
        if study.scenario is None:
            site = site_of(None if study.region == "square" else base / study.region)
            region, wind = site.region, None
        else:
            plain = SurveyTable()
            if taken := [key for key in ("region", "depots", "speed") if getattr(study, key) != getattr(plain, key)]:
                raise InputError(f"{taken[0]}: the scenario says it; leave it out of the study")
            scenario = scenario_to_survey(base / study.scenario)
            site, region, wind = scenario.site, scenario.free, scenario.wind
            said |= {"depots": scenario.depots.tolist(), "speed": scenario.speed}
        polygon = json.loads(json.dumps(mapping(region.polygon)))
        said["depots"] = [list(depot) for depot in said["depots"]]
        for table in study.fields:
            for family, seed, field in fields_of(table, base, site):
                for endurance in listed(study.endurance):
                    yield SurveyItem(family, seed, polygon, field, Setting(**said | {"endurance": endurance}), wind)

    def size(self, item: SurveyItem) -> int:
        """Return the most readings that all UAVs can take."""
        return int(item.setting.endurance / item.setting.period + 1e-9) * len(item.setting.depots)

    def write(self, item: SurveyItem, folder: Path) -> None:
        """Keep field, region and setting."""
        path = folder / ITEM_FILES[self.name][0]
        if not path.exists():
            item.keep(path)

    def read(self, folder: Path) -> SurveyItem:
        """Return the survey kept in `folder`."""
        return SurveyItem.kept(folder / ITEM_FILES[self.name][0])

    def describe(self, item: SurveyItem) -> dict[str, Any]:
        """Return name, digest, size and the field's name."""
        sizes = {"n_tasks": self.size(item), "n_depots": len(item.setting.depots)}
        return {"name": item.name, "digest": item.digest, **sizes, "family": item.family}

    def accepts(self, method: SurveyPlanner, item: SurveyItem) -> str | None:
        """Ask the planner."""
        return method.accepts(item.problem)

    def prepare(self, method: SurveyPlanner, item: SurveyItem) -> None:
        """Let the planner import and compile."""
        method.prepare(item.problem)

    def solve(
        self, method: SurveyPlanner, item: SurveyItem, limits: Limits, seed: int, tell: Listener, start: Any
    ) -> Claim:
        """Plan, and fly as far as the plan asks for readings."""
        sensor = Sensor(item.field, item.setting.noise_sd, item.seed)
        tours = [np.asarray(tour, float) for tour in method.plan(item.problem, sensor, limits=limits, seed=seed)]
        samples = [readings(tour, item.problem.spacing).tolist() for tour in tours]
        product = {"tours": [tour.tolist() for tour in tours], "samples": samples, "read": sensor.log}
        return Claim(product, None, status="FEASIBLE", stopped_by="finished")

    def judge(self, item: SurveyItem, product: Any, claimed: float | None) -> tuple[float | None, str]:
        """Return the RMSE of the map of tours that can be flown, and what is wrong with them."""
        try:
            tours, samples, read = flown(product)
        except (KeyError, TypeError, ValueError) as error:
            return None, f"sent tours that cannot be read ({type(error).__name__}: {error})"
        faults = tour_faults(item.problem, tours, samples) or reading_faults(item.problem, tours, read)
        if faults:
            return None, "; ".join(faults)
        if not any(map(len, samples)):
            return None, "measured nothing"
        return _worth(item, json.dumps(product["tours"])).score.rmse, ""

    def refute_ending(self, item: SurveyItem, claim: Claim, objective: float | None) -> str:
        """Return that there are no tours where there are none."""
        return "" if claim.product is not None else "ended without tours"

    def own_columns(self, item: SurveyItem, product: Any) -> dict[str, Any]:
        """Return the tours and what the judge found."""
        about = {"endurance": item.setting.endurance, "unit": item.field.unit}
        if product is None:
            return {"tours": None, "samples": None, "read": [], **dict.fromkeys((*FIGURES, "model")), **about}
        worth = _worth(item, json.dumps(product["tours"]))
        return {**product, **_figures(worth), "model": worth.model, **about}

    def spell(self, run: Run) -> str:
        """Return the RMSE with its unit."""
        return "no tours" if run.objective is None else f"RMSE {run.objective:.4g} {run.own['unit']}".rstrip()

    def check(self, folder: Path) -> tuple[str, list[str]]:
        """Fly, measure and map every stored plan again."""
        runs, items, problems = check_runs(self, folder, lambda item: [], _false_claims)
        return f"{runs} survey runs on {items} surveys", problems

    def columns(self) -> Sequence[Column]:
        """Return the columns of the summary."""
        from reports.columns import SURVEYS

        return SURVEYS

    def publish(self, folders: list[Path], outputs: Outputs) -> Published:
        """Put the plans side by side over the fields of each name and endurance."""
        from reports.pages.survey import write_survey_page
        from reports.stores import read_runs
        from reports.surveys import survey_frame, survey_summary, survey_verdicts

        runs, damaged = read_runs(*folders, problem=self.name)
        frame = survey_frame(runs)
        verdicts = survey_verdicts(frame)
        title = f"Surveys: {study_title(folders)}"
        failed = frame["rmse"].isna() & (frame["stopped_by"] != "declined")
        return published(
            outputs,
            frame,
            frame["code"],
            lambda: [Summary(self.name, self.columns(), survey_summary(frame, verdicts), 3)],
            without("tours", failed),
            damaged,
            lambda page, figures: write_survey_page(_cases(runs, damaged), frame, verdicts, runs, page, title, figures),
        )


SURVEY = SurveyStudy()


def flown(product: Any) -> tuple[list[Floats], list[Floats], list[tuple[int, int, float, float]]]:
    """Return tours, samples (k, 2) [m] and readings in flight of a product; ValueError or the like where it is none."""
    tours, samples = (
        [np.array(each, dtype=float).reshape(-1, 2) for each in product[name]] for name in ("tours", "samples")
    )
    return tours, samples, [(int(uav), int(tick), float(x), float(y)) for uav, tick, x, y in product["read"]]


@lru_cache(maxsize=8)
def _worth(item: SurveyItem, tours: str) -> Worth:
    """Return what `tours` (JSON) are worth: asked for by `judge` and again by `own_columns`."""
    polylines = [np.array(tour, dtype=float).reshape(-1, 2) for tour in json.loads(tours)]
    points = MapGrid.over(item.problem.region, item.setting.cells).points
    return worth_of(item.problem, polylines, item.field, points, item.seed)


def _figures(worth: Worth) -> dict[str, float]:
    told = {**asdict(worth), **asdict(worth.score), "readings": worth.samples}
    return {name: told[name] for name in FIGURES}


def _false_claims(item: SurveyItem, run: Run) -> list[str]:
    own = run.own
    if own["tours"] is None or own["samples"] is None:
        return [] if run.objective is None else ["states an RMSE, but has no tours"]
    objective, fault = SURVEY.judge(item, own, run.objective)
    if objective is None:
        return [fault]
    actual = _figures(_worth(item, json.dumps(own["tours"])))
    stated = {**{name: own[name] for name in FIGURES}, "objective": run.objective}
    return [
        f"states {name} = {claim!r}, but recomputed it is {actual.get(name, objective)!r}"
        for name, claim in stated.items()
        if not _close(claim, actual.get(name, objective))
    ]


def _close(claim: Any, actual: float) -> bool:
    if not isinstance(claim, (int, float)) or isinstance(claim, bool):
        return False
    return bool(abs(claim - actual) <= TOLERANCE * max(abs(actual), 1e-9))


def _cases(runs: Mapping[Path, Run], damaged: list[str]) -> list[SurveyCase]:
    """Return for each name of fields and endurance the plans over its first survey; what is unreadable is `damaged`."""
    from reports.figures.survey import FlownPlan
    from reports.pages.survey import SurveyCase

    folders: dict[tuple[str, float], Path] = {}
    for path, run in sorted(runs.items(), key=lambda each: (each[1].instance["name"], each[0])):
        folders.setdefault((str(run.instance.get("family")), run.own["endurance"]), path.parent)
    cases = []
    for folder in folders.values():
        try:
            item = SURVEY.read(folder)
        except InputError as error:
            damaged.append(f"{error}; left alone.")
            continue
        best: dict[str, Run] = {}
        for path, run in runs.items():
            if path.parent == folder and run.objective is not None and not _false_claims(item, run):
                best.setdefault(run.label, run)
        ranked = sorted(best.values(), key=lambda run: run.objective or 0.0)
        plans = [FlownPlan(run.label, run.objective or 0.0, *flown(run.own)[:2]) for run in ranked]
        if plans:
            cases.append(SurveyCase(item.name, item.field, item.problem.region, item.problem.depots, plans))
    return cases
