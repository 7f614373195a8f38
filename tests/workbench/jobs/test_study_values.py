"""What a study may say: every key with values nobody should write. One sentence each, before anything is expanded."""

from __future__ import annotations

import datetime
import math
from pathlib import Path
from typing import Any

import pytest

from instances import InputError
from workbench.jobs.execute import jobs_of
from workbench.jobs.study import study_from
from workbench.problems import PROBLEMS

DATE = datetime.date(1979, 5, 27)
NO_VALUE = [math.nan, math.inf, -math.inf, 1e308, 10**400, 1 << 20_000, DATE, {"a": 1}, [[1]], [DATE], True]
NO_NUMBER = [*NO_VALUE, "a", "", ["."], -1, 0]
NO_TEXT = [*NO_VALUE, 3]
NO_FILE = [*NO_VALUE, 3, ".", "a\0b", "x" * 5000, "missing"]
STUDIES: dict[str, dict[str, Any]] = {
    "routing": {"families": [{"family": "uniform", "tasks": 3, "depots": 2}]},
    "placement": {"tests": "3x3", "tasks": 2},
    "moving-cost": {"families": [{"family": "uniform", "tasks": 3, "depots": 2}]},
    "survey": {"fields": [{"kind": "gp"}]},
}
ENTRY = {
    "routing": {"name": "greedy"},
    "placement": {"name": "greedy"},
    "moving-cost": {"name": "dijkstra"},
    "survey": {"name": "myopic"},
}
NO_FIELD = [
    {"kind": "gp", "file": "a.nc"},
    {"kind": "file"},
    {"kind": "gp", "unit": "K"},
    {"kind": "file", "file": "missing"},
    {"kind": "gp", "seeds": 10**9},
    {"kind": "gp", "length_scale": 0.0},
    {"kind": "radio", "altitude": 1.0},
]
KEYS: dict[str, dict[str, list[Any]]] = {
    "routing": {
        "name": [*NO_TEXT, "", "../../x", "/tmp/x", "a/b", "..", ".x", "a\nb", "x" * 200],
        "description": NO_TEXT,
        "seeds": [*NO_NUMBER, 10**9, [2**31]],
        "time_limit": [*NO_NUMBER, 1e-320 * 0],
        "threads": [*NO_NUMBER, 10**9],
        "iterations": [value for value in NO_NUMBER if value != 0],
        "files": NO_FILE,
        "families": [*NO_TEXT, "uniform"],
        "solvers": [*NO_TEXT, [], "greedy"],
    },
    "placement": {
        "regions": NO_FILE,
        "tasks": [*NO_NUMBER, 1e1, 10**9],
        "tests": [*NO_VALUE, "0x3", "9" * 5000 + "x2", "a", 3],
        "signal_sd": NO_NUMBER,
        "length_scale": [*NO_NUMBER, "1,2,3"],
        "noise_sd": NO_NUMBER,
        "test_noise_sd": [*NO_NUMBER, [0]],
        "threads": [1],
    },
    "moving-cost": {"scenarios": NO_FILE, "starts": NO_NUMBER, "time_limit": NO_NUMBER},
    "survey": {
        "fields": [*NO_TEXT, [], *([field] for field in NO_FIELD)],
        "region": NO_FILE,
        "depots": [*NO_TEXT, [], [[0.0]], [[-1.0, 0.0]], [[math.nan, 0.0]]],
        "endurance": [*NO_NUMBER, 1.0, 1e9, [300.0, 0.0]],
        "period": [*NO_NUMBER, 1e-6, 1e6],
        "speed": NO_NUMBER,
        "cells": [*NO_NUMBER, 3, 1001],
    },
}
INSIDE: dict[str, dict[str, list[Any]]] = {
    "families": {
        "family": [*NO_TEXT, "a", "x:", ":x", "a:b:c", "a.:b", "a b:c"],
        "tasks": NO_NUMBER,
        "depots": NO_NUMBER,
        "seeds": [*NO_NUMBER, 10**9],
        "parameters": [*NO_TEXT, {"airspeed": math.inf}, {"airspeed": DATE}, {"airspeed": {"a": 1}}, {"winf": 1}],
    },
    "solvers": {
        "name": [*NO_TEXT, "a", "x:", ":x", "a:b:c", "a.:b", "a b:c", "5:x"],
        "max_tasks": ["."],
        "options": [*NO_TEXT, {"x": 1}, {"variant": math.nan}, {"variant": DATE}],
        "seeds": [*NO_NUMBER, 10**9],
        "time_limit": NO_NUMBER,
        "threads": [*NO_NUMBER, 10**9],
    },
}


def named(value: Any) -> str:
    return f"{type(value).__name__}-{value:.3}" if isinstance(value, (str, float)) else type(value).__name__


CASES = [(name, None, key, value) for name, keys in KEYS.items() for key in keys for value in keys[key]]
CASES += [("routing", table, key, value) for table, keys in INSIDE.items() for key in keys for value in keys[key]]


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize(("problem", "table", "key", "value"), CASES, ids=named)
def test_what_no_study_can_mean_is_one_sentence(tmp_path, problem, table, key, value):
    study = STUDIES[problem] | {PROBLEMS.load(problem).entries: [ENTRY[problem]]}
    study |= {key: value} if table is None else {table: [study[table][0] | {key: value}]}
    with pytest.raises(InputError) as refused:
        jobs_of(study_from(study, PROBLEMS.load(problem), name="s", base=tmp_path))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("options", [{"x": math.nan}, {"x": math.inf}, {"x": DATE}, {"x": {"a": 1}}, {"x": [[[1]]]}])
def test_options_of_others_are_plain_values(options):
    tables = {"solvers": [{"name": "not.there:Solver", "options": options}]}
    with pytest.raises(InputError, match="option 'x' must be a finite number, a text"):
        study_from(tables, PROBLEMS.load("routing"), name="s", base=Path())


def test_options_of_others_are_kept_as_given():
    tables = {"solvers": [{"name": "not.there:Solver", "options": {"s": "[/b]", "x": [0, 0.5], "y": True}}]}
    study = study_from(tables, PROBLEMS.load("routing"), name="s", base=Path())
    assert [entry.options for entry in study.entries] == [{"s": "[/b]", "x": x, "y": True} for x in (0, 0.5)]
    assert study.plugins == ["not.there:Solver"]


HUNDRED = list(range(2, 102))
MANY = {
    "options": {"solvers": [{"name": "ga", "options": dict.fromkeys(("population", "tournament", "a", "b"), HUNDRED)}]},
    "limits": {"solvers": [{"name": "ga", "seeds": 1000, "time_limit": [1.0 + k for k in range(1001)]}]},
    "families": {"families": [{"family": "ring", "tasks": [5] * 1001, "depots": [2] * 1000}]},
    "both": {
        "solvers": [{"name": "ga", "seeds": 1000}],
        "families": [{"family": "ring", "tasks": 5, "depots": 2, "seeds": 1001}],
    },
}


@pytest.mark.parametrize("tables", MANY.values(), ids=MANY)
def test_a_study_has_at_most_a_million_runs(tables):
    with pytest.raises(InputError, match="1000000"):
        study_from(tables, PROBLEMS.load("routing"), name="s", base=Path())
