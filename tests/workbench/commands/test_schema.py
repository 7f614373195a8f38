"""JSON Schemas of the file formats: they accept what the workbench ships and writes, and refuse what it refuses."""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from instances import Instance
from instances.declared.reading import read_declared
from instances.errors import InputError
from instances.families import make_scenario
from instances.files import write_instance
from instances.formats.native import instance_of
from instances.scenario import scenario_of, write_scenario
from instances.travel import Travel
from reports.record import run_from
from workbench.commands.init import template
from workbench.formats import FORMATS, json_schema
from workbench.jobs.study import shipped_studies, study_from
from workbench.mission.file import mission_of, shipped_missions
from workbench.problems import PROBLEMS


@cache
def validator(name: str) -> Draft202012Validator:
    schema = json_schema(name)
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def faults(name: str, document: Any) -> list[str]:
    return [error.message for error in validator(name).iter_errors(document)]


SHIPPED = [("study", path) for path in shipped_studies().values()]
SHIPPED += [("mission", path) for path in shipped_missions().values()]


@pytest.mark.parametrize(("name", "path"), SHIPPED, ids=lambda each: getattr(each, "stem", each))
def test_what_is_shipped_is_valid(name: str, path: Path) -> None:
    assert faults(name, tomllib.loads(path.read_text())) == []


@pytest.mark.parametrize("name", ["study", "scenario", "mission"])
def test_templates_are_valid(name: str) -> None:
    assert faults(name, tomllib.loads(template(name, "mine"))) == []


@pytest.mark.parametrize("family", ["uniform", "wind-vortices", "wind-uniform", "mixed-fleet"])
def test_scenarios_that_are_written_are_valid(tmp_path: Path, family: str) -> None:
    write_scenario(make_scenario(family, 6, 2, seed=1), tmp_path / "a.toml")
    assert faults("scenario", tomllib.loads((tmp_path / "a.toml").read_text())) == []


def test_instances_that_are_written_are_valid(tmp_path: Path) -> None:
    cost = np.array([[0.0, 1, 2], [3, 0, 4], [5, 6, 0]])
    travel = Travel(np.array([[cost], [np.where(cost == 4, np.inf, cost)]]), np.array([0, 1]))
    limits = np.array([9.0, np.inf])
    for made in (
        Instance("plain", cost, 2, 1, np.eye(3)[:, :2], {"family": "x"}),
        Instance.of_travel("fleet", travel, 1, endurance=limits),
    ):
        write_instance(made, tmp_path / "a.json")
        assert faults("instance", json.loads((tmp_path / "a.json").read_text())) == []


