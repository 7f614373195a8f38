"""Methods of others in a mission: imported and run in a child process, judged here, as in a study.

Routes come from a child process whoever made the solver (`workbench.mission.routes`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from shapely.geometry import mapping

from formulations.moving_cost.costing import instance_with
from formulations.moving_cost.method import MovingCosts
from formulations.task_location.placement import Placement, PlacementProblem, PlacementStatus, appraised
from formulations.task_location.variance_reduction import information_of
from instances import Instance
from instances.errors import InputError
from instances.paths import Paths
from instances.scenario import Scenario
from reports.record import Run
from workbench.jobs.job import Job
from workbench.jobs.problem import Problem
from workbench.jobs.runner import run
from workbench.mission.settings import PlaceSettings
from workbench.problems.moving_cost import MOVING_COST, MovingCostItem, costs_of
from workbench.problems.placement import PLACEMENT, PlacementItem

LONGEST = 3600.0
"""Seconds a method of others may take: a mission states no time limit for placing and for moving costs."""


def placement_by(problem: PlacementProblem, wanted: PlaceSettings, method: str, options: dict[str, Any]) -> Placement:
    """Return tasks for `problem` by a method that is not built in; InputError where it found none.

    The method is given the test points of the problem that lie in its region, with their weights, and nodes of the map
    of prior sd; what it finds is judged by all.
    """
    information = information_of(problem.criterion)
    kernel, weights = information.kernel, information.weights
    assert weights is not None  # a criterion has them
    setting = {
        "tests": np.column_stack([information.tests, weights]).tolist(),
        "signal_sd": kernel.signal_sd,
        "length_scale": ",".join(map(repr, kernel.length_scales)),
        "noise_sd": information.noise_sd,
        "criterion": wanted.criterion,
    }
    if (known := kernel.relative_sd) is not None:
        prior = kernel.signal_sd * known.values
        setting["prior_sd"] = {"x": known.x.tolist(), "y": known.y.tolist(), "values": prior.tolist()}
    polygon = json.loads(json.dumps(mapping(problem.region.polygon)))
    item = PlacementItem("mission", polygon, setting, problem.n_tasks)
    found = _run(PLACEMENT, item, method, options, wanted.seed)
    if found.own["points"] is None:
        raise InputError(f"place.method: {method} found no task locations ({found.status}: {found.message})")
    points = np.array(found.own["points"], dtype=float)
    worth = appraised(problem, points, method, PlacementStatus.HEURISTIC)
    return replace(worth, seed=wanted.seed, elapsed=found.elapsed, stopped_by=found.stopped_by)


def costs_by(scenario: Scenario, method: str, options: dict[str, Any]) -> tuple[Instance, Paths]:
    """Return the instance `scenario` becomes by a method that is not built in; InputError where it found no paths."""
    found = _run(MOVING_COST, MovingCostItem(scenario), method, options, 0)
    if found.own["cost"] is None:
        raise InputError(f"costs.method: {method} found no paths ({found.status}: {found.message})")
    cost, paths = costs_of({"cost": found.own["cost"], **found.own["paths"]})
    return instance_with(scenario, [MovingCosts(cost, paths, {})], method, options)


def _run(problem: Problem[Any], item: Any, method: str, options: Mapping[str, Any], seed: int) -> Run:
    return run(problem, Job("", method, options, seed, LONGEST), item)
