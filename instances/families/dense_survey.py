"""The family `dense-survey`: tasks a few turning radii apart, uniform in a square, flown over headings.

The side of the square follows from the spacing ratio ρ: side = ρ · r_min · √n. Costs are flight times, in calm air or
in a steady wind, in which headings are those of the air. Depots are free, so that UAVs take off and land in any
direction, or closed: a UAV lands with the heading it took off with, one of those that tasks have.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from instances.environment.region import Region
from instances.errors import InputError
from instances.families import depots
from instances.families.family import Family, Legs
from instances.families.parameter import GROUND_SPEED, Parameter
from instances.families.square import uniform_tasks
from instances.families.winds import PARAMETERS as WINDS
from instances.families.winds import make_wind
from instances.fleet import Fleet
from instances.moving_cost import CostKind
from instances.scenario import Scenario

KINDS = ("free", "closed")
"""Headings at depots to choose from."""
PARAMETERS = (
    replace(GROUND_SPEED, meaning="speed of the UAVs over ground, in wind through the air"),
    Parameter("spacing", 3.0, "", "spacing ratio: side of a task's share of the area, in turning radii", at_least=1e-3),
    Parameter("radius", 500.0, "m", "least turning radius", at_least=1e-3),
    Parameter("headings", 16, "", "uniform headings a task", at_least=0),
    Parameter("sights", 0, "", "nearest nodes whose lines of sight are headings too", at_least=0),
    Parameter("depot_headings", "free", "", "headings at take-off and landing: any, or one for both", KINDS),
    Parameter("wind", "none", "", "kind of wind", ("none", "uniform")),
    *(each for each in WINDS if each.name in ("wind_speed", "wind_direction")),
    *depots.PARAMETERS,
)


class DenseSurvey(Family):
    """The family: the square grows with the tasks."""

    def scenario(self, n_tasks: int, n_depots: int, seed: int, given: Mapping[str, Any]) -> Scenario:
        """Return the mission of this size and seed; tasks and depots come from separate streams of random numbers."""
        values = self.values(given)
        if not values["headings"] + values["sights"]:
            raise InputError(f"family {self.name}: headings and sights are both 0, and a task needs a heading")
        side = values["spacing"] * values["radius"] * n_tasks**0.5
        region = Region.rectangle(side, side)
        for_tasks, for_depots = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(2))
        blows = [] if values["wind"] == "none" else [f"{values['wind']}-wind"]
        wind = make_wind(region, values)
        return Scenario(
            name="-".join([self.name, *blows, f"n{n_tasks}", f"m{n_depots}", f"s{seed}"]),
            region=region,
            depots=depots.place_depots(region, n_depots, for_depots, values),
            speed=values["ground_speed"],
            wind=wind,
            tasks=self.tasks(region, n_tasks, for_tasks, values),
            provenance={"family": self.name, "parameters": values, "seed": seed},
            cost=CostKind.ENERGY if wind is None else CostKind.TIME,
            fleet=Fleet(turning_radii=np.full(n_depots, values["radius"])),
        )


DENSE_SURVEY = DenseSurvey(
    "dense-survey", PARAMETERS, lambda values: Region.rectangle(1.0, 1.0), uniform_tasks, Legs.TURNS
)
