"""Placement studies with maps and criterion j: kept without their files, judged again, and bounded."""

from __future__ import annotations

import csv
import json
import shutil

import numpy as np
import pytest

import workbench
from workbench.cli import main

STUDY = """problem = "placement"
tasks = [2]
tests = "5x5"
criterion = "j"
weights = "weights.csv"
prior_sd = "prior.csv"
[[methods]]
name = "greedy"
[[methods]]
name = "nlp"
options = { starts = 1 }
"""
WEIGHTS = "x,y,value\n0,0,1\n20000,0,9\n0,20000,1\n20000,20000,9\n"  # 1 in the west, 9 in the east, linear between
PRIOR = "x,y,value\n0,0,10\n20000,0,12\n0,20000,30\n20000,20000,32\n"  # north and east


def call(*words: object) -> int:
    with pytest.raises(SystemExit) as ending:
        main([str(word) for word in words])
    return int(ending.value.code or 0)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mapped")
    (folder / "mine.toml").write_text(STUDY)
    (folder / "weights.csv").write_text(WEIGHTS)
    (folder / "prior.csv").write_text(PRIOR)
    words = ["--out", folder / "runs", "--jobs", 1, "--seeds", 1, "--no-report"]
    assert call("compare", folder / "mine.toml", *words) == 0
    return folder


@pytest.fixture
def store(finished, tmp_path):
    return shutil.copytree(finished / "runs", tmp_path / "runs")


def left(points, n=5, noise=1.0, scale=4000.0):
    """Return J of readings at `points`, written out."""
    axis = (np.arange(n) + 0.5) * 20000 / n
    tests = np.array([(x, y) for y in axis for x in axis])
    w = 1 + 8 * tests[:, 0] / 20000

    def k(a, b):
        squares = ((a[:, None] - b[None]) ** 2).sum(axis=2) / scale**2
        sd = [10 + (2 * p[:, 0] + 20 * p[:, 1]) / 20000 for p in (a, b)]
        return np.outer(*sd) * np.exp(-squares / 2)

    gain = k(tests, points) @ np.linalg.solve(k(points, points) + noise**2 * np.eye(len(points)), k(points, tests))
    return float(w @ (np.diag(k(tests, tests)) - np.diag(gain)) / w.sum())


def test_runs_are_worth_the_fall_of_the_weighted_variance(finished, store):
    runs = {path.name.split("-")[0]: json.loads(path.read_text()) for path in store.glob("square-n2-*/*-s0-*.json")}
    assert set(runs) == {"greedy", "nlp"}
    for run in runs.values():
        worth = 0.5 * np.log(left(np.empty((0, 2))) / left(np.array(run["points"])))
        assert -run["objective"] == pytest.approx(worth, rel=1e-4)  # the map is bilinear on its own nodes
        assert run["information"]["j"] == -run["objective"] == pytest.approx(run["ratio"] * run["certificate"])
        assert run["mutual_information"] == run["information"]["b"] != -run["objective"]
        assert run["bound"] == -run["certificate"] < run["objective"]
    assert runs["nlp"]["objective"] < runs["greedy"]["objective"]
    maps = {name: finished / f"{name.split('_')[0]}.csv" for name in ("weights", "prior_sd")}
    alone = workbench.place(tasks=2, method="greedy", tests="5x5", criterion="j", certificate=False, **maps)
    np.testing.assert_array_equal(alone.points, runs["greedy"]["points"])


def test_a_store_with_maps_needs_no_files_and_is_reported_by_worth(store, tmp_path, capsys):
    assert call("check", store) == 0
    assert capsys.readouterr().out == "2 placement runs on 1 problems: all right\n"
    assert call("report", store, "--out", tmp_path / "x.html", "--csv", tmp_path / "x.csv") == 0
    rows = {row["method"].split()[0]: row for row in csv.DictReader((tmp_path / "x.csv").open())}
    worth = {name: float(row["worth"]) for name, row in rows.items()}
    assert float(rows["greedy"]["gap_found"]) == pytest.approx(1 - worth["greedy"] / worth["nlp"])


GREEDY, PROBLEM = "square-*/greedy-*.json", "*/problem.json"
LIES = {
    "its objective": (GREEDY, lambda run: run.update(objective=-0.9), "claims minus objective = 0.9"),
    "its worth": (GREEDY, lambda run: run["information"].update(j=0.9), "claims information (j) = 0.9"),
    "too low a bound": (PROBLEM, lambda told: told["certificate"].update(bound=0.01), "but recomputed it is"),
    "a changed map": (PROBLEM, lambda told: told["setting"]["prior_sd"]["values"][0].reverse(), "belongs into"),
    "a changed weight": (PROBLEM, lambda told: told["setting"]["tests"][0].__setitem__(2, 99.0), "belongs into"),
}


@pytest.mark.parametrize("name", LIES)
def test_a_lie_about_j_or_its_maps_is_found(name, store, capsys):
    pattern, edit, sentence = LIES[name]
    (path,) = store.glob(pattern)
    data = json.loads(path.read_text())
    edit(data)
    path.write_text(json.dumps(data))
    assert call("check", store) == 1
    assert sentence in capsys.readouterr().out
