"""Survey studies: run, checked, reported; plans that lie; studies that say what cannot be."""

from __future__ import annotations

import csv
import json
import shutil

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.mapping.map_grid import MapGrid
from formulations.surveying.verification import worth_of
from instances.environment.radio import RadioMap
from instances.environment.radio_files import write_field
from instances.errors import InputError
from workbench.cli import main
from workbench.jobs.job import Job
from workbench.jobs.runner import run
from workbench.jobs.study import shipped_studies, study_from
from workbench.problems.survey import SURVEY

STUDY = """problem = "survey"
endurance = 80
cells = 12
[[fields]]
kind = "gp"
seeds = 2
[[methods]]
name = "myopic"
options = { within = [1.5, 3.0] }
[[methods]]
name = "lawnmower"
"""
STAY = 'problem = "survey"\nendurance = 80\ncells = 12\n[[fields]]\nkind = "gp"\n[[methods]]\nname = "myopic"\n'


def call(*words: object) -> int:
    with pytest.raises(SystemExit) as ending:
        main([str(word) for word in words])
    return int(ending.value.code or 0)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("surveys")
    (folder / "mine.toml").write_text(STUDY)
    assert call("compare", folder / "mine.toml", "--out", folder / "runs", "--jobs", 2, "--no-report") == 0
    return folder


@pytest.fixture
def store(finished, tmp_path):
    return shutil.copytree(finished / "runs", tmp_path / "runs")


@pytest.fixture(scope="module")
def item():
    study = {"problem": "survey", "endurance": 80.0, "cells": 12, "fields": [{"kind": "gp"}]}
    study["methods"] = [{"name": "myopic"}]
    return next(iter(study_from(study, SURVEY, name="s", base=None).sources)).load()


def change(store, pattern, edit):
    path = sorted(store.glob(pattern))[0]
    data = json.loads(path.read_text())
    edit(data)
    path.write_text(json.dumps(data))
    return path


