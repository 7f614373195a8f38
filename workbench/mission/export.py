"""What the flight stage writes for other software, where the mission has an origin: all in WGS 84.

Products: uav-K.plan, .waypoints, .kml and .geojson of each tour, flown.geojson of the flown tracks, exports.json (what
the heights of each tour start from). A mission in local metres alone has none of them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
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
from instances.formats.tour import Tour
from instances.geodesy import TangentPlane
from instances.scenario import Scenario

FRAME = "amsl"
"""What the heights in the files are above, as [flight] altitude is."""


def tours_of(
    name: str, instance: Instance, routes: Routes, flights: Sequence[Flight], altitude: float, ground: Terrain | None
) -> dict[int, Tour]:
    """Return the tour of each UAV that flies, `altitude` [m] above mean sea level, over `ground` where it is known."""
    assert instance.coordinates is not None
    tours = {}
    for k, (flight, route) in enumerate(zip(flights, routes, strict=True)):
        if flight.length == 0.0:
            continue
        points: Floats = flight.starts[:, :2]
        numbers: list[int | None] = [None] * len(points)
        for task in route:
            numbers[int(np.argmin(np.hypot(*(points - instance.coordinates[task]).T)))] = task
        below = None if ground is None else ground(points)
        heights = np.full(len(points), altitude)
        tours[k] = Tour(f"{name} UAV {k}", points, numbers, heights, flight.speed, below)
    return tours


def export(tours: Mapping[int, Tour], flown: pd.DataFrame, scenario: Scenario, plane: TangentPlane, out: Path) -> None:
    """Write the tours and the flown tracks (columns uav, x, y [m]) into `out`, with the scenario's borders as fence."""
    for k, tour in tours.items():
        for ending in ENDINGS:
            path = out / f"uav-{k}{ending}"
            write_tour(tour, plane, path, frame=FRAME, region=scenario.region.polygon, no_fly=scenario.no_fly)
    said = {f"UAV {k}": tour.said_of_heights(FRAME) for k, tour in tours.items()}
    write_aside(out / "exports.json", json.dumps({"heights": said}, indent=1))
    tracks = ((LineString(track[["x", "y"]].to_numpy()), {"uav": int(str(k))}) for k, track in flown.groupby("uav"))
    write_features(tracks, plane, out / "flown.geojson")
