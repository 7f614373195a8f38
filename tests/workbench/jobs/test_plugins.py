"""Code of others, named by a study, a mission or an installed package, runs in a child process and nowhere else."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest

from formulations.routing.registry import SOLVERS
from instances.errors import InputError
from instances.files import FORMATS, endings, read_instance
from instances.registry import Registry
from workbench.making import make_elsewhere
from workbench.mission.costs import moving_costs
from workbench.mission.file import mission_of
from workbench.mission.place import criterion_of, place_tasks
from workbench.sources import FamilySource

MARKING = """
import os
from pathlib import Path

with Path(__file__).with_name("imported").open("a") as file:
    print(os.getpid(), file=file)

from formulations.routing.solver import Solver
from instances.families.square import UNIFORM
from misbehaving import Honest


class Fine(Honest):
    pass
"""
INSTALLED = """
[mmmdmtsp_workbench.solvers]
marked = marking:Fine
odd = no target at all
[mmmdmtsp_workbench.families]
marked-family = marking:UNIFORM
[mmmdmtsp_workbench.formats]
.marked = marking:Fine
"""
FAMILY = '[[families]]\nfamily = "FAMILY"\ntasks = 3\ndepots = 2\n'


@pytest.fixture
def importers(tmp_path, monkeypatch):
    """A module that writes down who imports it, registered by an installed package; returns the process ids."""
    site = tmp_path / "site"
    for name, text in (("marked", INSTALLED), ("torn", "[mmmdmtsp_workbench.solvers]\nno equals sign\n")):
        about = site / f"{name}-1.0.dist-info"
        about.mkdir(parents=True)
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (about / "entry_points.txt").write_text(text)
    (site / "marking.py").write_text(MARKING)
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.setenv("PYTHONPATH", str(site), prepend=os.pathsep)
    yield lambda: (site / "imported").read_text().split() if (site / "imported").exists() else []
    assert "marking" not in sys.modules


def study(*solvers: str, items: str = 'files = ["given/r4-2-0.json"]\n') -> Path:
    path = Path("study.toml")
    path.write_text(f"time_limit = 5\n{items}" + "".join(f"[[solvers]]\nname = {name!r}\n" for name in solvers))
    return path


def test_a_plug_in_is_imported_by_its_child_alone(cli, instance_folder, importers):
    path = study("marking:Fine", "marked")
    assert cli("compare", path, "--out", "runs", "--dry-run")[0] == 0
    code, _, err = cli("compare", path, "--out", "runs", "--no-plugins")
    assert (code, err) == (
        2,
        "workbench: --no-plugins: the study names 'marking:Fine', 'marked', which is not built in\n",
    )
    assert cli("solvers")[0] == cli("families")[0] == 0
    assert importers() == []
    assert cli("compare", path, "--out", "runs")[0] == 0
    assert len(importers()) == 2
    assert str(os.getpid()) not in importers()
    for words in (["check", "runs"], ["status", "runs"], ["report", "runs", "--csv", "a.csv"]):
        assert cli(*words)[0] == 0
    assert len(importers()) == 2


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("builtins:exit", "must be a class, but is a Quitter"),
        ("os:abort", "must be a class"),
        ("signal:pause", "must be a class"),
        ("not.there:Solver", "No module named"),
        ("torn_module:A", "cannot be imported (SyntaxError"),
        ("leaving_module:A", "cannot be imported (SystemExit: 0)"),
        ("chatty_module:A", "cannot be imported (ValueError: a b)"),
        ("misbehaving:Dishonest", "has no attribute 'Dishonest'"),
    ],
)
def test_whatever_an_import_does_is_one_sentence(tmp_path, monkeypatch, name, words):
    monkeypatch.syspath_prepend(str(tmp_path))
    for module, text in {
        "torn": "def",
        "leaving": "raise SystemExit(0)",
        "chatty": "raise ValueError('a\\nb')",
    }.items():
        (tmp_path / f"{module}_module.py").write_text(text)
    with pytest.raises(InputError) as refused:  # as the child does
        SOLVERS.make(name)
    assert words in str(refused.value)


def test_what_a_plug_in_refuses_is_its_row(cli, instance_folder, tmp_path):
    tables = "[[solvers]]\nname = 'misbehaving:Honest'\noptions = { dealy = '[/b]' }\n"
    path = study("os:fork", "builtins:exit")
    path.write_text(path.read_text() + tables)
    _, out, _ = cli("compare", path, "--out", "runs", "--jobs", 2)
    runs = [json.loads(path.read_text()) for path in (tmp_path / "runs").glob("*/*-s0-*.json")]
    told = {run["label"]: run["message"] for run in runs if run["status"] == "ERROR"}
    assert "must be a class" in told["os:fork"]
    assert "must be a class" in told["builtins:exit"]
    assert "did you mean 'delay'" in told["misbehaving:Honest (dealy=[/b])"]
    assert "dealy=[/b]" in out


def test_a_family_of_others_is_made_in_a_child(importers, cli):
    Path("study.toml").write_text("[[solvers]]\nname = 'greedy'\n" + FAMILY.replace("FAMILY", "marked-family"))
    assert "'marked-family'" in cli("compare", "study.toml", "--no-plugins")[2]
    assert importers() == []
    own, others = (FamilySource(name, 5, 2, 3, {"airspeed": 20}).load() for name in ("uniform", "marking:UNIFORM"))
    assert own.digest == others.digest
    assert importers() != [str(os.getpid())]
    with pytest.raises(InputError, match=r"family os:abort made no scenario \(ERROR: .*os:abort is no family"):
        make_elsewhere("os:abort", 3, 2, 0, {})


MISSION = {"airspeed": 20.0, "size": [1000, 1000], "depots": [[10, 10], [990, 10]], "radio": {"position": [1, 1]}}


def test_a_mission_places_and_costs_by_others_in_a_child():
    own = {"tests": [4, 4], "length_scale": 300.0, "method": "misplacing:Honest"}
    table = MISSION | {"tasks": 3, "place": own, "costs": {"method": "misplanning:Honest"}}
    mission = mission_of(table | {"sensing": {"period": 1.0}, "flight": {"turning_radius": 5.0}}, Path(), "m")
    placed = place_tasks(mission, mission.scenario.free, 3, "misplacing:Honest", {})
    instance, paths = moving_costs(mission, mission.scenario, placed.points)
    assert placed.mutual_information > 0
    assert instance.cost[0, 1] == np.hypot(*(placed.points[0] - placed.points[1])) / 20.0
    assert paths.n_nodes == 5
    assert not {"misplacing", "misplanning"} & set(sys.modules)


def test_a_method_of_others_is_given_the_maps_of_a_mission_and_criterion_j(tmp_path):
    (tmp_path / "w.csv").write_text("x,y,value\n100,500,9\n900,500,1\n")
    own = {"tests": [4, 4], "length_scale": 300.0, "criterion": "j", "weights": "w.csv", "prior_sd": "w.csv"}
    mission = mission_of(MISSION | {"tasks": 3, "place": own | {"method": "misplacing:Honest"}}, tmp_path, "m")
    placed = place_tasks(mission, mission.scenario.free, 3, "misplacing:Honest", {})
    goal = criterion_of(mission, mission.scenario.free)
    assert goal.kernel.relative_sd is not None
    assert placed.maximised == "j"
    assert placed.average_variance == pytest.approx(goal.judged.value(placed.points), rel=1e-12)
    with pytest.raises(InputError, match=r"misplacing:Stray found no task locations .*outside the region"):
        place_tasks(mission, mission.scenario.free, 3, "misplacing:Stray", {})


def test_a_damaged_package_is_passed_over(importers, tmp_path):
    registry: Registry[object] = Registry("solver", {"own": ("json:dumps", "ours")}, group="mmmdmtsp_workbench.solvers")
    assert registry.load("own") is json.dumps
    assert {"own", "marked", "odd"} <= set(registry.targets())
    with pytest.raises(InputError, match=r"unknown solver 'x'.*the entry points of 1 installed packages cannot"):
        registry.target("x")
    with pytest.raises(InputError, match="must be a name or module:attribute, got 'no target at all'"):
        registry.target("odd")
    assert ".marked" in endings()
    assert ".marked" in FORMATS.targets()
    (tmp_path / "a.json").write_text("{")
    with pytest.raises(InputError, match=r"a\.json"):
        read_instance(tmp_path / "a.json")
    assert importers() == []
