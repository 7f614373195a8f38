"""A placement study: methods × regions × numbers of tasks × seeds, read from TOML with ``problem = "placement"``.

name = "placement"
problem = "placement"
seeds = 3                        # so many (0, 1, 2), or a list
time_limit = 60                  # [s] of every search
regions = ["square", "a.geojson"]   # the 20 km square, or GeoJSON files relative to this file
tasks = [10, 20, 40]
tests = "20x20"                  # as for `workbench place`; also signal_sd, length_scale, noise_sd, test_noise_sd

[[methods]]
name = "nlp"
options = { starts = 8 }
max_tasks = 40                   # larger problems are not given to this method
seeds = 1                        # overrides the study's
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from shapely.geometry import mapping

from formulations.routing.solver import Limits
from formulations.task_location.placement import PlacementProblem
from formulations.task_location.registry import make_method, method_class, option_defaults
from instances.environment.region import Region, single_polygon
from instances.errors import InputError, suggestion
from workbench.job import Job, file_safe
from workbench.placing import criterion_of, region_of, rows_of_tests
from workbench.study import seeds_from

KERNEL_KEYS = ("tests", "signal_sd", "length_scale", "noise_sd", "test_noise_sd")
STUDY_KEYS = ("name", "problem", "description", "seeds", "time_limit", "regions", "tasks", "methods", *KERNEL_KEYS)
METHOD_KEYS = ("name", "options", "max_tasks", "seeds")


@dataclass(frozen=True)
class Task:
    """One problem of a study as JSON values: what the child process rebuilds it from, and its name."""

    name: str
    polygon: dict[str, Any]
    setting: dict[str, Any]
    n_tasks: int

    @property
    def digest(self) -> str:
        """First 12 hexadecimal digits of the SHA-256 of everything but the name."""
        content = json.dumps([self.polygon, self.setting, self.n_tasks], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:12]

    @property
    def folder(self) -> str:
        """The problem's folder in a store."""
        return f"{file_safe(self.name)}-{self.digest}"

    def problem(self) -> PlacementProblem:
        """Build the problem; InputError says what is wrong with it."""
        region = Region(single_polygon(self.polygon))
        return PlacementProblem(region, criterion_of(region, **self.setting), self.n_tasks)

    def to_json(self) -> str:
        """Return the task as JSON."""
        return json.dumps({"schema": 1, "problem": "placement", **dataclasses.asdict(self)})


@dataclass(frozen=True)
class PlacementStudy:
    """What to run: problems, and jobs on each; `asked` is what the file says."""

    name: str
    tasks: tuple[Task, ...]
    jobs: tuple[tuple[Task, Job], ...]
    asked: dict[str, Any] = field(default_factory=dict)


def placement_study_from(data: dict[str, Any], *, name: str, base: Path) -> PlacementStudy:
    """Return the study written as `data`, files relative to `base`; InputError says what is wrong."""
    _known(data, STUDY_KEYS, "study")
    seeds = seeds_from(data.get("seeds", 1))
    limit = data.get("time_limit", 60)
    if not isinstance(limit, (int, float)) or isinstance(limit, bool):
        raise InputError(f"time_limit: must be a number of seconds, got {limit!r}")
    Limits(time=limit)
    setting = {key: data[key] for key in KERNEL_KEYS if key in data}
    setting |= {key: str(setting[key]) for key in ("tests", "length_scale") if key in setting}
    if str(setting.get("tests", "")).lower().endswith(".csv"):
        setting["tests"] = rows_of_tests(base / setting["tests"]).tolist()  # a store explains itself without the file
    tasks = tuple(_tasks(data, setting, base))
    methods = data.get("methods", [])
    if not isinstance(methods, list) or not methods or not all(isinstance(table, dict) for table in methods):
        raise InputError("study: names no methods ([[methods]] with name = …)")
    jobs = [
        (task, job)
        for task in tasks
        for number, table in enumerate(methods, 1)
        for job in _jobs(table, f"methods[{number}]", task, seeds, float(limit))
    ]
    return PlacementStudy(str(data.get("name", name)), tasks, tuple(jobs), data)


def _tasks(data: dict[str, Any], setting: dict[str, Any], base: Path) -> Iterator[Task]:
    regions = data.get("regions", ["square"])
    counts = data.get("tasks", [40])
    for region in regions if isinstance(regions, list) else [regions]:
        if not isinstance(region, str):
            raise InputError(f"regions: must be texts, got {region!r}")
        area = region_of(None if region == "square" else base / region)
        for count in counts if isinstance(counts, list) else [counts]:
            stem = region if region == "square" else Path(region).stem
            task = Task(f"{stem}-n{count}", json.loads(json.dumps(mapping(area.polygon))), setting, count)
            task.problem()  # refuse now what cannot be built later
            yield task


def _jobs(table: dict[str, Any], where: str, task: Task, seeds: tuple[int, ...], limit: float) -> Iterator[Job]:
    _known(table, METHOD_KEYS, where)
    if not isinstance(table.get("name"), str):
        raise InputError(f"{where}: 'name' is missing")
    name, options = table["name"], table.get("options", {})
    if not isinstance(options, dict):
        raise InputError(f"{where}.options: must be a table, got {options!r}")
    make_method(name, options)
    defaults = option_defaults(method_class(name))
    changed = {key: value for key, value in options.items() if value != defaults[key]}
    if task.n_tasks > table.get("max_tasks", task.n_tasks):
        return
    for seed in seeds_from(table["seeds"], f"{where}.seeds") if "seeds" in table else seeds:
        yield Job(task.folder, name, changed, seed, limit)


def _known(table: dict[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            raise InputError(f"{where}: unknown key '{key}'{suggestion(key, known)} (known: {', '.join(known)})")
