"""`workbench place` and placement studies of `workbench compare`, from the command line."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from shapely.geometry import box, mapping

from instances.errors import InputError
from instances.geodesy import TangentPlane
from instances.places import read_region
from workbench.cli import main
from workbench.commands.place_how_many import numbers_from
from workbench.jobs.execute import jobs_of
from workbench.jobs.job import Job
from workbench.jobs.runner import run
from workbench.jobs.study import study_from
from workbench.problems.placement import PLACEMENT

RING = [[0, 0], [20_000, 0], [20_000, 9000], [9000, 9000], [9000, 20_000], [0, 20_000], [0, 0]]
HOLE = [[3000, 3000], [6000, 3000], [6000, 6000], [3000, 6000], [3000, 3000]]


def call(*words: str) -> int:
    with pytest.raises(SystemExit) as ending:
        main(list(words))
    return int(ending.value.code or 0)


@pytest.fixture
def area(tmp_path):
    path = tmp_path / "area.geojson"
    path.write_text(json.dumps({"type": "Polygon", "coordinates": [RING, HOLE]}))
    return path


def test_json_states_what_was_placed(area, tmp_path, capsys):
    out, plot = tmp_path / "tasks.geojson", tmp_path / "tasks.svg"
    words = ["place", str(area), "--tasks", "5", "--tests", "8x8", "--json", "--out", str(out), "--plot", str(plot)]
    assert call(*words) == 0
    said = json.loads(capsys.readouterr().out)
    assert {"method", "status", "points", "mutual_information", "certificate", "elapsed"} <= said.keys()
    assert (said["method"], said["status"]) == ("nlp", "locally solved")
    assert said["mutual_information"] == said["information"]["b"] <= said["information"]["a"] <= said["certificate"]
    assert read_region(area)[0].signed_distance(said["points"]).min() >= -1e-6
    written = json.loads(out.read_text())
    assert [f["geometry"]["coordinates"] for f in written["features"]] == said["points"]
    assert plot.read_text().startswith("<?xml")
    assert "origin" not in said


def test_a_region_in_degrees_makes_geojson_in_degrees(tmp_path, capsys):
    (tmp_path / "area.geojson").write_text(json.dumps(mapping(box(8.0, 47.0, 8.1, 47.1))))
    words = ["place", str(tmp_path / "area.geojson"), "--tasks", "3", "--tests", "5x5", "--method", "greedy", "--json"]
    assert call(*words, "--out", str(tmp_path / "tasks.geojson")) == 0
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert told["origin"] == [47.05, 8.05]
    features = json.loads((tmp_path / "tasks.geojson").read_text())["features"]
    written = [feature["geometry"]["coordinates"][::-1] for feature in features]
    np.testing.assert_allclose(TangentPlane(47.05, 8.05).local(written), told["points"], atol=0.01)
    assert "local metres" not in said.err
    words = ["place", "--tasks", "3", "--tests", "5x5", "--method", "greedy", "--out", str(tmp_path / "m.geojson")]
    assert call(*words) == 0
    assert capsys.readouterr().err.count("m.geojson: in local metres, as the region") == 1


def test_csv_and_json_files(tmp_path, capsys):
    for ending in ("csv", "json"):
        path = tmp_path / f"tasks.{ending}"
        assert call("place", "--tasks", "3", "--tests", "5x5", "--method", "greedy", "--out", str(path)) == 0
    rows = list(csv.DictReader((tmp_path / "tasks.csv").open()))
    assert [[float(r["x"]), float(r["y"])] for r in rows] == json.loads((tmp_path / "tasks.json").read_text())["points"]
    assert "3 tasks worth" in capsys.readouterr().out


def test_weighted_test_points_from_a_file(tmp_path, capsys):
    path = tmp_path / "tests.csv"
    path.write_text("x,y,weight\n1000,1000,1\n2000,1500,3\n19000,19000,0\n-5,-5,1\n")
    assert call("place", "--tasks", "1", "--tests", str(path), "--json", "--no-certificate") == 0
    said = json.loads(capsys.readouterr().out)
    assert said["certificate"] is None
    assert np.linalg.norm(np.array(said["points"][0]) - [1500, 1250]) < 2000


def polygons(path, *features):
    made = [
        {"type": "Feature", "properties": {"value": value}, "geometry": mapping(polygon)} for polygon, value in features
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": made}))
    return str(path)


def test_weights_and_prior_sd_from_maps(tmp_path, capsys):
    west = polygons(tmp_path / "west.geojson", (box(0, 0, 8000, 20_000), 50))
    words = ["place", "--tasks", "6", "--tests", "10x10", "--criterion", "j", "--method", "l-bfgs-b", "--json"]
    said = []
    for more in ([], ["--weights", west], ["--prior-sd", west]):
        assert call(*words, *more) == 0
        said.append(json.loads(capsys.readouterr().out))
    assert all(each["maximised"] == "j" for each in said)
    assert all(each["average_variance_bound"] <= each["average_variance"] for each in said)
    plain, weighted, unsure = (sum(x < 9000 for x, _ in each["points"]) for each in said)
    assert weighted > plain
    assert unsure > plain
    assert call(*words[:-1], "--weights", west) == 0
    assert "weighted rms sd of" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--criterion", "j", "--weights", "none.csv"], "none.csv: cannot be read"),
        (["--weights", "w.csv"], "w.csv: line 2: value must be a number of at least 0, got '-1'"),
        (["--prior-sd", "w.csv"], "w.csv: line 2: value must be a number of at least 0, got '-1'"),
        (["--criterion", "ig", "--weights", "good.csv"], "criterion ig looks at no test points"),
        (["--criterion", "jj"], "known: b, a, ig, j"),
        (["--max-sd", "3", "--prior-sd", "good.csv"], "cannot be proved under a map"),
        (["--max-sd", "3", "--weights", "good.csv"], "--weights: cannot be given with --max-sd"),
    ],
)
def test_maps_that_cannot_be_used(tmp_path, monkeypatch, capsys, words, sentence):
    (tmp_path / "w.csv").write_text("x,y,value\n100,100,-1\n")
    (tmp_path / "good.csv").write_text("x,y,value\n100,100,5\n")
    monkeypatch.chdir(tmp_path)
    more = [] if "--max-sd" in words else ["--tasks", "3", "--method", "greedy"]
    assert call("place", *more, "--tests", "5x5", *words) == 2
    assert sentence in capsys.readouterr().err


def test_maximising_information_gain_is_reported_under_both_noisy_too(capsys):
    assert call("place", "--tasks", "4", "--tests", "6x6", "--criterion", "ig", "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert said["maximised"] == "ig"
    assert said["information"]["ig"] == pytest.approx(0.5 * 4 * math.log(901), abs=0.01)
    assert said["mutual_information"] < said["information"]["ig"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--tasks", "0"], "--tasks: must be a whole number from 1"),
        (["--tasks", "5000"], "do not fit"),
        (["--length-scale", "0"], "positive"),
        (["--length-scale", "-4000,4000"], "positive"),
        (["--length-scale", "4km"], "--length-scale"),
        (["--signal-sd", "nan"], "--signal-sd: must be a positive number"),
        (["--noise-sd", "0"], "--noise-sd: must be a positive number"),
        (["--criterion", "literal"], "ill-posed"),
        (["--criterion", "c"], "unknown criterion"),
        (["--method", "nelder-meat"], "did you mean 'nelder-mead'"),
        (["--option", "startz=2"], "did you mean 'starts'"),
        (["--option", "starts=x"], "whole number"),
        (["--tests", "0x4"], "at least one column"),
        (["--tests", "grid"], "COLUMNSxROWS"),
        (["--tests", "missing.csv"], "cannot be read"),
        (["--seed", "-1"], "seed"),
        (["--time-limit", "0"], "--time-limit: must be a positive number"),
        (["--out", "tasks.txt"], "must end in"),
        (["--out", "nowhere/tasks.csv"], "no folder"),
        (["--plot", "tasks.gif"], "must end in .svg"),
        (["--study", "n=80..5"], "--study"),
        (["--study", "n=5..2000"], "do not fit"),
        (["--study", "a"], "--study"),
        (["--max-sd", "40"], "max-sd"),
        (["--max-sd", "3", "--study", "n=5..6"], "one of them"),
        (["--max-sd", "3", "--method", "greedy"], "--method: cannot be given with --max-sd"),
        (["--study", "n=5..6", "--tasks", "3"], "--tasks: cannot be given with --study"),
        (["--sd-limit", "2"], "with --study"),
        (["--tests", "300x300"], "at most 5000"),
        (["--tests", "20000x20000"], "too many cells"),
        (["absent.geojson"], "cannot be read"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(words, sentence, capsys):
    assert call("place", *words) == 2
    said = capsys.readouterr()
    assert sentence in said.err
    assert said.err.strip().count("\n") == 0
    assert said.out == ""


@pytest.mark.parametrize(
    ("rings", "sentence"),
    [
        ([[[0, 0], [9, 9], [9, 0], [0, 9], [0, 0]]], "not valid"),
        ([[[0, 0], [9, 9], [18, 18], [0, 0]]], "region"),
        ([[[8.1, 89.1], [8.4, 89.1], [8.4, 89.4], [8.1, 89.1]]], "within a degree of a pole"),
    ],
)
def test_bad_regions_are_named(rings, sentence, tmp_path, capsys):
    path = tmp_path / "bad.geojson"
    path.write_text(json.dumps({"type": "Polygon", "coordinates": rings}))
    assert call("place", str(path)) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert "bad.geojson" in said


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("x,y,weight\n1,1,nan\n", "line 2: weight"),
        ("x,y,weight\n1,1,-1\n", "line 2: weight"),
        ("x,y\n1,one\n", "line 2: y"),
        ("x,y\ninf,1\n", "line 2: x"),
        ("a,b\n1,1\n", "columns 'x' and 'y'"),
        ("x,y\n-1,-1\n", "none of its 1 test points"),
        ("x,y,weight\n1,1,0\n", "all are 0"),
    ],
)
def test_bad_test_files_are_named(text, sentence, tmp_path, capsys):
    path = tmp_path / "tests.csv"
    path.write_text(text)
    assert call("place", "--tests", str(path)) == 2
    assert sentence in capsys.readouterr().err


def test_no_test_point_inside_the_region(tmp_path, capsys):
    path = tmp_path / "ring.geojson"
    ring = [[0, 0], [9000, 0], [9000, 9000], [0, 9000], [0, 0]]
    hole = [[100, 100], [8900, 100], [8900, 8900], [100, 8900], [100, 100]]
    path.write_text(json.dumps({"type": "Polygon", "coordinates": [ring, hole]}))
    assert call("place", str(path), "--tests", "2x2") == 2
    assert "none of the 2x2 cell centres" in capsys.readouterr().err


def test_study_recommends_a_number_with_the_reason(tmp_path, capsys):
    out, plot = tmp_path / "study.csv", tmp_path / "study.svg"
    words = [
        "place",
        "--study",
        "n=3..9:3",
        "--length-scale",
        "12000",
        "--tests",
        "6x6",
        "--method",
        "greedy",
        "--sd-limit",
        "6",
    ]
    assert call(*words, "--json", "--out", str(out), "--plot", str(plot)) == 0
    said = json.loads(capsys.readouterr().out)
    assert [row["n"] for row in said["trials"]] == [3, 6, 9]
    assert said["recommended"] in (3, 6, 9)
    assert "fewest tasks" in said["reason"]
    assert [int(row["n"]) for row in csv.DictReader(out.open())] == [3, 6, 9]
    assert plot.stat().st_size > 10_000


def test_a_study_goes_into_a_folder(tmp_path, monkeypatch):
    """As the README has it: a name without an ending is a folder."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["place", "--study", "n=2..3", "--tests", "3x3", "--method", "grid", "--out", "study/"])
    assert ended.value.code in (0, None)
    assert {path.name for path in (tmp_path / "study").iterdir()} == {"study.csv", "study.json", "study.svg"}


