"""Stored placement runs: checked, reported again and run again, alone and beside routing runs."""

from __future__ import annotations

import csv
import json
import shutil

import pytest

from workbench.cli import main

STUDY = 'problem = "placement"\ntasks = [2]\ntests = "5x5"\n[[methods]]\nname = "greedy"\n[[methods]]\nname = "grid"\n'


def call(*words: object) -> int:
    with pytest.raises(SystemExit) as ending:
        main([str(word) for word in words])
    return int(ending.value.code or 0)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("placements")
    (folder / "mine.toml").write_text(STUDY)
    assert call("compare", folder / "mine.toml", "--out", folder / "runs", "--jobs", 2, "--no-report") == 0
    assert not (folder / "runs" / "report.html").exists()
    return folder


@pytest.fixture
def store(finished, tmp_path):
    return shutil.copytree(finished / "runs", tmp_path / "runs")


def change(store, pattern, edit):
    (path,) = store.glob(pattern)
    data = json.loads(path.read_text())
    edit(data)
    path.write_text(json.dumps(data))
    return path


def test_a_store_without_a_lie_is_all_right(store, capsys):
    assert call("check", store) == 0
    assert capsys.readouterr().out == "2 placement runs on 1 problems: all right\n"


GREEDY = "*/greedy-*.json"
LIES = {
    "a point outside": (GREEDY, lambda run: run["points"].__setitem__(0, [-1.0, 5.0]), "outside the region"),
    "a point missing": (GREEDY, lambda run: run["points"].pop(), "shape (1, 2) for 2 tasks"),
    "its worth": (GREEDY, lambda run: run.update(mutual_information=6.9), "claims mutual_information = 6.9 nats"),
    "its objective": (GREEDY, lambda run: run.update(objective=-6.9), "claims minus objective = 6.9"),
    "its gain": (GREEDY, lambda run: run["information"].update(ig=1.0), "claims information (ig) = 1.0"),
    "its trace": (GREEDY, lambda run: run["trace"].append([9.0, -99.0, None]), "its trace claims 99.0"),
    "its status": (GREEDY, lambda run: run.update(status="optimal"), "no placement method can say"),
    "its certificate": (GREEDY, lambda run: run.update(certificate=1.0, bound=-1.0), "its own certificate, 1.0"),
    "another's certificate": (GREEDY, lambda run: run.update(certificate=1.0), "grid seed 0 on square-n2 is worth"),
    "another problem": (GREEDY, lambda run: run["instance"].update(digest="0"), "another problem"),
    "no number": (
        GREEDY,
        lambda run: run.update(mutual_information=float("nan")),
        "NaN is no JSON number",
    ),
    "no worth": (GREEDY, lambda run: run.update(mutual_information=None), "does not say what they are worth"),
    "a crash": (GREEDY, lambda run: run.update(status="ERROR", message="broke"), "ERROR: broke"),
    "too low a bound": ("*/problem.json", lambda told: told["certificate"].update(bound=6.7), "but recomputed it is"),
    "a changed problem": ("*/problem.json", lambda told: told["setting"].update(noise_sd=2.0), "not the problem of"),
    "no problem": ("*/problem.json", lambda told: told.pop("polygon"), "does not describe a placement problem"),
}


@pytest.mark.parametrize("name", LIES)
def test_a_planted_lie_is_found(name, store, capsys):
    pattern, edit, sentence = LIES[name]
    path = change(store, pattern, edit)
    assert call("check", store) == 1
    said = capsys.readouterr().out
    assert sentence in said
    assert str(path.parent) in said


