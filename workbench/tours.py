"""What lies beside an instance: the paths behind its costs, their scenario, and what chosen tours cost there."""

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import Any, NamedTuple

from formulations.moving_cost.fleet import classes_of
from instances import Instance, Routes, take_offs
from instances.disk import read_toml
from instances.errors import LONGEST_SENTENCE, InputError, one_line
from instances.fleet import Return
from instances.kept_ensemble import has_nodes_of, keep_ensemble, kept_ensemble
from instances.paths import Paths, paths_file, paths_of, read_paths_table
from instances.scenario import Scenario, read_scenario
from instances.tour_figures import TourFigures, tour_figures
from instances.wind_ensemble import Ensemble, Spread


class Beside(NamedTuple):
    """What was planned for an instance: the paths behind its costs and their scenario, each None where not known."""

    paths: Paths | None
    scenario: Scenario | None

    def tours(self, instance: Instance, routes: Routes) -> list[TourFigures]:
        """Return time, energy and calm-air cost of the tours, each at its UAV's speed, service left out.

        None where paths or scenario are not known, or where tours do not end where they began.
        """
        paths, scenario = self
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

    def spread(self, instance: Instance, routes: Routes) -> Spread | None:
        """Return what the longest tour takes over an ensemble; None where the scenario has none, or UAVs differ."""
        ensemble = Ensemble.of(*self)
        return None if ensemble is None else ensemble.flown(instance, routes)


def planned_beside(instance_file: Path, instance: Instance) -> Beside:
    """Return the paths beside an instance file and the scenario they were planned in.

    None for paths that are not there, and for a scenario that is not found or has other nodes by now; of a scenario
    that cannot be read a warning is logged. InputError where the paths are not those of `instance`.
    """
    kept = paths_file(instance_file)
    if not kept.exists():
        return Beside(None, None)
    table = read_paths_table(kept)
    paths = paths_of(table, instance, kept)
    try:
        return Beside(paths, _scenario_of(table, kept, instance))
    except InputError as error:
        if (kept.parent / str(table.get("scenario"))).is_file():
            _warn(f"{error}; so what the routes take in its wind is not told")
        return Beside(paths, None)


def _scenario_of(table: dict[str, Any], kept: Path, instance: Instance) -> Scenario | None:
    """Return the scenario that paths in `kept` name, None where it has other nodes; InputError where it is unread."""
    named = table.get("scenario")
    scenario = read_scenario(kept.parent / str(named)) if named else None
    return scenario if scenario is not None and has_nodes_of(scenario, instance) else None


def _warn(words: str) -> None:
    """Log a warning in one line."""
    logging.getLogger(__name__).warning(one_line(words, LONGEST_SENTENCE))


def keep_ensemble_beside(instance_file: Path, instance: Instance, folder: Path) -> None:
    """Keep the ensemble beside an instance file, which has paths, in `folder`, where none is yet.

    What of it cannot be used is logged: the instance is solved without.
    """
    kept = paths_file(instance_file)
    try:
        table = read_paths_table(kept)
        if not _names_members(table, kept) or _is_kept(folder, instance):
            return
        paths, scenario = paths_of(table, instance, kept), _scenario_of(table, kept, instance)
    except InputError as error:
        _warn(f"{error}; so reports will not say what routes take over the members of an ensemble")
        return
    if scenario is not None and Ensemble.of(paths, scenario) is not None:
        keep_ensemble(paths, scenario, instance, folder)


def _names_members(table: dict[str, Any], kept: Path) -> bool:
    """Say whether the scenario that paths in `kept` name, if it is there, has an ensemble."""
    file = kept.parent / str(table.get("scenario"))
    wind = read_toml(file).get("wind") if file.is_file() else None
    return isinstance(wind, dict) and bool(wind.get("members"))


def _is_kept(folder: Path, instance: Instance) -> bool:
    """Say whether `folder` keeps an ensemble that can be read."""
    try:
        return kept_ensemble(folder, instance) is not None
    except InputError:
        return False


def said_of(tour: TourFigures) -> str:
    """Return the figures of a tour that is flown, in words."""
    energy = "" if math.isnan(tour.energy) else f"energy cost {tour.energy:.6g} s at constant ground speed, "
    return (
        f"UAV {tour.uav}: {tour.length / 1e3:.2f} km, {tour.flight_time:.6g} s of flight at constant airspeed, {energy}"
        f"{tour.calm:.6g} s in calm air"
    )
