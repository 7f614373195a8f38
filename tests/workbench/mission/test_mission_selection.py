"""What is flown where endurance does not suffice and "j" is asked for: what lowers the weighted mean variance."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from formulations.limits import Limits
from formulations.routing.solver import Status
from formulations.selection.registry import make_method
from formulations.selection.selection import SelectionProblem, select
from formulations.selection.selection_files import check_selection
from formulations.selection.worth import Worth
from formulations.task_location.setting import goal_of
from formulations.task_location.variance_reduction import VarianceReduction
from instances import Instance
from instances.environment.region import Region
from workbench.mission.selection import by_variance

REGION = Region.rectangle(20_000.0, 20_000.0)


def test_weights_move_what_is_flown_and_the_file_stays_true(tmp_path: Path) -> None:
    places = np.vstack([REGION.sample(11, np.random.default_rng(3)), [[10_000.0, 10_000.0]]])
    cost = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) / 30.0
    instance = Instance("x", cost, 11, 1, coordinates=places, endurance=np.array([1100.0]))
    tests = [[x, y, 100.0 if x < 7000.0 else 1.0] for x, y in REGION.cell_centres(6, 6)]
    goal = goal_of(REGION, criterion="j", tests=tests)
    assert isinstance(goal, VarianceReduction)
    problem = SelectionProblem(instance, Worth.of_information(goal.information, places[:11]))
    found = select(problem, make_method("exact"), "exact", limits=Limits(time=20.0))
    assert 0 < len(found.tasks) < 11
    better, said = by_variance(found, goal, places[:11], 20.0)
    assert goal.value(places[list(better.tasks)]) > goal.value(places[list(found.tasks)]) + 0.1
    assert better.worth <= found.worth <= better.bound
    assert better.status == Status.FEASIBLE
    assert "by criterion j" in said
    (tmp_path / "selection.json").write_text(json.dumps(better.as_dict()))
    assert check_selection(tmp_path / "selection.json", instance)[1] == []
