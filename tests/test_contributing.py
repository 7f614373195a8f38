"""CONTRIBUTING.md is run as written: every file in it, every command, and a method that comes by an entry point."""

from __future__ import annotations

import json
import os
import re
import runpy
import shlex
from pathlib import Path

import pytest

from reports import record
from workbench.cli import main
from workbench.problems import PROBLEMS

TEXT = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+)(?: file=(\S+))?\n(.*?)^```$", re.M | re.S)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Every file of the text in one folder."""
    made = tmp_path_factory.mktemp("contributing")
    for _, name, text in BLOCK.findall(TEXT):
        if name:
            (made / name).write_text(text)
    return made


@pytest.fixture(autouse=True)
def at_home(folder, monkeypatch):
    """Stand in the folder; what lies in it can be imported, here and in child processes."""
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))
    paths = [str(folder), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(path for path in paths if path))


def commands_of(section: str) -> list[list[str]]:
    """Return the commands in the blocks of one section."""
    body = TEXT.split(f"\n## {section}\n")[1].split("\n## ")[0]
    return [shlex.split(line) for kind, _, text in BLOCK.findall(body) if kind == "sh" for line in text.splitlines()]


def call(*words: str) -> int:
    with pytest.raises(SystemExit) as ending:
        main(list(words))
    return int(ending.value.code or 0)


def runs_in(store: Path) -> list[dict]:
    return [json.loads(path.read_text()) for path in sorted(store.glob("*/*-s*-t*.json"))]


def test_the_solver_the_family_and_the_figure(folder):
    for section in ("A solver", "A family", "A figure"):
        commands = commands_of(section)
        assert commands
        for program, *words in commands:
            if program == "workbench":
                assert call(*words) == 0
            else:
                runpy.run_path(words[0], run_name="__main__")
    dealt = [run for run in runs_in(folder / "runs" / "solver") if run["solver"] == "round_robin:RoundRobin"]
    assert [run["routes"] for run in dealt] == [[[0, 2, 4], [1, 3, 5]]]
    assert "round_robin:RoundRobin" in (folder / "runs" / "solver" / "report.html").read_text()
    assert list((folder / "given").glob("diagonal-uniform-wind-n8-m2-s0.json"))
    assert (folder / "evenness.svg").read_text().startswith("<?xml")


def test_the_problem(folder, monkeypatch):
    import one_tour  # type: ignore[import-not-found]

    monkeypatch.setitem(PROBLEMS.built_in, "one-tour", ("one_tour:ONE_TOUR", "the worked example"))
    monkeypatch.setitem(record.OWN, "one-tour", one_tour.COLUMNS)
    monkeypatch.setitem(record.ITEM_FILES, "one-tour", (one_tour.ITEM_FILE,))
    for _, *words in commands_of("A problem"):
        assert call(*words) == 0
    (run,) = runs_in(folder / "runs" / "line")
    assert (run["objective"], run["order"]) == (16.0, [1, 3, 0, 2, 4])
    (path,) = (folder / "runs" / "line").glob("*/*-s*-t*.json")
    path.write_text(json.dumps(run | {"order": [1, 1, 0, 2, 4]}))
    assert call("check", "runs/line") == 1


METHOD = '''
from dataclasses import dataclass
from typing import ClassVar

from formulations.task_location.placement import PlacementMethod, PlacementStatus


@dataclass(frozen=True)
class FirstSites(PlacementMethod):
    """The first candidate sites, whatever they tell."""

    status: ClassVar[PlacementStatus] = PlacementStatus.HEURISTIC
    skip: int = 0

    def search(self, problem, progress, seed):
        points = problem.candidates[self.skip : self.skip + problem.n_tasks]
        progress.offer(points, problem.criterion.value(points))
        return self.status
'''


def test_a_placement_method_by_an_entry_point_is_one_file_and_one_line(folder, capsys):
    (folder / "first_sites.py").write_text(METHOD)
    about = folder / "first_sites-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: first-sites\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[mmmdmtsp_workbench.placement_methods]\nfirst-sites = first_sites:FirstSites\n"
    )
    methods = '[[methods]]\nname = "first-sites"\noptions = { skip = [0, 5] }\n[[methods]]\nname = "greedy"\n'
    Path("sites.toml").write_text(f'problem = "placement"\ntasks = [3]\ntests = "5x5"\n{methods}')
    assert call("compare", "sites.toml", "--out", "runs/sites") == 0
    assert "first-sites (skip=5)" in capsys.readouterr().out
    assert {run["label"]: run["status"] for run in runs_in(folder / "runs" / "sites")} == {
        "first-sites (skip=0)": "heuristic",
        "first-sites (skip=5)": "heuristic",
        "greedy": "heuristic",
    }
    assert call("check", "runs/sites") == 0
    assert "first-sites" in (folder / "runs" / "sites" / "report.html").read_text()
    Path("sites.toml").write_text(Path("sites.toml").read_text().replace("skip", "skipp"))
    assert call("compare", "sites.toml", "--out", "runs/other", "--no-plugins") == 2
    assert "'first-sites', which is not built in" in capsys.readouterr().err
    assert call("compare", "sites.toml", "--out", "runs/other", "--no-report") == 1  # two runs ended in ERROR
    told = {run["solver"]: run["message"] for run in runs_in(folder / "runs" / "other") if run["status"] == "ERROR"}
    assert "did you mean 'skip'" in told["first-sites"]