SCENARIO = {
    "name": "s",
    "ground_speed": 20.0,
    "size": [100, 50.5],
    "depots": [[0, 0], [100, 50.5]],
    "tasks": [[1, 2], [3.5, 4]],
    "service": 3.0,
    "return": "any",
    "uav": [{"depot": 0, "count": 2, "speed": 3.0}, {"depot": 1, "endurance": 50.0}],
    "wind": {"kind": "sum", "parts": [{"kind": "shear", "rate": 0.1}, {"kind": "uniform", "velocity": [1, 2]}]},
    "radio": {"position": [1, 2], "height": 3.0},
    "origin": [47.0, 8.0],
    "provenance": {"by": "hand"},
}
STUDY = {
    "name": "s",
    "seeds": 2,
    "time_limit": [1, 2.5],
    "threads": 2,
    "files": ["a.json"],
    "families": [{"family": "uniform", "tasks": [4, 5], "depots": 2, "seeds": [1], "parameters": {"wind": "none"}}],
    "solvers": [{"name": "greedy", "options": {"variant": "nearest"}, "max_tasks": 9, "seeds": 3, "iterations": 0}],
}
PLACEMENT = {
    "problem": "placement",
    "regions": "square",
    "tasks": 3,
    "tests": "3x3",
    "length_scale": 4000,
    "noise_sd": 0.5,
    "methods": [{"name": "greedy", "time_limit": 3.0}],
}
MOVING = {"problem": "moving-cost", "scenarios": ["a.toml"], "starts": 2, "methods": [{"name": "dijkstra"}]}
SURVEY = {
    "problem": "survey",
    "endurance": [300, 492.0],
    "depots": [[500.0, 500.0]],
    "fields": [{"kind": "gp", "seeds": [1, 2], "length_scale": 900.0}, {"kind": "file", "file": "a.nc", "unit": "K"}],
    "methods": [{"name": "myopic", "options": {"within": 2.0}}],
}
MISSION = {
    "airspeed": 100.0,
    "size": [4000, 4000],
    "depots": [[500, 500], [3500, 500]],
    "tasks": 6,
    "radio": {"position": [2000, 2000]},
    "place": {"method": "greedy", "options": {}, "criterion": "a", "tests": [9, 9], "length_scale": [3000.0, 2000.0]},
    "flight": {"speed": 30.0, "frame": "above-home", "endurance": 900.0},
    "map": {"refit_every": 3},
    "compare": {"baselines": ["random"], "seeds": 2},
    "export": {"firmware": "px4"},
}
INSTANCE = {
    "schema": 1,
    "name": "a",
    "n_tasks": 2,
    "n_depots": 1,
    "cost": [[0, 1, 2], [3, 0, 4], [5, 6, 0]],
    "coordinates": [[0, 0], [1, 1], [2, 2]],
    "provenance": {},
    "travel": {"cost": [[[[0, 1, 2], [3, 0, 4], [5, 6, 0]]]], "classes": [0], "departures": [0.0], "nodes": [0, 1, 2]},
    "endurance": [9.5],
}
METRIC = {
    **INSTANCE,
    "travel": None,
    "cost": {"metric": "wind", "airspeed": 20, "wind": {"kind": "shear", "rate": 0.1}},
}
RUN = {
    "schema": 1, "instance": {"name": "i", "digest": "d", "n_tasks": 3}, "solver": "s", "seed": 0, "time_limit": 1.0,
    "status": "FEASIBLE", "objective": 1.0, "bound": None, "options": {"a": 1}, "elapsed": 0.5, "proves": True,
    "trace": [[0.1, 2.0, None]], "routes": [[0, 1], [2]], "tour_costs": [1.0, 0.5],
}  # fmt: skip
PLACED = {**RUN, "problem": "placement", "certificate": 2.0, "points": [[1, 2]], "information": {"b": 1.0}}
MOVED = {**RUN, "problem": "moving-cost", "cost": [[0, 1], [1, 0]], "paths": {"offsets": [0, 0, 2], "points": [[0, 1]]}}
SURVEYED = {**RUN, "problem": "survey", "tours": [[[1, 2], [3, 4]], []], "read": [[0, 1, 2.0, 3.0]], "rmse": 0.5}
BASES = {
    "scenario": [SCENARIO],
    "study": [STUDY, PLACEMENT, MOVING, SURVEY],
    "mission": [MISSION],
    "instance": [INSTANCE, METRIC],
    "run": [RUN, PLACED, MOVED, SURVEYED],
}
VALUES = ["x", "", -1, 1.5, True, None, [], {}, [[1, 2]], [{"a": 1}], 10**25]
FLOATS = [1e300, -1e300]
"""Only where a number need not be whole: JSON Schema counts 1e300 and 1.0 as whole numbers, the workbench does not."""


