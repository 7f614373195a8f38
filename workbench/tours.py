"""What lies beside an instance: the paths behind its costs, their scenario, and what chosen tours cost there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from formulations.moving_cost.fleet import classes_of
from instances import Instance, Routes, take_offs
from instances.errors import InputError
from instances.fleet import Return
from instances.paths import Paths, paths_file, paths_of, read_paths_table
from instances.scenario import Scenario, read_scenario
from instances.tour_figures import TourFigures, tour_figures
from instances.wind_ensemble import Spread, spread


def planned_beside(instance_file: Path, instance: Instance) -> tuple[Paths | None, Scenario | None]:
    """Return the paths beside an instance file and the scenario they were planned in.

    None for paths that are not there, and for a scenario that is not found or has other nodes by now. InputError where
    the paths are not those of `instance`.
    """
    kept = paths_file(instance_file)
    if not kept.exists():
        return None, None
    table = read_paths_table(kept)
    paths, named = paths_of(table, instance, kept), table.get("scenario")
    try:
        scenario = read_scenario(kept.parent / str(named)) if named else None
    except InputError:
        return paths, None
    if scenario is None or instance.coordinates is None or scenario.points.shape != instance.coordinates.shape:
        return paths, None
    return paths, scenario if np.allclose(scenario.points, instance.coordinates, atol=0.01) else None


def tours_beside(instance_file: Path, instance: Instance, routes: Routes) -> list[TourFigures]:
    """Return time, energy and calm-air cost of the tours, each at its UAV's speed, service left out.

    None without paths, where their scenario is not found, or where tours do not end where they began.
    """
    paths, scenario = planned_beside(instance_file, instance)
    if paths is None or scenario is None:
        return []
    speeds, classes = classes_of(scenario)
    if scenario.fleet.returns is not Return.OWN or len(paths.others) != len(speeds) - 1:
        return []
    of_speed = [
        tour_figures(paths.of_class(g), routes, instance.n_tasks, scenario.wind, speed, take_offs(instance, routes))
        for g, speed in enumerate(speeds)
    ]
    return [of_speed[g][uav] for uav, g in enumerate(classes)]


def spread_beside(instance_file: Path, instance: Instance, routes: Routes) -> Spread | None:
    """Return what the longest tour takes over an ensemble; None where the scenario has none, or UAVs differ."""
    paths, scenario = planned_beside(instance_file, instance)
    if paths is None or scenario is None or not scenario.fleet.alike:
        return None
    begins = take_offs(instance, routes)
    return spread(paths, routes, instance.n_tasks, scenario.wind, scenario.speed, begins)


def said_of(tour: TourFigures) -> str:
    """Return the figures of a tour that is flown, in words."""
    energy = "" if math.isnan(tour.energy) else f"energy cost {tour.energy:.6g} s at constant ground speed, "
    return (
        f"UAV {tour.uav}: {tour.length / 1e3:.2f} km, {tour.flight_time:.6g} s of flight at constant airspeed, {energy}"
        f"{tour.calm:.6g} s in calm air"
    )