def test_numbers_of_a_study():
    assert numbers_from("n=5..8") == [5, 6, 7, 8]
    assert numbers_from("5..20:5") == [5, 10, 15, 20]
    assert numbers_from("5,40,200") == [5, 40, 200]
    for bad in ("", "0..3", "5..", "1.5", "5..9:0"):
        with pytest.raises(InputError, match="--study"):
            numbers_from(bad)


def test_fewest_tasks_from_the_command_line(capsys):
    assert call("place", "--max-sd", "8", "--length-scale", "12000", "--tests", "6x6", "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert said["n"] == len(said["points"]) >= said["at_least"] >= 1
    assert said["worst_sd"] <= 8


STUDY = {
    "problem": "placement",
    "tasks": [2, 3],
    "tests": "5x5",
    "time_limit": 20,
    "methods": [{"name": "greedy"}, {"name": "random", "seeds": 2}, {"name": "nlp", "max_tasks": 2}],
}


def test_a_placement_study_is_run_stored_and_reported_once(area, tmp_path, capsys):
    file = tmp_path / "mine.toml"
    methods = '[[methods]]\nname = "greedy"\n[[methods]]\nname = "nlp"\n'
    file.write_text(f'problem = "placement"\nregions = ["area.geojson"]\ntasks = [3]\ntests = "5x5"\n{methods}')
    folder = tmp_path / "runs"
    assert call("compare", str(file), "--out", str(folder), "--jobs", "2") == 0
    stored = sorted(folder.glob("area-n3-*/*-s0-*.json"))
    assert [path.name for path in stored] == ["greedy-default-s0-t60.json", "nlp-default-s0-t60.json"]
    runs = [json.loads(path.read_text()) for path in stored]
    for told in runs:
        assert told["problem"] == "placement"
        assert told["objective"] == -told["mutual_information"]
        assert told["bound"] == -told["certificate"] <= told["objective"]
    assert runs[0]["mutual_information"] <= runs[1]["mutual_information"]
    rows = list(csv.DictReader((folder / "results.csv").open()))
    assert {row["method"] for row in rows} == {"greedy", "nlp"}
    assert "certificate" in (folder / "report.html").read_text()
    before = [path.stat().st_mtime_ns for path in stored]
    assert call("compare", str(file), "--out", str(folder)) == 0
    assert [path.stat().st_mtime_ns for path in stored] == before


def test_a_study_keeps_the_rows_of_its_test_points(tmp_path):
    """Other test points are another problem, and the stored one needs no file."""
    file = tmp_path / "tests.csv"
    digests = []
    for weight in (1, 2):
        file.write_text(f"x,y,weight\n100,100,{weight}\n5000,5000,1\n")
        item = items_of(STUDY | {"tests": "tests.csv"}, tmp_path)[0]
        digests.append(item.digest)
    file.unlink()
    assert item.problem.criterion.weights.tolist() == [2, 1]
    assert len(set(digests)) == 2


def test_jobs_of_a_placement_study(tmp_path):
    study = study_from(STUDY, PLACEMENT, name="x", base=tmp_path)
    assert [(job.folder.split("-")[1], job.label, job.seed) for job in jobs_of(study)] == [
        ("n2", "greedy", 0),
        ("n2", "random", 0),
        ("n2", "random", 1),
        ("n2", "nlp", 0),
        ("n3", "greedy", 0),
        ("n3", "random", 0),
        ("n3", "random", 1),
    ]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"methods": []}, "names no methods"),
        ({"methods": [{"name": "greedi"}]}, "did you mean 'greedy'"),
        ({"methods": [{"nam": "greedy"}]}, "did you mean 'name'"),
        ({"methods": [{"name": "nlp", "options": {"starts": -1}}]}, "at least 0"),
        ({"time_limit": "long"}, "time_limit"),
        ({"tasks": [0]}, "at least 1"),
        ({"region": "square"}, "did you mean 'regions'"),
        ({"tests": "no"}, "--tests"),
        ({"weight": "a.csv"}, "did you mean 'weights'"),
        ({"prior": "a.csv"}, "did you mean 'prior_sd'"),
        ({"criterion": "k"}, "criterion must be one of"),
        ({"weights": "none.csv"}, "weights: .*none.csv"),
        ({"prior_sd": "none.csv"}, "prior_sd: .*none.csv"),
        ({"criterion": "ig", "weights": "ones.csv"}, "criterion ig looks at no test points"),
    ],
)
def test_bad_placement_studies_are_refused(change, sentence, tmp_path):
    (tmp_path / "ones.csv").write_text("x,y,value\n0,0,1\n")
    with pytest.raises(InputError, match=sentence):
        study_from(STUDY | change, PLACEMENT, name="x", base=tmp_path)


def items_of(study, base):
    return [source.load() for source in study_from(study, PLACEMENT, name="x", base=base).sources]


def test_a_false_claim_and_a_crash_are_errors(tmp_path):
    item = replace(items_of(STUDY | {"methods": [{"name": "greedy"}]}, tmp_path)[0], certificate=7.0)
    crashed = run(PLACEMENT, Job("", "nelder-mead", {"form": "round"}), item)
    assert (crashed.status, crashed.own["mutual_information"], crashed.bound) == ("ERROR", None, -7.0)
    assert "form" in crashed.message
    for name, sentence in (("Liar", "claimed 99.0 nats"), ("Stray", "outside the region")):
        found = run(PLACEMENT, Job("", f"misplacing:{name}"), item)
        assert found.status == "ERROR"
        assert sentence in found.message
        assert found.own["certificate"] == 7.0
