"""Missions in a wind that changes: what they cannot do, whether their clocks are right, and what the clock is worth.

The flights' clocks are integrated once more, by Kutta's rule along the polyline of the flown track, by other code than
the one that made them. A flight that lasts longer than its UAV's endurance is refused.

Products of stage 7, where the wind changes: static.json: what a plan for the wind of take-off promised for its longest
tour, what that takes by the clock, as planned and in the better directions, and what the mission's routes take [s].
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from formulations.mapping.flight import Flight
from formulations.moving_cost.registry import METHODS
from formulations.routing.registry import SOLVERS
from formulations.routing.solver import ABLE
from instances import makespan
from instances.arrays import Floats
from instances.disk import write_aside
from instances.environment.wind_changing import ChangingWind
from instances.errors import InputError
from instances.files import read_routes
from instances.frozen import frozen, judged
from instances.routes import ENDURANCE_ROUNDING
from instances.scenario import Scenario
from instances.wind_flights import polyline_times
from workbench.mission.costs import kept_costs
from workbench.mission.routes import solve
from workbench.mission.settings import Mission

STATIC_FILE = "static.json"
STEP = 20.0
"""Distance [m] between the points of a track whose clock is integrated again."""
AGREES = 2e-3
"""Share of a flight's time by which both clocks may differ: corners of the polyline cut turns off."""


def check_clock(mission: Mission) -> None:
    """Raise InputError where a mission in a wind that changes asks for what needs one that stays."""
    wanted = {
        "[replan]: plans change in flight": mission.replan.wanted,
        "place.polish: paths are polished": mission.place.polish,
        "flight.laps: tours are flown more than once": mission.flight.laps != 1,
        "flight.coupled: tours are planned with their turns": mission.flight.coupled,
        "flight.speed: another than the airspeed that is planned with is flown": mission.speed
        != mission.scenario.speed,
        f"costs.method: {mission.costs.method} plans": mission.costs.method not in METHODS.built_in,
    }
    for words, there in wanted.items():
        if there:
            raise InputError(f"{words} only in a wind that stays, and [wind] changes with time")
    name = mission.routes.solver
    if name in SOLVERS.built_in and "time" not in SOLVERS.make(name, mission.routes.options).axes:
        raise InputError(f"routes.solver: {name} cannot take costs that change with time; {ABLE['time']}")


def refuse_wrong_clocks(scenario: Scenario, flights: Sequence[Flight]) -> float:
    """Return by what share two integrations of the flights' clocks differ at most; RuntimeError where by much."""
    assert isinstance(scenario.wind, ChangingWind)
    worst = 0.0
    for uav, flight in enumerate(flights):
        if flight.length == 0.0:
            continue
        track = flight.poses(np.append(np.arange(0.0, flight.length, STEP), flight.length))[:, :2]
        one, begun = np.zeros(1, dtype=np.int64), np.zeros(1)
        again = float(polyline_times(track, np.array([0, len(track)]), one, begun, scenario.wind, flight.speed)[0])
        worst = max(worst, abs(again - flight.duration) / again)
        if worst > AGREES:
            raise RuntimeError(
                f"the independent check refutes the clock of UAV {uav}: {flight.duration:.1f} s, not {again:.1f} s"
            )
    return worst


def refuse_beyond_endurance(flights: Sequence[Flight], limits: Floats) -> None:
    """Raise InputError where a flight lasts longer than its UAV's endurance; `limits` (m,) [s]."""
    for uav, (flight, limit) in enumerate(zip(flights, limits.tolist(), strict=True)):
        if flight.duration > limit * (1 + ENDURANCE_ROUNDING):
            raise InputError(
                f"UAV {uav} would fly {flight.duration:.1f} s, turns included, and its endurance is {limit:.1f} s: "
                "give more flight.endurance, or fewer tasks"
            )


def held(scenario: Scenario, duration: float) -> str:
    """Return a sentence where flights of `duration` [s] outlast the forecast, else ""."""
    lasts = getattr(scenario.wind, "lasts", np.inf)
    if duration <= lasts:
        return ""
    return f"the forecast ends {lasts:.0f} s after take-off, its last frame is held for up to {duration - lasts:.0f} s"


def write_static_plan(mission: Mission, scenario: Scenario, folders: dict[str, Path], out: Path) -> None:
    """Route for the wind of take-off with the mission's own solver and limit, and write what the plan is worth.

    Nothing where the wind stays.
    """
    if not isinstance(scenario.wind, ChangingWind):
        return
    instance, _ = kept_costs(folders["costs"])
    found = solve(mission, replace(frozen(instance), endurance=None), mission.routes.time_limit, mission.routes.seed)
    static = judged(instance, found.own["routes"])
    own = makespan(instance, read_routes(folders["routes"] / "routes.sol", instance))
    said = {"promised": static.promised, "taken": static.taken, "directed": static.directed, "clocked": own}
    write_aside(out / STATIC_FILE, json.dumps(said))
