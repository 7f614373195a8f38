"""What is written for other software, where the mission has an origin: all in WGS 84.

Products, of the flight stage and, where plans change in flight, of the map stage, too: uav-K.plan, .waypoints, .kml and
.geojson of each tour, flown.geojson of the flown tracks, area.geojson of the region and the no-fly zones, exports.json
(what the heights of each tour start from, and why there are no plans of the others). A mission in local metres alone
has none of them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from shapely.geometry import LineString

from formulations.mapping.dubins import TURNS
from formulations.mapping.flight import Flight
from formulations.mapping.heights import Heights
from instances import Instance, Routes
from instances.arrays import Floats
from instances.disk import write_aside
from instances.formats.geojson import write_features
from instances.formats.ground_control import ENDINGS, write_tour
from instances.formats.mavlink_items import Vehicle
from instances.formats.tour import Tour
from instances.geodesy import TangentPlane
from instances.scenario import Scenario

SAME = 1e-3
"""Waypoints so near to one another [m] are at one place."""
ARC = np.pi / 4
"""Angle of a turn [rad] between waypoints along it, at most."""
STRAY = 2.0
"""An autopilot climbs evenly from waypoint to waypoint; waypoints keep it at most so many metres above the track."""


def tours_of(
    name: str,
    instance: Instance,
    routes: Routes,
    flights: Sequence[Flight],
    heights: Mapping[int, Heights],
    *,
    known: bool,
    turns: bool = False,
) -> dict[int, Tour]:
    """Return the tour of each UAV that has heights: it flies. known, turns : as of `tour_of`."""
    assert instance.coordinates is not None
    tours = {}
    for k, own in heights.items():
        tasks = {task: instance.coordinates[task] for task in routes[k]}
        tours[k] = tour_of(f"{name} UAV {k}", flights[k], own, tasks, known=known, turns=turns)
    return tours


def tour_of(
    name: str, flight: Flight, heights: Heights, tasks: Mapping[int, Floats], *, known: bool, turns: bool = False
) -> Tour:
    """Return the waypoints of a flight: where its legs begin, and where its height bends.

    tasks : number of each task on the tour → its place [m]. known : whether the ground's heights are known. turns :
    whether there are waypoints along the turns, too, where tasks alone would not say how they are flown over.
    """
    travelled = _waypoints(flight, heights, turns)
    points: Floats = flight.poses(travelled)[:, :2]
    numbers: list[int | None] = [None] * len(points)
    for task, place in tasks.items():
        away = np.hypot(*(points - place).T)
        for at in np.flatnonzero(away <= away.min() + SAME):  # once a lap
            numbers[int(at)] = task
    track = heights.at(travelled)
    track[0] = max(track[0], heights.track[-1])  # it comes back to its first waypoint
    evenly = np.interp(heights.travelled, [*travelled, flight.length], [*track, track[0]])
    track += max(0.0, float((heights.track - evenly).max()))  # never below the track
    ground = np.interp(travelled, heights.travelled, heights.ground) if known else None
    return Tour(name, points, numbers, track, flight.speed, ground)


def _waypoints(flight: Flight, heights: Heights, turns: bool) -> Floats:
    """Return the distances [m] of the waypoints: Douglas and Peucker's of the heights (1973), leg by leg."""
    ends = np.concatenate([[0.0], np.cumsum(flight.segments.sum(axis=1))])
    if turns:
        pieces = np.ceil(flight.segments / (ARC * flight.radius)).astype(np.int64)
        pieces[TURNS[flight.words] == 0] = 1
        within = np.repeat(flight.segments.ravel() / np.maximum(pieces.ravel(), 1), pieces.ravel()).cumsum()
        apart = np.append(np.inf, np.diff(within)) > SAME
        ends = np.concatenate([[0.0], within[apart & (within > SAME)]])
    kept = []
    for begin, end in pairwise(ends.tolist()):
        inside = heights.travelled[(heights.travelled > begin) & (heights.travelled < end)]
        s = np.concatenate([[begin], inside, [end]])
        track = LineString(np.column_stack([s, heights.at(s)]))
        kept += [at for at, _ in track.simplify(0.5 * STRAY).coords][:-1]
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
    without: Mapping[int, str] | None = None,
) -> None:
    """Write the tours (UAV → tour) and the flown tracks (columns uav, x, y [m]) into `out`.

    The scenario's borders are the geofence; heights are in `frame`. without : UAV → why it has no tour here.
    """
    region, no_fly = scenario.region.polygon, scenario.no_fly
    for k, tour in tours.items():
        for ending in ENDINGS:
            path = out / f"uav-{k}{ending}"
            write_tour(tour, plane, path, frame=frame, vehicle=vehicle, region=region, no_fly=no_fly)
    said = {f"UAV {k}": tour.said_of_heights(frame) for k, tour in tours.items()}
    missing = {f"UAV {k}": why for k, why in (without or {}).items()}
    write_aside(
        out / "exports.json", json.dumps({"heights": said} | ({"without": missing} if missing else {}), indent=1)
    )
    tracks = ((LineString(track[["x", "y"]].to_numpy()), {"uav": int(str(k))}) for k, track in flown.groupby("uav"))
    write_features(tracks, plane, out / "flown.geojson")
    area = [(region, {"kind": "region"}), *((zone, {"kind": "no-fly"}) for zone in no_fly)]
    write_features(area, plane, out / "area.geojson")
