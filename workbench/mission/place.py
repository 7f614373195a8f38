"""Stage 2, place: task locations of most information (sub-problem 1), or those the scenario gives.

Products: tasks.csv (local metres), placement.json and, where the mission has an origin, tasks.geojson (WGS 84);
weights.nc and prior_sd.nc where the mission has such maps.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import shapely
from msgspec import structs
from shapely.geometry import Point, Polygon

from formulations.task_location.certificate import certificate
from formulations.task_location.criterion import Convention, Criterion
from formulations.task_location.placement import Placement, PlacementProblem, place
from formulations.task_location.registry import METHODS
from formulations.task_location.setting import kernel_of, rows_of_tests, weights_of
from formulations.task_location.variance_reduction import NAME, Goal, VarianceReduction
from instances.arrays import Floats
from instances.disk import write_aside
from instances.environment.region import Region
from instances.environment.value_map import ValueMap
from instances.errors import InputError, naming
from instances.formats.geojson import write_features
from instances.geodesy import TangentPlane
from instances.scenario import Scenario
from instances.scenario_folder import keep_value_map, kept_scenario
from instances.value_maps import read_value_map
from workbench.mission.plugins import placement_by
from workbench.mission.settings import Mission
from workbench.mission.stamp import referenced_files

INLET = 0.1
"""Share of the room for turns; inlets less deep bend no path by so much that turns leave the region."""


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on."""
    origin = None if mission.origin is None else asdict(mission.origin)
    files = referenced_files([mission.place.weights, mission.place.prior_sd], mission.folder)
    own = {key: value for key, value in structs.asdict(mission.place).items() if key != "polish"}  # of the flights
    return own | {"clearance": mission.clearance, "origin": origin, "files": files}


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Write the tasks."""
    scenario = kept_scenario(folders["environment"])
    region = widened(scenario, mission.clearance).free
    for name, given in value_maps(mission).items():
        keep_value_map(given, name, out, mission.origin)
    if scenario.tasks is not None:
        write_tasks(scenario.tasks, out, {"method": "given", "points": scenario.tasks.tolist()}, mission.origin)
        return f"{scenario.n_tasks} tasks were given"
    tell(f"placing {scenario.n_tasks} tasks by {mission.place.method}")
    found = place_tasks(mission, region, scenario.n_tasks, mission.place.method, mission.place.options)
    inner = kept_off(region, scenario.region, mission.clearance)
    if inner is not None and not inner.contains(found.points).all():
        tell(f"tasks nearer than {mission.clearance:g} m to the border leave no room for turns: placing them inside")
        found = place_tasks(
            mission, region, scenario.n_tasks, mission.place.method, mission.place.options, within=inner
        )
    if mission.place.certificate:
        bound = certificate(criterion_of(mission, region).under(Convention.BOTH_NOISY), region, scenario.n_tasks)
        found = replace(found, certificate=bound.bound)
    write_tasks(found.points, out, found.as_dict(), mission.origin)
    return found.summary()


def widened(scenario: Scenario, clearance: float) -> Scenario:
    """Return the scenario with no-fly zones and inlets widened by `clearance` [m], so that turns stay outside of them.

    Paths go round the inlets of a region as they go round zones: they touch them.
    """
    zones = [zone.buffer(clearance, quad_segs=4) for zone in (*zones_of(scenario), *inlets(scenario.region, clearance))]
    if not zones or clearance == 0:
        return scenario
    try:
        return replace(scenario, no_fly=zones)
    except InputError as error:
        raise InputError(
            f"{error} (no-fly zones and inlets of the region are widened by {clearance:g} m: costs.clearance)"
        ) from None


def inlets(region: Region, clearance: float) -> list[Polygon]:
    """Return the parts of a region's convex hull that lie outside of it, those deeper than INLET times `clearance`."""
    outline = Polygon(region.polygon.exterior)
    parts = shapely.get_parts(shapely.difference(outline.convex_hull, outline))
    edge = shapely.boundary(outline.convex_hull)
    deep = [shapely.distance(shapely.points(shapely.get_coordinates(part)), edge).max(initial=0.0) for part in parts]
    return [part for part, depth in zip(parts, deep, strict=True) if depth > INLET * clearance]


