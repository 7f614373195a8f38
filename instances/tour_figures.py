"""What chosen tours take and cost along their reference paths: time, energy, and both in calm air.

In a wind that changes time is by the clock, every leg flown along the path that is quickest when it begins, and there
is no energy: the paper's says nothing of when a UAV is where.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from instances.arrays import Floats
from instances.environment.wind import WindField
from instances.environment.wind_changing import ChangingWind
from instances.errors import InputError
from instances.moving_cost import CostKind, CostMeasure
from instances.paths import Paths
from instances.paths_clocked import tour_by_clock
from instances.routes import Routes


@dataclass(frozen=True)
class TourFigures:
    """One UAV's tour at one speed v [m/s]; all 0 for a UAV that stays home.

    uav; tasks on it; length [m] of its reference path; flight_time [s] at the airspeed v (inf where the wind is as
    strong); energy [s] at the ground speed v, as seconds of flight in calm air, NaN in a wind that changes; calm [s],
    which both are without wind.
    """

    uav: int
    tasks: int
    length: float
    flight_time: float
    energy: float
    calm: float


def tour_figures(
    paths: Paths,
    routes: Routes,
    n_tasks: int,
    wind: WindField | None,
    speed: float,
    begins: Sequence[float] | Floats | None = None,
) -> list[TourFigures]:
    """Return what the tours of all UAVs take and cost; `paths` between n_tasks tasks and then the depots.

    begins (m,) [s] : their take-offs, which count in a wind that changes; 0 unless given.
    """
    rows = []
    for uav, route in enumerate(routes):
        stops = (n_tasks + uav, *route, n_tasks + uav) if route else ()
        if stops and isinstance(wind, ChangingWind):
            rows.append(_by_clock(paths, stops, uav, wind, speed, 0.0 if begins is None else float(begins[uav])))
            continue
        line = paths.along(stops) if route else np.zeros((1, 2))
        rows.append(line_figures(line, uav, len(route), wind, speed))
    return rows


def line_figures(line: Floats, uav: int, tasks: int, wind: WindField | None, speed: float) -> TourFigures:
    """Return what a tour past so many tasks takes and costs along `line` (k, 2) [m], a single point for one at home."""
    offsets = np.array([0, len(line)])
    length = float(np.hypot(*np.diff(line, axis=0).T).sum())
    calm = length / speed
    of_kind = dict.fromkeys(CostKind, calm if wind is None else 0.0)
    if wind is not None and len(line) > 1:
        for kind in CostKind:
            try:
                of_kind[kind] = float(CostMeasure(kind, wind, speed).polylines(line, offsets)[0])
            except InputError:
                of_kind[kind] = np.inf
    return TourFigures(uav, tasks, length, of_kind[CostKind.TIME], of_kind[CostKind.ENERGY], calm)


def _by_clock(
    paths: Paths, stops: tuple[int, ...], uav: int, wind: ChangingWind, speed: float, begins: float
) -> TourFigures:
    """Return what a tour through the nodes `stops` takes in a wind that changes, begun at `begins` [s]."""
    try:
        legs, landing = tour_by_clock(paths, stops, wind, speed, begins)
        time = landing - begins
    except InputError:
        legs, time = [paths.along(stops)], np.inf
    length = sum(float(np.hypot(*np.diff(leg, axis=0).T).sum()) for leg in legs)
    return TourFigures(uav, len(stops) - 2, length, time, np.nan, length / speed)
