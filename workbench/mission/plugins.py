"""Methods of others in a mission: imported and run in a child process, judged here, as in a study.

Routes come from a child process whoever made the solver (`workbench.mission.routes`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from shapely.geometry import mapping

from formulations.moving_cost.costing import instance_with
from formulations.moving_cost.method import MovingCosts
from formulations.task_location.placement import Placement, PlacementStatus
from formulations.task_location.variance_reduction import NAME
from instances import Instance
from instances.environment.region import Region
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


def placement_by(wanted: PlaceSettings, region: Region, count: int, method: str, options: dict[str, Any]) -> Placement:
    """Return `count` tasks in `region` by a method that is not built in; InputError where it found none."""
    if wanted.criterion == NAME or wanted.weights or wanted.prior_sd:
        raise InputError(
            f"place.method: {method} is not built in, and is given no maps and no criterion j: leave weights, prior_sd "
            "and criterion out, or take another method"
        )
    scales = wanted.length_scale if isinstance(wanted.length_scale, list) else [wanted.length_scale]
    setting = {
        "tests": "x".join(map(str, wanted.tests)),
        "signal_sd": wanted.signal_sd,
        "length_scale": ",".join(map(repr, scales)),
        "noise_sd": wanted.noise_sd,
        "criterion": wanted.criterion,
    }
    polygon = json.loads(json.dumps(mapping(region.polygon)))
    found = _run(PLACEMENT, PlacementItem("mission", polygon, setting, count), method, options, wanted.seed)
    if found.own["points"] is None:
        raise InputError(f"place.method: {method} found no task locations ({found.status}: {found.message})")
    return Placement(
        points=np.array(found.own["points"], dtype=float),
        mutual_information=found.own["mutual_information"],
        method=method,
        status=PlacementStatus.HEURISTIC,
        seed=wanted.seed,
        elapsed=found.elapsed,
        information=found.own["information"],
        stopped_by=found.stopped_by,
    )


def costs_by(scenario: Scenario, method: str, options: dict[str, Any]) -> tuple[Instance, Paths]:
    """Return the instance `scenario` becomes by a method that is not built in; InputError where it found no paths."""
    found = _run(MOVING_COST, MovingCostItem(scenario), method, options, 0)
    if found.own["cost"] is None:
        raise InputError(f"costs.method: {method} found no paths ({found.status}: {found.message})")
    cost, paths = costs_of({"cost": found.own["cost"], **found.own["paths"]})
    return instance_with(scenario, [MovingCosts(cost, paths, {})], method, options)


def _run(problem: Problem[Any], item: Any, method: str, options: Mapping[str, Any], seed: int) -> Run:
    return run(problem, Job("", method, options, seed, LONGEST), item)