def test_status_counts_placements(store, capsys):
    assert call("status", store, "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["planned"], said["stored"], said["missing"]) == (2, 2, 0)
    assert said["by_solver"] == {"greedy": {"heuristic": 1}, "grid": {"heuristic": 1}}
    assert call("status", store) == 0
    assert "1 stored: 1 heuristic" in capsys.readouterr().out


def test_a_damaged_file_is_named_and_left(store, capsys):
    (path,) = store.glob(GREEDY)
    path.write_text('{"schema": 1,')
    for words in (["check", store], ["compare", store.parent / "mine.toml", "--out", store, "--no-report"]):
        (store.parent / "mine.toml").write_text(STUDY)
        assert call(*words) == 1
        said = capsys.readouterr()
        assert f"{path}: is not valid JSON" in said.out + said.err
    assert path.read_text() == '{"schema": 1,'


def test_page_and_table_are_written_again_without_running(store, tmp_path, capsys):
    before = {path: path.stat().st_mtime_ns for path in store.rglob("*")}
    page, table = tmp_path / "x.html", tmp_path / "y.csv"
    assert call("report", store, "--out", page, "--csv", table) == 0
    assert {path: path.stat().st_mtime_ns for path in store.rglob("*")} == before
    assert "Task locations: mine" in page.read_text()
    assert {row["method"] for row in csv.DictReader(table.open())} == {"greedy", "grid"}
    assert "greedy" in capsys.readouterr().out
    assert call("report", store, "--latex", tmp_path / "z.tex", "--out", tmp_path / "z.html") == 2
    assert "--latex" in capsys.readouterr().err
    assert not (tmp_path / "z.html").exists()


def test_a_page_about_a_contradiction_says_so(store, tmp_path, capsys):
    change(store, GREEDY, lambda run: run.update(certificate=1.0))
    assert call("report", store, "--out", tmp_path / "x.html") == 0
    assert "one of the two is wrong" in capsys.readouterr().err
    assert 'class="alarm"' in (tmp_path / "x.html").read_text()


def test_retry_runs_again_what_failed_and_nothing_else(finished, store, capsys):
    good = change(store, "*/grid-*.json", lambda run: None)
    bad = change(store, GREEDY, lambda run: run.update(status="ERROR", points=None, mutual_information=None))
    before = good.read_text()
    words = ["compare", finished / "mine.toml", "--out", store, "--no-report"]
    assert call(*words) == 1
    assert json.loads(bad.read_text())["status"] == "ERROR"
    assert call(*words, "--retry", "error,killed") == 0
    assert json.loads(bad.read_text())["status"] == "heuristic"
    assert good.read_text() == before
    capsys.readouterr()
    assert call(*words, "--retry", "eror") == 2
    assert "did you mean 'error'" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--threads", "2"], ["a.json"]])
def test_what_does_not_fit_a_placement_study_is_refused(words, finished, capsys):
    assert call("compare", finished / "mine.toml", *words) == 2
    flag = words[0] if words[0].startswith("--") else "INSTANCES"
    assert f"{flag} cannot be given with a placement study" in capsys.readouterr().err


@pytest.mark.usefixtures("without_figures")
def test_both_problems_in_one_store(store, tmp_path, capsys):
    assert call("generate", "uniform", "--tasks", 5, "--depots", 2, "--out", tmp_path / "u.json") == 0
    run = ["--solvers", "greedy", "--seeds", 1, "--time-limit", 1, "--jobs", 1, "--out", store]
    assert call("compare", tmp_path / "u.json", *run) == 0
    for stem, method in (("", "greedy"), ("-placement", "grid")):
        rows = list(csv.DictReader((store / f"results{stem}.csv").open()))
        assert method in {row["method"] for row in rows}
        assert (store / f"report{stem}.html").stat().st_size > 1000
    capsys.readouterr()
    assert call("check", store) == 0
    assert capsys.readouterr().out == "1 runs on 1 instances, 2 placement runs on 1 problems: all right\n"
    change(store, "square-*/greedy-*.json", lambda run: run.update(mutual_information=6.9))
    assert call("check", store) == 1
    assert call("report", store, "--out", tmp_path / "x.html", "--csv", tmp_path / "y.csv") == 0
    assert {row["method"] for row in csv.DictReader((tmp_path / "y.csv").open())} == {"greedy"}
    assert (tmp_path / "x-placement.html").exists()
