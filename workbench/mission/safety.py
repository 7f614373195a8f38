"""Safety: flights that leave the region, enter a no-fly zone or come too near to the ground are refused.

That is before anything of them is written.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from shapely.geometry import Polygon

from formulations.mapping.flight import Flight
from formulations.mapping.flight_check import RESOLUTION, Margin, margin
from formulations.mapping.heights import Frame, Heights
from instances import Instance, Routes
from instances.environment.region import Region
from instances.errors import InputError
from instances.extent import LEAST
from instances.geodesy import on_earth
from instances.scenario import Scenario
from workbench.mission.place import zones_of
from workbench.mission.settings import Mission


def room_to_fly(mission: Mission, scenario: Scenario) -> Polygon | None:
    """Return where tracks may be: the free region less flight.border_clearance; None where that leaves no one piece."""
    room = scenario.free.polygon.buffer(0.25 * RESOLUTION - mission.flight.border_clearance)
    return room if isinstance(room, Polygon) and not room.is_empty else None


def refuse_beyond_borders(
    mission: Mission, scenario: Scenario, instance: Instance, routes: Routes, flights: Sequence[Flight]
) -> None:
    """Raise InputError where a flight keeps less than flight.border_clearance from region border or no-fly zones.

    The sentence names the UAV, the worst place, by how much, and the task or depot that stands too near.
    """
    wanted = mission.flight.border_clearance
    for uav, (flight, route) in enumerate(zip(flights, routes, strict=True)):
        if flight.length == 0.0:
            continue
        found = margin(flight, scenario.region, zones_of(scenario))
        if found.distance >= wanted - RESOLUTION:
            continue
        x, y = found.place
        how = (
            f"would fly up to {-found.distance:.1f} m beyond the region's border or into a no-fly zone"
            if found.distance < 0
            else f"would come within {found.distance:.1f} m of the region's border or a no-fly zone"
        )
        asked = f" (flight.border_clearance = {wanted:g} m)" if wanted > 0 else ""
        stops = {f"tasks[{task}]": task for task in route} | {f"depots[{uav}]": instance.n_tasks + uav}
        why = _too_near(mission, scenario, instance, stops, found)
        raise InputError(f"UAV {uav} {how} at [{x:.1f}, {y:.1f}]{on_earth(scenario.plane, (x, y))}{asked}{why}")


def _too_near(mission: Mission, scenario: Scenario, instance: Instance, stops: dict[str, int], found: Margin) -> str:
    """Return which of `stops` (label → node) is the reason for a margin too small, or "" where none is."""
    assert instance.coordinates is not None
    turn = 2 * mission.flight.turning_radius
    free: Region = scenario.free
    points = instance.coordinates[list(stops.values())]
    away = np.hypot(*(points - found.place).T)
    room = free.signed_distance(points)
    reasons = np.flatnonzero((away <= 2 * turn) & (room < turn + mission.flight.border_clearance))
    if not len(reasons):
        return ""
    nearest = int(reasons[np.argmin(away[reasons])])
    x, y = points[nearest]
    return (
        f": {list(stops)[nearest]} at [{x:.1f}, {y:.1f}] stands {max(0.0, room[nearest]):.1f} m from it, and a turn of "
        f"flight.turning_radius = {mission.flight.turning_radius:g} m takes up to {turn:g} m"
    )


def refuse_near_ground(mission: Mission, flights: Sequence[Flight], heights: Mapping[int, Heights]) -> None:
    """Raise InputError where the track of a UAV (its number → heights) is nearer to the ground than flight.clearance.

    The sentence names the UAV, the worst place and by how much.
    """
    wanted = mission.flight.clearance
    for uav, found in heights.items():
        if found.clearance >= wanted - LEAST:
            continue
        k = found.nearest
        x, y, _ = flights[uav].poses(found.travelled[k])[0]
        how = (
            f"would fly {-found.clearance:.1f} m below the ground"
            if found.clearance < 0
            else f"would come within {found.clearance:.1f} m of the ground"
        )
        follow = (
            "" if mission.altitude.frame is Frame.ABOVE_GROUND else ' or follow it by flight.frame = "above-ground"'
        )
        raise InputError(
            f"UAV {uav} {how} at [{x:.1f}, {y:.1f}]{on_earth(mission.origin, (x, y))}, where the ground is "
            f"{found.ground[k]:.1f} m and the track "
            f"{found.track[k]:.1f} m above mean sea level (flight.clearance = {wanted:g} m): raise flight.altitude"
            f"{follow}"
        )
