"""The calm twin: what planning in the wind is worth, part of stage 7.

The same tasks are planned as if there were no wind, by the mission's own methods with its own limits, and what comes
out is flown in the wind. In calm air a tour costs the same either way round, so which way it is flown is the
planner's whim: the twin is judged as it came out and both ways, for each tour the better and the worse one.

Products, where the mission has a wind: calm.csv (a row a plan), calm-paths.csv (its reference paths).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from instances import Instance, Routes
from instances.arrays import Floats
from instances.disk import write_aside
from instances.environment.wind_changing import ChangingWind
from instances.files import read_routes
from instances.moving_cost import CostMeasure
from instances.paths import Paths
from instances.scenario import Scenario
from workbench.mission.costs import kept_costs, moving_costs
from workbench.mission.routes import SELECTION_FILE, solve
from workbench.mission.settings import Mission


def write_calm_twin(mission: Mission, scenario: Scenario, folders: dict[str, Path], out: Path) -> None:
    """Plan the twin and write its products; nothing where the mission has no wind, or one that changes.

    Nor where UAVs are not alike, tasks were left out, or tours do not follow the paths whose costs are compared.
    """
    if mission.flight.coupled or (folders["routes"] / SELECTION_FILE).exists():
        return
    if scenario.wind is None or isinstance(scenario.wind, ChangingWind) or not scenario.fleet.alike:
        return
    instance, paths = kept_costs(folders["costs"])
    assert instance.coordinates is not None
    still = replace(scenario, wind=None)
    calm_instance, calm_paths = moving_costs(mission, still, instance.coordinates[: instance.n_tasks])
    found = solve(mission, calm_instance, mission.routes.time_limit, mission.routes.seed)
    assert found.own["routes"] is not None
    own, calm = read_routes(folders["routes"] / "routes.sol", instance), found.own["routes"]
    measure = CostMeasure(scenario.cost, scenario.wind, scenario.speed)
    table = judged(measure, (instance, paths, own), (calm_paths, calm))
    expected = max(found.own["tour_costs"]), sum(found.own["tour_costs"])
    table.loc[len(table)] = ["promised", *expected]
    write_aside(out / "calm.csv", table.to_csv(index=False))
    write_aside(out / "calm-paths.csv", _polylines(calm_instance, calm_paths, calm).to_csv(index=False))


def judged(measure: CostMeasure, own: tuple[Instance, Paths, Routes], twin: tuple[Paths, Routes]) -> pd.DataFrame:
    """Return what plans cost by `measure`: columns plan, longest [s], total [s]. The plans:

    wind : as planned in it. paths : the twin's routes with the paths of the mission. calm : the twin as it came out.
    better, worse : each of its tours the cheaper and the dearer way round.
    """
    instance, paths, routes = own
    calm_paths, calm = twin

    def costs(along: Paths, tours: Routes) -> Floats:
        return tour_costs(measure, [along.along(stops(instance, k, tour)) for k, tour in enumerate(tours)])

    there, back = costs(calm_paths, calm), costs(calm_paths, tuple(tour[::-1] for tour in calm))
    plans = {
        "wind": costs(paths, routes),
        "paths": costs(paths, calm),
        "calm": there,
        "better": np.minimum(there, back),
        "worse": np.maximum(there, back),
    }
    rows = [(name, float(tours.max()), float(tours.sum())) for name, tours in plans.items()]
    return pd.DataFrame(rows, columns=["plan", "longest", "total"])


def tour_costs(measure: CostMeasure, polylines: Sequence[Floats]) -> Floats:
    """Return the moving cost C_k [s] along each polyline [m], shape (m,); 0 for one without points."""
    offsets = np.concatenate([[0], np.cumsum([len(line) for line in polylines])]).astype(np.int64)
    return measure.polylines(np.concatenate(polylines), offsets)


def stops(instance: Instance, uav: int, tour: Sequence[int]) -> tuple[int, ...]:
    """Return the nodes of a tour from its depot and back; none where the UAV stays home."""
    depot = instance.n_tasks + uav
    return (depot, *tour, depot) if tour else ()


def _polylines(instance: Instance, paths: Paths, routes: Routes) -> pd.DataFrame:
    lines = [paths.along(stops(instance, k, tour)) for k, tour in enumerate(routes)]
    uav = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    x, y = np.concatenate(lines).T
    return pd.DataFrame({"uav": uav, "x": x.round(2), "y": y.round(2)})
