"""Stage 7, compare: what a person would fly otherwise, measured and mapped over the same field with the same UAVs.

lawnmower: the fewest lanes whose tours are at least as long as the mission's (`formulations.mapping.lawnmower`).
random: uniform random tasks, as many as make the tours at least as long; routed as the mission is.
greedy: as many tasks as the mission has, placed greedily; routed as the mission is.

Products: compare.csv (a row a flight plan, the mission first), compare-ticks.csv, tracks.csv.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from formulations.kernel import SquaredExponential
from formulations.mapping.flight import Flight
from formulations.mapping.flight_check import length_outside
from formulations.mapping.lawnmower import best_lawnmower
from formulations.mapping.map_grid import MapGrid
from formulations.mapping.survey import Survey, promised_sd
from instances.arrays import Floats
from instances.disk import write_aside
from instances.environment.radio import RadioMap
from instances.scenario import Scenario
from instances.scenario_folder import kept_field, kept_scenario
from workbench.mission.costs import moving_costs
from workbench.mission.flight import fly, kept_flights, track_frame
from workbench.mission.map import survey_of, ticks_frame
from workbench.mission.place import place_tasks, scales_of, widened
from workbench.mission.routes import solve
from workbench.mission.settings import Mission

Tell = Callable[[str], None]

MOST_TRIES = 3
"""Numbers of random tasks that are tried until the tours are long enough."""
MORE_TASKS = 1.75
"""So many times as many random tasks as placed ones make about equally long tours."""


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on."""
    return asdict(mission.compare)


@dataclass(frozen=True, eq=False)
class Plan:
    """One way to fly: its name, the draw it is, how many tasks (or lanes) it has, and the flights."""

    name: str
    draw: int
    count: int
    flights: list[Flight]

    @property
    def length(self) -> float:
        """Flown length of all UAVs [m]."""
        return sum(flight.length for flight in self.flights)


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Tell) -> str:
    """Fly and map every baseline."""
    scenario, field = kept_scenario(folders["environment"]), kept_field(folders["environment"])
    own = Plan("mission", 0, scenario.n_tasks, kept_flights(folders["flight"]))
    rows, ticks, tracks = [], [], []
    for plan in (own, *_plans(mission, scenario, own.length, tell)):
        survey = survey_of(mission, scenario.region, field, plan.flights)
        rows.append(_row(plan, survey, scenario))
        ticks.append(ticks_frame(survey).assign(name=plan.name, draw=plan.draw))
        tracks.append(track_frame(plan.flights).assign(name=plan.name, draw=plan.draw)[::20])
    table = pd.DataFrame(rows)
    write_aside(out / "compare.csv", table.to_csv(index=False))
    write_aside(out / "compare-ticks.csv", pd.concat(ticks).to_csv(index=False))
    write_aside(out / "tracks.csv", pd.concat(tracks).to_csv(index=False))
    return _said(table, field)


def _plans(mission: Mission, scenario: Scenario, length: float, tell: Tell) -> Iterator[Plan]:
    """Yield the baselines asked for."""
    wanted = mission.compare
    for name in wanted.baselines:
        tell(name)
        if name == "lawnmower":
            yield lawnmower(mission, scenario, length)
        elif name == "random":
            for draw in range(wanted.draws):
                yield _random(mission, scenario, length, draw)
        else:
            free = widened(scenario, mission.clearance).free
            points = place_tasks(mission, free, scenario.n_tasks, "greedy", {}).points
            yield Plan("greedy", 0, len(points), routed(mission, scenario, points))


def lawnmower(mission: Mission, scenario: Scenario, length: float) -> Plan:
    """Return the lawnmower of at least `length` [m] that promises least uncertainty before take-off."""
    promised = partial(
        promised_sd,
        points=MapGrid.over(scenario.region, 40).points,
        kernel=SquaredExponential(mission.map.signal_sd, scales_of(mission.map.length_scale)),
        noise_sd=mission.sensing.noise_sd,
        period=mission.sensing.period,
    )
    lanes, flights = best_lawnmower(
        scenario.free, scenario.depots, length, promised, speed=mission.speed, radius=mission.flight.turning_radius
    )
    return Plan("lawnmower", 0, lanes, flights)


def _random(mission: Mission, scenario: Scenario, length: float, draw: int) -> Plan:
    """Return random tasks, routed, so many that the tours are at least `length` [m] long."""
    free = widened(scenario, mission.clearance).free
    count = math.ceil(MORE_TASKS * scenario.n_tasks)
    for _ in range(MOST_TRIES):
        points = free.sample(count, np.random.default_rng([mission.compare.seed, draw]))
        plan = Plan("random", draw, count, routed(mission, scenario, points))
        if plan.length >= length:
            break
        count = math.ceil(1.03 * count * (length / plan.length) ** 2)  # tours grow with the root of the count
    return plan


def routed(mission: Mission, scenario: Scenario, points: Floats) -> list[Flight]:
    """Return the flights to `points`, by the mission's own moving costs and solver."""
    instance, paths = moving_costs(mission, scenario, points)
    routes = solve(mission, instance, mission.compare.time_limit, mission.compare.seed).own["routes"]
    assert routes is not None
    return fly(mission, scenario, instance, paths, routes).flights


def _row(plan: Plan, survey: Survey, scenario: Scenario) -> dict[str, Any]:
    end = survey.ticks[-1]
    row = {name: getattr(plan, name) for name in ("name", "draw", "count", "length")}
    row["longest"] = max(flight.length for flight in plan.flights)
    row["outside"] = length_outside(plan.flights, scenario.free)
    return row | {"samples": end.samples, "information": end.information} | asdict(end.score)


def _said(table: pd.DataFrame, field: RadioMap) -> str:
    shown = table.groupby("name", sort=False)[["length", "rmse", "nlpd"]].mean()
    return "; ".join(
        f"{name} {row['length'] / 1e3:.0f} km RMSE {row['rmse']:.2f} {field.unit} NLPD {row['nlpd']:.2f}"
        for name, row in shown.iterrows()
    )
