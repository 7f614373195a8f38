"""The problems the machinery of `workbench.jobs` can run, one file each."""

from __future__ import annotations

from typing import Any

from instances.registry import Registry
from workbench.jobs.problem import Problem

PROBLEMS: Registry[Problem[Any]] = Registry(
    "problem",
    {
        "routing": ("workbench.problems.routing:ROUTING", "routes: the min-max multi-depot multiple TSP"),
        "placement": ("workbench.problems.placement:PLACEMENT", "task locations of most information in a region"),
        "moving-cost": (
            "workbench.problems.moving_cost:MOVING_COST",
            "paths and costs between all nodes of a scenario",
        ),
        "survey": ("workbench.problems.survey:SURVEY", "plans that are flown, measured and mapped within endurance"),
    },
)
"""Name, as in a study's ``problem = …`` and in every stored run → the problem."""