def kept_off(region: Region, whole: Region, distance: float) -> Region | None:
    """Return what of `region` lies at least `distance` [m] from the border of `whole`; None where not in one piece."""
    inner = region.polygon.intersection(Polygon(whole.polygon.exterior).buffer(-distance))
    return Region(inner) if isinstance(inner, Polygon) and inner.area > 0 else None


def zones_of(scenario: Scenario) -> list[Polygon]:
    """Return where must not be flown: the no-fly zones and the holes of the region."""
    return [*scenario.no_fly, *(Polygon(ring) for ring in scenario.region.polygon.interiors)]


def place_tasks(
    mission: Mission, region: Region, count: int, method: str, options: dict[str, Any], within: Region | None = None
) -> Placement:
    """Return `count` tasks in `within` placed by `method` to learn of `region` under the mission's planning kernel.

    `within` is all of `region` unless given.
    """
    problem = PlacementProblem(within or region, criterion_of(mission, region), count)
    if method not in METHODS.built_in:
        return placement_by(problem, mission.place, method, options)
    return place(problem, METHODS.make(method, options), method, seed=mission.place.seed)


def value_maps(mission: Mission) -> dict[str, ValueMap]:
    """Return the maps that [place] names, ``weights`` and ``prior_sd``; InputError names the key and the file."""
    elsewhere = {"weights": 1.0, "prior_sd": mission.place.signal_sd}
    files = {name: getattr(mission.place, name) for name in elsewhere}
    return {name: value_map(mission, f"place.{name}", file, elsewhere[name]) for name, file in files.items() if file}


def value_map(mission: Mission, key: str, file: str, elsewhere: float) -> ValueMap:
    """Return the map in a file of the mission, `elsewhere` where no polygon lies; InputError names key and file."""
    with naming(key):
        return read_value_map(mission.folder / file, mission.scenario.site, elsewhere)


def criterion_of(mission: Mission, region: Region) -> Goal:
    """Return what a mission's placing maximises."""
    wanted = mission.place
    columns, rows = wanted.tests
    tests = region.cell_centres(columns, rows)
    if not len(tests):
        raise InputError(f"place.tests: none of the {columns} × {rows} cell centres is in the region")
    maps = value_maps(mission)
    kernel = kernel_of(wanted.signal_sd, scales_of(wanted.length_scale), maps.get("prior_sd"))
    chosen = Convention.BOTH_NOISY if wanted.criterion == NAME else Convention(wanted.criterion)
    weights = weights_of(chosen, tests, None, maps.get("weights"))
    information = Criterion(kernel, tests, weights, wanted.noise_sd, None, chosen)
    return VarianceReduction(information) if wanted.criterion == NAME else information


def scales_of(value: float | list[float]) -> tuple[float, float]:
    """Return (l_x, l_y) [m] of one length or two."""
    return (value[0], value[1]) if isinstance(value, list) else (value, value)


def write_tasks(points: Floats, out: Path, said: dict[str, Any], plane: TangentPlane | None) -> None:
    """Write the products of this stage."""
    write_aside(out / "tasks.csv", "x,y\n" + "".join(f"{x!r},{y!r}\n" for x, y in points.tolist()))
    if plane is not None:
        features = ((Point(point), {"task": i}) for i, point in enumerate(points))
        write_features(features, plane, out / "tasks.geojson")
    write_aside(out / "placement.json", json.dumps(said))


def kept_tasks(folder: Path) -> Floats:
    """Read the tasks (n, 2) [m] this stage wrote."""
    return rows_of_tests(folder / "tasks.csv")[:, :2]
