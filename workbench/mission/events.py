"""Events of [replan]: what a mission file says of them, and the scenario that holds after each."""

from __future__ import annotations

import math
from dataclasses import replace

from shapely.geometry import Polygon

from instances.environment.region import Region
from instances.environment.wind import Uniform
from instances.errors import InputError, naming, shown
from instances.georeference import Georeference
from instances.moving_cost import CostKind
from instances.places import read_zones
from instances.scenario import Scenario
from workbench.mission.place import widened
from workbench.mission.settings import EventTable, Mission

TAKES = {"lost-uav": ("uav",), "no-fly": ("polygon", "file"), "wind": ("velocity",)}
"""Kind of event → its keys, of which it needs one."""


def check_replan(mission: Mission) -> None:
    """Raise InputError where [replan] does not fit the mission, naming the key."""
    if not mission.replan.wanted:
        return
    for number, event in enumerate(mission.replan.event, 1):
        with naming(f"[[replan.event]] {number}"):
            _check_event(mission, event)
    for _, scenario in scenarios_after(mission, mission.scenario):
        widened(scenario, mission.clearance)


def scenarios_after(mission: Mission, scenario: Scenario) -> list[tuple[EventTable, Scenario]]:
    """Return the events in order of time, each with the scenario that holds after it; InputError names the event."""
    found, now = [], replace(scenario, tasks=None, n_tasks=scenario.n_tasks)  # a zone may close over tasks
    for number, event in sorted(enumerate(mission.replan.event, 1), key=lambda each: each[1].time):
        with naming(f"[[replan.event]] {number}"):
            if event.kind == "no-fly":
                now = replace(now, no_fly=[*now.no_fly, *_zones(mission, event)])
            elif event.velocity is not None:
                now = replace(now, wind=Uniform(event.velocity))
        found.append((event, now))
    return found


def words_of(event: EventTable) -> str:
    """Return what happens, for people."""
    if event.kind == "lost-uav":
        return f"UAV {event.uav} is lost"
    if event.velocity is not None:
        return f"the wind is now ({event.velocity[0]:g}, {event.velocity[1]:g}) m/s"
    return "a no-fly zone appears"


def _check_event(mission: Mission, event: EventTable) -> None:
    for kind, keys in TAKES.items():
        given = [key for key in keys if getattr(event, key) is not None]
        if kind != event.kind and given:
            raise InputError(f'{given[0]} is of kind = "{kind}", and this is kind = "{event.kind}": leave it out')
        if kind == event.kind and len(given) != 1:
            raise InputError(f'kind = "{kind}" needs {" or ".join(keys)}' + (", not both" if given else ""))
    uavs, speed = mission.scenario.n_depots, mission.speed
    if event.uav is not None and event.uav >= uavs:
        raise InputError(f"uav must be the number of a UAV, 0 to {uavs - 1}, got {shown(event.uav)}")
    if event.velocity is not None and mission.scenario.cost is CostKind.TIME:
        wind, speed = math.hypot(*event.velocity), min(speed, mission.scenario.speed)
        if wind >= speed:
            raise InputError(f"velocity: a wind of {wind:g} m/s is as strong as the airspeed of {speed:g} m/s")


def _zones(mission: Mission, event: EventTable) -> tuple[Polygon, ...]:
    """Return the zones [m] of an event of kind no-fly."""
    if event.polygon is not None:
        with naming("polygon"):
            return (Region(Polygon(event.polygon)).polygon,)
    crs = mission.table.get("crs")
    reference = Georeference(mission.origin, crs if isinstance(crs, str) else "")
    return read_zones(event.file, mission.folder, mission.scenario.region, reference)
