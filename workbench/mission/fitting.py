"""Whether the settings of a mission fit together: known names, counts, and lengths that cannot be in metres."""

from __future__ import annotations

import os
from typing import Any

from formulations.mapping.heights import Frame
from formulations.moving_cost.registry import METHODS as COST_METHODS
from formulations.routing.registry import SOLVERS
from formulations.task_location.registry import METHODS as PLACEMENT_METHODS
from instances.environment.radio import RadioSource
from instances.environment.wind_changing import ChangingWind
from instances.environment.wind_terrain import TerrainWind
from instances.errors import InputError, shown
from instances.instance import check_size
from instances.registry import LARGEST, MethodRegistry
from workbench.mission.clock import check_clock
from workbench.mission.events import check_replan
from workbench.mission.place import value_map, value_maps
from workbench.mission.settings import MOST_LAPS, SMALLEST, Mission

MOST_G = 200.0
"""Load factors beyond this are no flight but a length in the wrong unit (the paper's own example flies 20 g)."""


def check_mission(mission: Mission) -> None:
    """Raise InputError where settings do not fit together."""
    scenario = mission.scenario
    if scenario.n_tasks < scenario.n_depots:
        raise InputError(f"there are more UAVs ({scenario.n_depots} depots) than tasks ({scenario.n_tasks})")
    if not scenario.fleet.alike:
        raise InputError(
            "[[uav]] speed and turning_radius, service and return: a mission flies all UAVs at one speed, past its "
            "tasks without a stop and home to their own depots, with turns of flight.turning_radius; workbench costs "
            "and workbench solve take a scenario with them"
        )
    if scenario.fleet.window:
        raise InputError(
            "window: all UAVs of a mission take off at once; workbench costs and workbench solve take such scenarios"
        )
    if isinstance(scenario.wind, ChangingWind):
        check_clock(mission)
    if mission.routes.risk is not None and not getattr(scenario.wind, "members", ()):
        raise InputError(f"routes.risk: {mission.routes.risk} is over an ensemble of forecasts: give [wind] members")
    check_size(scenario.n_tasks, scenario.n_depots)
    for key, methods, name, options in methods_of(mission):
        try:
            methods.asked(name, options)
        except ImportError as error:
            raise InputError(f"{key}: {name} is not available here: {error}") from None
    if mission.map.mean != "constant" and scenario.radio is None:
        raise InputError(f'map.mean = "{mission.map.mean}" needs the transmitter: give a table [radio]')
    if mission.field.file is None:
        if scenario.radio is None:
            raise InputError('there is nothing to measure: give a table [radio], or [field] with file = "…"')
        RadioSource.from_table(scenario.radio)
    elif not os.path.isfile(mission.folder / mission.field.file):
        raise InputError(f"field.file: there is no file {mission.folder / mission.field.file}")
    if mission.field.tau is not None and not (mission.field.file is None and mission.field.shadowing_sd > 0):
        why = "field.shadowing_sd is 0" if mission.field.file is None else "the field is a file"
        raise InputError(f"field.tau is of the shadowing that drifts, and {why}: leave field.tau out")
    if mission.flight.laps == "endurance" and mission.flight.endurance is None and scenario.fleet.endurance is None:
        raise InputError('flight.laps = "endurance" needs one: give flight.endurance, or [[uav]] endurance')
    if mission.place.weights is not None and mission.place.criterion == "ig":
        raise InputError("place.weights: criterion ig looks at no test points, so weights say nothing; take j, b or a")
    if mission.flight.coupled:
        _check_coupled(mission)
    value_maps(mission)
    if mission.map.prior_sd is not None:
        value_map(mission, "map.prior_sd", mission.map.prior_sd, mission.map.signal_sd)
    check_replan(mission)
    _check_units(mission)