def test_a_store_without_a_lie_is_all_right(store, capsys):
    assert call("check", store) == 0
    assert capsys.readouterr().out == "6 survey runs on 2 surveys: all right\n"
    assert call("status", store, "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["planned"], said["stored"], said["by_solver"]["myopic"]) == (6, 6, {"FEASIBLE": 2})


def test_a_lawnmower_that_does_not_fit_is_declined_with_a_reason(store):
    runs = [json.loads(path.read_text()) for path in store.glob("*-80s-*/lawnmower*.json")]
    assert {(each["status"], each["stopped_by"]) for each in runs} == {("NO_SOLUTION", "declined")}
    assert "at most 8000 m a UAV" in runs[0]["message"]


MYOPIC = "gp-se-s0-80s-*/myopic-default-*.json"
LIES = {
    "too far": (MYOPIC, lambda run: run["tours"][0].insert(1, [19e3, 19e3]), "more than the 8000 m"),
    "its RMSE": (MYOPIC, lambda run: run.update(rmse=0.1), "states rmse = 0.1"),
    "its objective": (MYOPIC, lambda run: run.update(objective=0.1), "states objective = 0.1"),
    "its promise": (MYOPIC, lambda run: run.update(promised_sd=None), "states promised_sd = None"),
    "no tours": (MYOPIC, lambda run: run.update(tours=None), "states an RMSE, but has no tours"),
    "its samples": (MYOPIC, lambda run: run["samples"][1].pop(), "samples where"),
    "its status": (MYOPIC, lambda run: run.update(status="OPTIMAL"), "no survey planner can say"),
    "another field": ("gp-se-s0-80s-*/survey.json", lambda told: told.update(seed=9), "not the survey of its folder"),
    "no field": ("gp-se-s0-80s-*/survey.json", lambda told: told.pop("field"), "does not describe a survey"),
    "cells without end": (
        "gp-se-s0-80s-*/survey.json",
        lambda told: told["setting"].update(cells=10**9),
        "cells must be from 4 to 1000",
    ),
    "no period": ("gp-se-s0-80s-*/survey.json", lambda told: told["setting"].update(period=0.0), "does not describe"),
}


@pytest.mark.parametrize("name", LIES)
def test_a_planted_lie_is_found(name, store, capsys):
    pattern, edit, sentence = LIES[name]
    path = change(store, pattern, edit)
    assert call("check", store) == 1
    said = capsys.readouterr().out
    assert sentence in said
    assert str(path.parent) in said


@pytest.mark.usefixtures("without_figures")
def test_a_page_leaves_out_what_is_false(store, tmp_path):
    for edit in (LIES["too far"], LIES["no tours"]):
        change(store, edit[0], edit[1])
        assert call("report", store, "--out", tmp_path / "x.html") == 0


@pytest.mark.usefixtures("without_figures")
def test_page_and_table_say_who_wins(store, tmp_path, capsys):
    page, table = tmp_path / "x.html", tmp_path / "y.csv"
    assert call("report", store, "--out", page, "--csv", table, "--json") == 0
    told = json.loads(capsys.readouterr().out)["tables"]["survey"]
    assert {row["verdict"] for row in told} <= {"reference", "wins", "draws", "loses", ""}
    rows = list(csv.DictReader(table.open()))
    assert len(rows) == 6
    mean = np.mean([float(row["rmse"]) for row in rows if row["method"] == "myopic"])
    (mine,) = (row for row in told if row["method"] == "myopic")
    assert mine["rmse"] == pytest.approx(mean)
    assert [row["failed"] for row in told] == [0, 0, 0]  # declined is not failed
    text = page.read_text()
    assert "myopic (within=3.0) over 2 fields of gp-se at 80 s" in text
    assert "lawnmower does not take this survey: no lane" in text


FALSE = {
    "Liar": "more than the 8000 m",
    "Stray": "outside the region",
    "Lost": "from its depot",
    "Elsewhere": "was elsewhere",
    "Backwards": "not in the order of time",
    "Idle": "measured nothing",
}


@pytest.mark.parametrize("name", FALSE)
def test_a_plan_that_lies_is_refuted(name, item, misflying):
    planner = getattr(misflying, name)()
    product = json.loads(json.dumps(claim(planner, item).product))
    objective, fault = SURVEY.judge(item, product, None)
    assert objective is None
    assert FALSE[name] in fault


def test_what_a_plan_reads_in_flight_is_what_is_mapped(item, misflying):
    product = json.loads(json.dumps(claim(misflying.Asks(), item).product))
    objective, fault = SURVEY.judge(item, product, None)
    assert fault == ""
    assert len(product["read"]) == sum(map(len, product["samples"])) > 0
    tours = [np.array(tour) for tour in product["tours"]]
    points = MapGrid.over(item.problem.region, item.setting.cells).points
    assert objective == worth_of(item.problem, tours, item.field, points, item.seed).score.rmse


def claim(planner, item):
    return SURVEY.solve(planner, item, Limits(), 0, lambda claim: None, None)


@pytest.fixture
def misflying():
    import misflying  # beside: tests/workbench/misflying.py

    return misflying


@pytest.mark.slow
def test_a_plan_that_lies_is_an_error_of_its_run(item):
    found = run(SURVEY, Job("", "misflying:Stray", time_limit=5.0), item)
    assert found.status == "ERROR"
    assert "outside the region" in found.message
    assert found.own["tours"] is None


WRONG = {
    "no field": ("[[fields]]", "[[field]]", "field"),
    "an unknown kind": ('kind = "gp"', 'kind = "gaussian"', "gaussian"),
    "a file that is none": ('kind = "gp"', 'kind = "file"\nfile = "no.nc"', "no.nc"),
    "a depot outside": ("cells = 12", "cells = 12\ndepots = [[-5.0, 0.0]]", "must lie in the region"),
    "no reading": ("endurance = 80", "endurance = 9", "each must take one"),
    "too many": ("endurance = 80", "endurance = 1e6", "at most 2000"),
    "an unknown planner": ('"myopic"', '"myopik"', "did you mean 'myopic'"),
    "an unknown option": ('"myopic"', '"myopic"\noptions = {reach = 1.0}', "no option 'reach'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_study_is_one_sentence(name, tmp_path, capsys):
    old, new, words = WRONG[name]
    (tmp_path / "s.toml").write_text(STAY.replace(old, new))
    assert call("compare", tmp_path / "s.toml", "--out", tmp_path / "runs") == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.strip().count("\n") <= 3
    assert not (tmp_path / "runs").exists()


def test_a_raster_is_flown_over_in_its_own_unit(tmp_path):
    axis = np.linspace(0, 20e3, 6)
    write_field(RadioMap(axis, axis, np.add.outer(axis, axis) / 1e3, "K"), tmp_path / "warm.nc")
    study = {"problem": "survey", "endurance": 80.0, "methods": [{"name": "myopic"}]}
    study["fields"] = [{"kind": "file", "file": "warm.nc", "seeds": [4]}, {"kind": "radio", "relief": 0.0}]
    warm, radio = study_from(study, SURVEY, name="s", base=tmp_path).sources
    assert (warm.name, warm.field.unit, warm.seed) == ("warm-s4-80s", "K", 4)
    assert (radio.name, radio.field.unit) == ("radio-diffraction-s0-80s", "dBm")
    small = study | {"fields": [{"kind": "file", "file": "small.nc"}]}
    write_field(RadioMap(axis / 2, axis, np.zeros((6, 6)), "K"), tmp_path / "small.nc")
    with pytest.raises(ValueError, match="not all of the region"):
        study_from(small, SURVEY, name="s", base=tmp_path)


SCENARIO = """ground_speed = 50.0
size = [6000.0, 5000.0]
no_fly = "zone.geojson"
depots = [[500.0, 500.0], [5500.0, 4500.0]]
tasks = 3
[wind]
kind = "shear"
rate = 4e-3
centre = [3000.0, 2500.0]
"""
ZONE = {"type": "Polygon", "coordinates": [[[2500, 1500], [3500, 1500], [3500, 3500], [2500, 1500]]]}


@pytest.fixture
def windy(tmp_path):
    (tmp_path / "zone.geojson").write_text(json.dumps(ZONE))
    (tmp_path / "s.toml").write_text(SCENARIO)
    fields = [{"kind": "gp", "length_scale": 2000.0}]
    return {"problem": "survey", "endurance": 160.0, "scenario": "s.toml", "fields": fields, "period": 10.0,
            "methods": [{"name": "myopic"}]}  # fmt: skip


def test_a_scenario_says_region_zones_wind_and_speed(windy, tmp_path):
    (item,) = (source.load() for source in study_from(windy, SURVEY, name="s", base=tmp_path).sources)
    assert not item.problem.region.contains([[3300.0, 2000.0]])[0]
    assert (item.problem.length, item.problem.spacing) == (8000.0, 500.0)
    east = np.array([[500.0, 500.0], [5500.0, 500.0]])  # against 8 m/s: 50 m/s over ground, 5 km cost 5.8
    assert item.problem.cost_of(east) == pytest.approx(5000.0 * (1 + 8.0 / 50.0))
    folder = tmp_path / f"{item.name}-{item.digest}"
    folder.mkdir()
    SURVEY.write(item, folder)
    again = SURVEY.read(folder)
    assert again.digest == item.digest
    there_and_back = [[[500.0, 500.0], [4500.0, 500.0], [500.0, 500.0]], []]
    samples = [[[500.0 + min(s, 8000 - s), 500.0] for s in range(500, 8001, 500)], []]
    product = {"tours": there_and_back, "samples": samples, "read": []}
    assert SURVEY.judge(again, product, None)[1] == ""  # what the wind takes one way it gives the other
    stronger = SCENARIO.replace("4e-3", "5e-3")
    (tmp_path / "s.toml").write_text(stronger)
    assert next(iter(study_from(windy, SURVEY, name="s", base=tmp_path).sources)).load().digest != item.digest


@pytest.mark.parametrize(
    ("words", "edit"),
    [
        ("leave it out of the study", lambda study, text: (study | {"speed": 20.0}, text)),
        ("constant ground speed", lambda study, text: (study, text.replace("ground_speed", 'cost = "time"\nairspeed'))),
        ("UAVs of a survey are alike", lambda study, text: (study, f"service = 5.0\n{text}")),
    ],
)
def test_a_scenario_that_no_survey_can_be_in_is_refused(words, edit, windy, tmp_path):
    study, text = edit(windy, SCENARIO)
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(InputError, match=words):
        study_from(study, SURVEY, name="s", base=tmp_path)


def test_the_shipped_study_names_every_planner_that_comes_along():
    text = shipped_studies()["survey"].read_text()
    assert all(f'name = "{name}"' in text for name in SURVEY.methods.built_in)
