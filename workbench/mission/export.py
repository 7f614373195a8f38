"""What the flight stage writes for other software, where the mission has an origin: all in WGS 84.

Products: uav-K.plan, .waypoints, .kml and .geojson of each tour, flown.geojson of the flown tracks, area.geojson of the
region and the no-fly zones, exports.json (what the heights of each tour start from). A mission in local metres alone
has none of them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from shapely.geometry import LineString

from formulations.mapping.flight import Flight
from instances import Instance, Routes
from instances.arrays import Floats
from instances.disk import write_aside
from instances.environment.terrain import Terrain
from instances.formats.geojson import write_features
from instances.formats.ground_control import ENDINGS, write_tour
from instances.formats.mavlink_items import Vehicle
from instances.formats.tour import Tour
from instances.geodesy import TangentPlane
from instances.scenario import Scenario

STRAY = 2.0
"""An autopilot climbs evenly from waypoint to waypoint; waypoints keep it at most so many metres above the track."""
STEP = 10.0
"""Distance between the heights of a level track [m]."""


@dataclass(frozen=True, eq=False)
class Profile:
    """Heights of a track and of the ground below it [m above mean sea level] after `travelled` [m]: arrays (k,).

    ground : None where it is not known.
    """

    travelled: Floats
    track: Floats
    ground: Floats | None


def level(flight: Flight, altitude: float, terrain: Terrain | None) -> Profile:
    """Return the profile of a flight at one `altitude` [m above mean sea level]."""
    s = np.append(np.arange(0.0, flight.length, STEP), flight.length)
    ground = None if terrain is None else terrain(flight.poses(s)[:, :2])
    return Profile(s, np.full(len(s), altitude), ground)


def tours_of(
    name: str, instance: Instance, routes: Routes, flights: Sequence[Flight], profiles: Mapping[int, Profile]
) -> dict[int, Tour]:
    """Return the tour of each UAV that has a profile: it flies."""
    assert instance.coordinates is not None
    return {
        k: tour_of(f"{name} UAV {k}", flights[k], profile, {task: instance.coordinates[task] for task in routes[k]})
        for k, profile in profiles.items()
    }


def tour_of(name: str, flight: Flight, profile: Profile, tasks: Mapping[int, Floats]) -> Tour:
    """Return the waypoints of a flight: where its legs begin, and where its height bends.

    tasks : number of each task on the tour → its place [m].
    """
    travelled = _waypoints(flight, profile)
    points: Floats = flight.poses(travelled)[:, :2]
    numbers: list[int | None] = [None] * len(points)
    for task, place in tasks.items():
        numbers[int(np.argmin(np.hypot(*(points - place).T)))] = task
    heights = np.interp(travelled, profile.travelled, profile.track)
    heights[0] = max(heights[0], profile.track[-1])  # it comes back to its first waypoint
    evenly = np.interp(profile.travelled, [*travelled, flight.length], [*heights, heights[0]])
    heights += max(0.0, float((profile.track - evenly).max()))  # never below the track
    ground = None if profile.ground is None else np.interp(travelled, profile.travelled, profile.ground)
    return Tour(name, points, numbers, heights, flight.speed, ground)


def _waypoints(flight: Flight, profile: Profile) -> Floats:
    """Return the distances [m] of the waypoints: Douglas and Peucker's of the heights (1973), leg by leg."""
    ends = np.concatenate([[0.0], np.cumsum(flight.segments.sum(axis=1))])
    kept = []
    for begin, end in pairwise(ends.tolist()):
        inside = profile.travelled[(profile.travelled > begin) & (profile.travelled < end)]
        s = np.concatenate([[begin], inside, [end]])
        heights = np.interp(s, profile.travelled, profile.track)
        kept += [at for at, _ in LineString(np.column_stack([s, heights])).simplify(0.5 * STRAY).coords][:-1]
    return np.array(kept)


def export(
    tours: Mapping[int, Tour],
    flown: pd.DataFrame,
    scenario: Scenario,
    plane: TangentPlane,
    out: Path,
    *,
    frame: str,
    vehicle: Vehicle,
) -> None:
    """Write the tours (UAV → tour) and the flown tracks (columns uav, x, y [m]) into `out`.

    The scenario's borders are the geofence; heights are in `frame`.
    """
    region, no_fly = scenario.region.polygon, scenario.no_fly
    for k, tour in tours.items():
        for ending in ENDINGS:
            path = out / f"uav-{k}{ending}"
            write_tour(tour, plane, path, frame=frame, vehicle=vehicle, region=region, no_fly=no_fly)
    said = {f"UAV {k}": tour.said_of_heights(frame) for k, tour in tours.items()}
    write_aside(out / "exports.json", json.dumps({"heights": said}, indent=1))
    tracks = ((LineString(track[["x", "y"]].to_numpy()), {"uav": int(str(k))}) for k, track in flown.groupby("uav"))
    write_features(tracks, plane, out / "flown.geojson")
    area = [(region, {"kind": "region"}), *((zone, {"kind": "no-fly"}) for zone in no_fly)]
    write_features(area, plane, out / "area.geojson")