def places(value: Any) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every value inside a document."""
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield (key,)
        yield from ((key, *rest) for rest in places(value[key]))


def mutated(document: Any, toml: bool) -> Iterator[Any]:
    """Yield the document with each value replaced by others, left out, and misspelt; TOML has no null."""
    for path in places(document):
        old = document
        for key in path:
            old = old[key]
        values = [value for value in VALUES if value is not None or not toml]
        for value in (*values, *(FLOATS if isinstance(old, float) else ()), "left out", "misspelt"):
            changed = copy.deepcopy(document)
            *way, last = path
            inside = changed
            for key in way:
                inside = inside[key]
            if value not in ("left out", "misspelt"):
                inside[last] = value
            elif isinstance(last, str):
                kept = inside.pop(last)
                if value == "misspelt":
                    inside[f"{last}x"] = kept
            yield changed


def declared(name: str, document: Any) -> Any:
    """Return the declaration of the format that `document` is to be read as."""
    kinds, by = FORMATS[name].kinds(), FORMATS[name].by
    return kinds.get(str(document.get(by)), next(iter(kinds.values()))) if by else kinds[""]


@pytest.mark.parametrize("name", BASES)
def test_the_schema_refuses_what_the_declaration_refuses_and_nothing_else(name: str) -> None:
    """The name of a file is a matter of more than its letters, and of costs and travel one must be there."""
    weaker = ("name", "cost", "travel")
    for base in BASES[name]:
        assert faults(name, base) == []
        for document in mutated(base, FORMATS[name].toml):
            if any(document.get(key) != base.get(key) for key in weaker):
                continue
            try:
                read_declared(declared(name, document), document, toml=FORMATS[name].toml)
                refused = ""
            except InputError as error:
                refused = str(error)
            assert bool(refused) == (not validator(name).is_valid(document)), (refused, document)


READERS = {
    "scenario": lambda table: scenario_of(table, Path(), "s"),
    "mission": lambda table: mission_of(table, Path(), "m"),
    "instance": instance_of,
    "run": run_from,
    "study": lambda table: study_from(table, PROBLEMS.load(table.get("problem", "routing")), name="s", base=Path()),
}
RELATIONS: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
    ("scenario", SCENARIO, {"region": "a.kml"}),
    ("scenario", SCENARIO, {"size": None}),
    ("scenario", SCENARIO, {"airspeed": 3.0}),
    ("scenario", SCENARIO, {"cost": "time"}),
    ("scenario", SCENARIO, {"depots": None}),
    ("scenario", SCENARIO, {"tasks": None}),
    ("scenario", SCENARIO, {"name": "a/b"}),
    ("scenario", SCENARIO, {"name": " "}),
    ("mission", MISSION, {"scenario": "a.toml"}),
    ("mission", MISSION, {"airspeed": None}),
    ("mission", MISSION, {"name": ".x"}),
    ("instance", INSTANCE, {"cost": None, "travel": None}),
    ("instance", INSTANCE, {"name": ""}),
    ("run", MOVED, {"paths": {"points": []}}),
    ("study", STUDY, {"name": "x" * 121, "files": []}),
    ("study", PLACEMENT, {"problem": "placment"}),
]


@pytest.mark.parametrize(("name", "base", "changes"), RELATIONS)
def test_rules_between_keys_are_in_the_schema_too(name: str, base: dict[str, Any], changes: dict[str, Any]) -> None:
    document = {key: value for key, value in {**base, **changes}.items() if value is not None}
    assert faults(name, document)
    with pytest.raises(InputError):
        READERS[name](document)


def test_the_command_prints_and_writes(cli, tmp_path: Path) -> None:
    code, out, _ = cli("schema", "scenario")
    assert (code, out) == (0, json.dumps(json_schema("scenario"), indent=1, ensure_ascii=False) + "\n")
    assert cli("schema", "all", "--out", "made")[0] == 0
    assert {path.name for path in (tmp_path / "made").iterdir()} == {f"{name}.schema.json" for name in FORMATS}
    Draft202012Validator.check_schema(json.loads((tmp_path / "made" / "run.schema.json").read_text()))
    assert cli("schema", "run", "--out", "run.md", "--markdown")[0] == 0
    assert "| `objective` |" in (tmp_path / "run.md").read_text()
    code, _, err = cli("schema", "all")
    assert (code, "give --out FOLDER" in err) == (2, True)
