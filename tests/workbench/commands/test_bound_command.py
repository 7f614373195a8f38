"""`workbench bound`: what it prints, and that it notices a contradiction."""

import json
from dataclasses import replace

import pytest

from formulations.routing import bounds
from formulations.routing.bounds import Bound
from instances import makespan
from instances.best_known import BestKnown
from instances.files import write_instance, write_routes
from workbench.commands import bound as bound_command

NAMES = [*bounds.SIMPLE, "total", "relaxation", "branch-and-cut", "capped-total", "capped-tours", "destructive"]


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(bounds, "ROOTS", ("branch-and-cut",))
    monkeypatch.setattr(bound_command, "SEARCH", 0.2)


@pytest.fixture
def routes_file(tmp_path, instance):
    path = tmp_path / "routes.sol"
    write_routes(((0, 1), (2, 3)), instance, path)
    return path


def test_each_bound_with_time_and_gap_to_the_routes(cli, instance, instance_file, routes_file):
    code, out, _ = cli("bound", instance_file, "--routes", routes_file, "--json")
    assert code == 0
    told = json.loads(out)
    best = makespan(instance, ((0, 1), (2, 3)))
    assert told["best"] == best
    assert told["instance"] == instance.name
    assert told["digest"] == instance.digest
    assert [row["name"] for row in told["bounds"]] == NAMES
    for row in told["bounds"]:
        assert 0 < row["bound"] <= best
        assert row["gap"] == pytest.approx(1 - row["bound"] / best)
        assert row["elapsed"] >= 0
    assert told["bound"] == max(row["bound"] for row in told["bounds"])
    assert told["gap"] == min(row["gap"] for row in told["bounds"])


def test_text_names_bound_gap_and_source(cli, instance_file):
    code, out, err = cli("bound", instance_file)
    assert code == 0
    lines = out.splitlines()
    assert "a search of 0.2 s" in lines[1]
    assert lines[3].split() == ["Bound", "Value", "[s]", "Gap", "[%]", "Time", "[s]"]
    assert [line.split()[0] for line in lines[5:]] == NAMES
    assert "relaxation" in err  # progress


def test_the_best_known_value_is_used_where_there_is_one(cli, monkeypatch, instance, instance_file):
    known = BestKnown(instance.name, instance.digest, 4, 2, 12345.0, False, None, "a paper")
    monkeypatch.setattr("instances.best_known.best_known", lambda digest: known if digest == instance.digest else None)
    code, out, _ = cli("bound", instance_file, "--json")
    assert code == 0
    assert json.loads(out)["best"] == 12345.0
    assert json.loads(out)["best_from"] == "best known, a paper"


def test_where_no_routes_are_found_there_are_no_gaps(cli, tmp_path, instance):
    """Batteries for next to nothing: the bounds hold of whatever routes there are."""
    path = tmp_path / "limited.json"
    write_instance(replace(instance, endurance=[1.0, 1.0]), path)
    code, out, _ = cli("bound", path, "--json")
    assert code == 0
    told = json.loads(out)
    assert told["best"] is None
    assert told["gap"] is None
    assert [row["name"] for row in told["bounds"]] == NAMES
    assert {row["gap"] for row in told["bounds"]} == {None}
    assert "no routes known (a search of 0.2 s)" in cli("bound", path)[1].splitlines()[1]


def test_a_bound_above_the_routes_is_a_problem(cli, monkeypatch, instance_file, routes_file):
    monkeypatch.setattr(bounds, "lower_bounds", lambda *_, **__: iter([Bound("wrong", 1e9, 0.0)]))
    code, _, err = cli("bound", instance_file, "--routes", routes_file)
    assert code == 1
    assert "contradicts" in err


@pytest.mark.parametrize("time_limit", ["0", "-1"])
def test_nonsense_is_refused(cli, instance_file, time_limit):
    code, out, err = cli("bound", instance_file, "--time-limit", time_limit)
    assert code == 2
    assert out == ""
    assert "--time-limit: must be a positive number" in err


def test_a_missing_instance_is_named(cli):
    code, _, err = cli("bound", "nowhere.json")
    assert code == 2
    assert "nowhere.json" in err
