"""`workbench place --polish`: a scenario's tasks placed and routed quickly, and the tours polished."""

from __future__ import annotations

import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd
from msgspec.structs import replace as with_keys
from shapely.geometry import LineString

from instances import InputError
from instances.disk import read_toml, write_aside
from instances.errors import naming
from instances.formats.geojson import write_features
from instances.scenario import Scenario
from workbench.mission.costs import moving_costs
from workbench.mission.file import mission_of
from workbench.mission.flight import fly_laps
from workbench.mission.place import kept_off, place_tasks, widened
from workbench.mission.polish import Judge, Plan, polished_plan
from workbench.mission.routes import solve
from workbench.mission.safety import refuse_beyond_borders
from workbench.mission.settings import Mission
from workbench.settings import check_target
from workbench.terminal import say, say_lines

QUICKLY = 2.0
"""Wall clock [s] of the routing at most."""


def run_polish(file: Path | None, out: Path | None, as_json: bool) -> None:
    """Place, cost, route and polish the mission or scenario in `file`; print what it is worth, write the waypoints."""
    if file is None or file.suffix.lower() != ".toml":
        raise InputError(f"place --polish: needs a scenario or mission file (.toml), got {file or 'none'}")
    check_target(out, (".csv", ".geojson"))
    mission = _mission(file)
    if out is not None and out.suffix == ".geojson" and mission.origin is None:
        raise InputError(f"{file}: origin: is not given, so {out.name} cannot be in degrees; write a .csv")
    mission = replace(mission, place=with_keys(mission.place, polish=True))
    with tempfile.TemporaryDirectory() as folder:
        plan = _polished(mission, Path(folder))
        said: dict[str, Any] = json.loads((Path(folder) / "polish.json").read_text())
        waypoints = pd.read_csv(Path(folder) / "polished.csv")
    if out is not None:
        _write(waypoints, mission, out)
    if as_json:
        click.echo(json.dumps({**said, "waypoints": waypoints.to_dict("records")}))
    else:
        lengths = zip(said["lengths_before"], said["lengths_after"], strict=True)
        km = ", ".join(f"UAV {k} {was / 1e3:.2f} → {now / 1e3:.2f} km" for k, (was, now) in enumerate(lengths))
        say_lines(f"{plan.said}\nflown: {km}")


def _mission(file: Path) -> Mission:
    """Return the mission in `file`, or one of its scenario: nothing is measured here, so none need say what is."""
    table = read_toml(file)
    nothing = {} if {"scenario", "radio", "field"} & set(table) else {"field": {"file": file.name}}
    with naming(file):
        return mission_of({**table, **nothing}, file.parent, file.stem)


def _polished(mission: Mission, folder: Path) -> Plan:
    """Return the polished plan, its products written to `folder`; InputError where it may not be flown."""
    scenario = mission.scenario
    instance, paths = moving_costs(mission, scenario, _tasks(mission, scenario))
    limits = np.minimum(instance.limits, mission.flight.endurance or np.inf)
    limited = instance if np.isinf(limits).any() else replace(instance, endurance=limits)
    routes = solve(mission, limited, min(QUICKLY, mission.routes.time_limit), mission.routes.seed).own["routes"]
    fleet, _ = fly_laps(mission, scenario, instance, paths, routes)
    judge = Judge(mission, scenario, None)
    before = (fleet.flights, fleet.legs)
    plan = polished_plan(judge, instance, routes, before, folder, lambda words: say(words, err=True))
    refuse_beyond_borders(mission, scenario, replace(instance, coordinates=plan.places), routes, plan.flights)
    return plan


def _tasks(mission: Mission, scenario: Scenario) -> Any:
    """Return the scenario's tasks (n, 2) [m], placed with room for turns where it gives none."""
    if scenario.tasks is not None:
        return scenario.tasks
    region = widened(scenario, mission.clearance).free
    inner = kept_off(region, scenario.region, mission.clearance) or region
    count, how = scenario.n_tasks, mission.place
    return place_tasks(mission, region, count, how.method, how.options, within=inner).points


def _write(waypoints: pd.DataFrame, mission: Mission, out: Path) -> None:
    """Write waypoints as CSV [m] or as a line a UAV in degrees."""
    if out.suffix == ".csv":
        write_aside(out, waypoints.to_csv(index=False))
        return
    assert mission.origin is not None
    tours = waypoints.groupby("uav")
    lines = [(LineString(tour[["x", "y"]].to_numpy()), {"uav": int(str(k))}) for k, tour in tours]
    write_features(lines, mission.origin, out)
