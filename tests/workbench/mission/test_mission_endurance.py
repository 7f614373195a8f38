"""Missions within endurance: tasks that fit are flown, turns included."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from formulations.selection.selection_files import check_selection
from instances.errors import InputError
from instances.files import read_instance, read_routes
from instances.routes import makespan
from instances.scenario_folder import kept_scenario
from tests.workbench.mission.small import SMALL, again
from workbench.mission.flight import kept_flights
from workbench.mission.turns import flown_costs, refuse_beyond_endurance


@pytest.mark.slow
def test_where_endurance_does_not_suffice_the_tasks_that_tell_most_are_flown(mission_file: Path, copied: Path) -> None:
    instance = read_instance(copied / "3-costs/instance.json")
    all_of_them = makespan(instance, read_routes(copied / "4-routes/routes.sol", instance))
    text = SMALL.replace("[sensing]", f"[flight]\nendurance = {0.7 * all_of_them}\n\n[sensing]")
    assert again(mission_file, copied, text, only="routes") == ["routes"]
    found = json.loads((copied / "4-routes/selection.json").read_text())
    assert 0 < len(found["tasks"]) < instance.n_tasks
    assert check_selection(copied / "4-routes/selection.json", instance)[1] == []
    routes = read_routes(copied / "4-routes/routes.sol", instance, all_tasks=False)
    assert sorted(task for route in routes for task in route) == found["tasks"]
    assert makespan(instance, routes) <= 0.7 * all_of_them * (1 + 1e-9)
    assert again(mission_file, copied, text, only="flight") == ["flight"]
    assert again(mission_file, copied, text, only="report") == ["report"]
    assert "Endurance does not suffice for all tasks" in (copied / "8-report/report.html").read_text()
    enough = SMALL.replace("[sensing]", f"[flight]\nendurance = {1.1 * all_of_them}\n\n[sensing]")
    assert again(mission_file, copied, enough, only="routes") == ["routes"]
    assert not (copied / "4-routes/selection.json").exists()


def test_an_endurance_in_which_nothing_can_be_flown(mission_file: Path, copied: Path) -> None:
    text = SMALL.replace("[sensing]", "[flight]\nendurance = 1.0\n\n[sensing]")
    with pytest.raises(InputError, match=r"flight\.endurance: no task can be flown within the endurance"):
        again(mission_file, copied, text, only="routes")


def test_tours_fit_with_their_turns_and_what_would_not_is_refused(mission_file: Path, copied: Path) -> None:
    instance = read_instance(copied / "3-costs/instance.json")
    legs = makespan(instance, read_routes(copied / "4-routes/routes.sol", instance))
    scenario, before = kept_scenario(copied / "1-environment"), kept_flights(copied / "5-flight")
    just = 1.0001 * legs
    assert flown_costs(scenario, before).max() > just, "the case has no turns that matter"
    with pytest.raises(InputError, match=r"UAV \d would need .* turns included, .* its endurance"):
        refuse_beyond_endurance(scenario, before, np.full(2, just))
    text = SMALL.replace("[sensing]", f"[flight]\nendurance = {just}\n\n[sensing]")
    assert again(mission_file, copied, text, only="routes") == ["routes"]
    assert again(mission_file, copied, text, only="flight") == ["flight"]
    assert flown_costs(scenario, kept_flights(copied / "5-flight")).max() <= just