def _check_coupled(mission: Mission) -> None:
    """Raise InputError where routes and headings of this mission cannot be planned together."""
    from formulations.moving_cost.turns.scenario import steady_wind  # here: numba takes its time

    others = {
        "flight.laps": mission.flight.laps != 1,
        "flight.endurance": mission.flight.endurance is not None,
        "[[uav]] endurance": mission.scenario.fleet.endurance is not None,
        "place.polish": mission.place.polish,
        "[replan]": mission.replan.wanted,
    }
    for key, asked in others.items():
        if asked:
            raise InputError(f"flight.coupled: headings are planned for tours flown once, as planned: leave {key} out")
    try:
        steady_wind(mission.scenario)
    except InputError as error:
        raise InputError(f"flight.coupled: {error}") from None
    solver = mission.routes.solver
    if solver in SOLVERS.built_in and "states" not in SOLVERS.make(solver, mission.routes.options).axes:
        raise InputError(f"flight.coupled: routes.solver = {solver!r} takes no states; memetic and subset-dp do")


def methods_of(mission: Mission) -> list[tuple[str, MethodRegistry[Any], str, dict[str, Any]]]:
    """Return what the mission says of each sub-problem's method: its key, where it is registered, name and options."""
    place, costs, routes = mission.place, mission.costs, mission.routes
    return [
        ("place.method", PLACEMENT_METHODS, place.method, place.options),
        ("costs.method", COST_METHODS, costs.method, costs.options),
        ("routes.solver", SOLVERS, routes.solver, routes.options),
    ]


def refuse_plugins(mission: Mission) -> None:
    """Raise InputError where a method of the mission is not built in: it would be code of others."""
    for key, methods, name, _ in methods_of(mission):
        if name not in methods.built_in:
            raise InputError(f"--no-plugins: {key} = {shown(name)} is not built in")


def _check_units(mission: Mission) -> None:
    """Refuse lengths that cannot be in metres, and a sensing period that no tour can last."""
    x0, y0, x1, y1 = mission.scenario.region.bounds
    size = max(x1 - x0, y1 - y0)
    for name, given in (("place", mission.place.length_scale), ("map", mission.map.length_scale)):
        for scale in given if isinstance(given, list) else [given]:
            if scale <= size / 1000:
                raise InputError(
                    f"{name}.length_scale = {scale:g} m is at most a thousandth of the region ({size:g} m): "
                    "lengths are in metres"
                )
    radius, speed = mission.flight.turning_radius, mission.speed
    if not SMALLEST <= speed <= LARGEST:
        raise InputError(f"a speed of {speed:g} m/s cannot be flown: speeds are in m/s")
    load = speed**2 / radius / 9.81
    if load > MOST_G:
        raise InputError(
            f"flight.turning_radius = {radius:g} m at {speed:g} m/s would need {load:.0f} g: lengths are in metres"
        )
    known = mission.scenario.terrain is not None or isinstance(mission.scenario.wind, TerrainWind)
    if mission.origin is not None and mission.altitude.frame is Frame.ABOVE_GROUND and not known:
        raise InputError(
            'flight.frame = "above-ground" without terrain: plans for ground control need the height of the ground; '
            "give terrain or leave out origin"
        )
    if mission.altitude.frame is Frame.ABOVE_GROUND and mission.flight.altitude < mission.flight.clearance:
        raise InputError(
            f"flight.altitude = {mission.flight.altitude:g} m above the ground is less than flight.clearance = "
            f"{mission.flight.clearance:g} m"
        )
    if radius > size / 4:
        raise InputError(f"flight.turning_radius = {radius:g} m is more than a quarter of the region ({size:g} m)")
    tasks = mission.scenario.n_tasks
    laps = mission.flight.laps if isinstance(mission.flight.laps, int) else MOST_LAPS
    longest = laps * (tasks + 1) * 2 * ((x1 - x0) + (y1 - y0)) / speed  # the flight stage knows the tours themselves
    if mission.sensing.period > longest:
        raise InputError(
            f"sensing.period = {mission.sensing.period:g} s is longer than any tour of {tasks} tasks could last "
            f"({longest:.0f} s)"
        )
