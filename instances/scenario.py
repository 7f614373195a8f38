"""Scenario: a mission before its moving costs are known. It is read from and written to TOML; SI units.

    name = "survey"                       # optional: the file's name if left out
    ground_speed = 100.0                  # v0 [m/s], held constant: legs cost energy, in seconds of calm flight
    # cost = "time"                       # or this with airspeed = 100.0, held constant: legs cost flight time
    size = [20000, 20000]                 # [m], or region = "area.kml": see instances.places
    no_fly = "zones.geojson"              # optional, any number of polygons
    depots = [[x, y], ...]                # [m], one UAV at each; or degrees, or a file of points
    tasks = [[x, y], ...]                 # likewise, or tasks = 40: that many are still to be placed
    crs = "EPSG:4326"                     # optional: what lists, and files that state nothing, are in
    origin = [lat, lon]                   # optional: of the point (0, 0)
    terrain = "dem.tif"                   # optional
    service, return, window, [[uav]]      # optional; see instances.fleet
    [wind]                                # optional; see instances.environment.wind
    kind = "uniform"
    velocity = [u, v]                     # [m/s]
    [radio]                               # optional; read by whoever makes the radio map

Files are relative to the TOML file.
"""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from shapely.geometry import MultiPolygon, Polygon, mapping

from instances.arrays import Floats
from instances.declared.reading import read_declared
from instances.declared.scenario import ScenarioKeys, ScenarioTable, UavTable
from instances.disk import read_toml, write_aside
from instances.environment.region import Region
from instances.environment.site import Site
from instances.environment.wind import WindField
from instances.environment.wind_changing import ChangingWind
from instances.environment.wind_table import wind_of
from instances.errors import LONGEST_SENTENCE, InputError, naming, one_line, shown
from instances.extent import positive
from instances.fleet import Fleet
from instances.geodesy import TangentPlane, on_earth
from instances.georeference import LOCAL, could_be_degrees
from instances.instance import check_name
from instances.moving_cost import CostKind
from instances.places import Places, local_pair, read_places
from instances.toml_text import toml_text


@dataclass(frozen=True, eq=False)
class Scenario:
    """A mission: where it is flown, from where, how fast, and to which tasks.

    Parameters
    ----------
    name
        Short name.
    region
        The area A.
    depots
        Shape (m, 2) [m], m ≥ 1, each in the region and outside the no-fly zones.
    speed
        v0 [m/s], positive: the ground speed where the cost is energy, the airspeed where it is time.
    wind
        None where calm.
    tasks
        Shape (n, 2) [m], or None where `n_tasks` of them are still to be placed.
    n_tasks
        n ≥ 1; may be left at 0 where `tasks` is given.
    no_fly
        Polygons no leg may enter.
    terrain
        File of the elevation model, or None.
    radio
        The table that describes the radio source, or None.
    provenance
        Where it comes from.
    plane
        Where on Earth the local plane is, or None.
    cost
        What a leg costs: energy or time.
    fleet
        How UAVs differ, how long tasks take, where tours end.

    Raises
    ------
    InputError
        With one sentence that names the field and the value.
    """

    name: str
    region: Region
    depots: Floats
    speed: float
    wind: WindField | None = None
    tasks: Floats | None = None
    n_tasks: int = 0
    no_fly: Sequence[Polygon] = ()
    terrain: Path | None = None
    radio: Mapping[str, Any] | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    plane: TangentPlane | None = None
    cost: CostKind = CostKind.ENERGY
    fleet: Fleet = field(default_factory=Fleet)

    def __post_init__(self) -> None:
        check_name(self.name)
        object.__setattr__(self, "cost", CostKind(self.cost))
        object.__setattr__(self, "speed", positive(self.speed, f"{self.cost.speed_key} [m/s]"))
        if isinstance(self.wind, ChangingWind) and self.cost is not CostKind.TIME:
            raise InputError(
                "the wind changes with time, and the paper's energy is no clock (it says nothing of when the UAV "
                "arrives): give cost = 'time' and an airspeed"
            )
        object.__setattr__(self, "no_fly", tuple(self.no_fly))
        object.__setattr__(self, "depots", _points(self.depots, "depots", self.region, self.plane))
        free = self.free
        self._check_reached("depots", self.depots, free)
        object.__setattr__(self, "depots", _points(self.depots, "depots", free, self.plane))
        if self.tasks is not None:
            object.__setattr__(self, "tasks", _points(self.tasks, "tasks", self.region, self.plane))
            self._check_reached("tasks", self.tasks, free)
            object.__setattr__(self, "tasks", _points(self.tasks, "tasks", free, self.plane))
            if self.n_tasks not in (0, len(self.tasks)):
                raise InputError(f"n_tasks is {self.n_tasks} but there are {len(self.tasks)} tasks")
            object.__setattr__(self, "n_tasks", len(self.tasks))
        elif isinstance(self.n_tasks, bool) or not isinstance(self.n_tasks, int) or self.n_tasks < 1:
            raise InputError(f"tasks must be points or a whole number of at least 1, got {shown(self.n_tasks)}")
        object.__setattr__(self, "fleet", self.fleet.checked(self.n_tasks, self.n_depots))
        if self.fleet.window and not isinstance(self.wind, ChangingWind):
            raise InputError(
                f"window is {shown(self.fleet.window)} s, and to wait before take-off helps only in a wind that changes"
            )

    @property
    def n_depots(self) -> int:
        """Number of depots m, one UAV at each."""
        return len(self.depots)

    @property
    def free(self) -> Region:
        """The region without its no-fly zones; where these cut it into parts, the part of the first depot."""
        parts = self.region.parts_without(list(self.no_fly)) if self.no_fly else [self.region]
        home = [part for part in parts if part.contains(self.depots[:1])[0]]
        if not parts:
            raise InputError("region: the no-fly zones leave nothing of it")
        return home[0] if home else parts[0]

    def _check_reached(self, label: str, points: Floats, free: Region) -> None:
        """Raise InputError where a point lies in a part of the region that no path leads to."""
        away = np.flatnonzero(~free.contains(points))
        parts = self.region.parts_without(list(self.no_fly)) if len(away) else []
        for i in away:
            if len(parts) > 1 and any(part.contains(points[i : i + 1])[0] for part in parts):
                raise InputError(
                    f"{label}[{i}] = {points[i].tolist()} cannot be reached from depots[0] = "
                    f"{self.depots[0].tolist()}: the no-fly zones cut the region into parts"
                )

    @property
    def site(self) -> Site:
        """Where files of terrain, wind and fields are read for."""
        return Site(self.region, self.plane)

    @property
    def points(self) -> Floats:
        """Tasks, then depots, (n+m, 2) [m]: the instance's coordinates; InputError where tasks are not placed."""
        if self.tasks is None:
            raise InputError(f"scenario {self.name}: its {self.n_tasks} tasks are not placed yet")
        return np.concatenate([self.tasks, self.depots])


def read_scenario(path: Path | str, more: Mapping[str, Any] | None = None) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path
        TOML; files it names are relative to it.
    more
        Further keys, as if they stood in the file.

    Raises
    ------
    InputError
        Names the file, the key and what cannot be used.
    """
    path = Path(path)
    table = read_toml(path)
    with naming(path):
        for key, value in (more or {}).items():
            if table.setdefault(key, value) != value:
                raise InputError(f"{key} is {shown(table[key])} here and {shown(value)} in the mission")
        scenario = scenario_of(table, path.parent, path.stem)
    tell_old_speed(table, path)
    return scenario


def tell_old_speed(table: Mapping[str, Any], path: Path) -> None:
    """Log a notice where a file says 'airspeed' for the constant ground speed of energies, as all once did."""
    if table.get("cost", CostKind.ENERGY) == CostKind.ENERGY and "airspeed" in table:
        words = f"{path}: airspeed is read as ground_speed, which energies need; write that, or add cost = 'time'"
        logging.getLogger(__name__).warning(one_line(words, LONGEST_SENTENCE))


def scenario_of(table: Mapping[str, Any], folder: Path, name: str) -> Scenario:
    """Return the scenario a parsed TOML table describes, its files relative to `folder`; InputError names the key."""
    return scenario_from(read_declared(ScenarioTable, table), table, folder, name)


def scenario_from(said: ScenarioKeys, table: Mapping[str, Any], folder: Path, name: str) -> Scenario:
    """Return the scenario that the keys of a file describe, its files relative to `folder`; `table` is the file."""
    places = read_places(said, folder)
    site = Site(places.region, places.reference.plane)
    fleet, at = _fleet_of(said, len(places.depots))
    return Scenario(
        name=name if said.name is None else said.name,
        region=places.region,
        depots=np.array([places.depots[k] for k in at]),
        speed=said.speed,
        wind=None if said.wind is None else wind_of(said.wind, folder, site),
        tasks=None if isinstance(places.tasks, int) else places.tasks,
        n_tasks=places.tasks if isinstance(places.tasks, int) else 0,
        no_fly=places.no_fly,
        terrain=None if said.terrain is None else folder / said.terrain,
        radio=_radio(said, table, places),
        provenance=said.provenance,
        plane=site.plane,
        cost=said.cost,
        fleet=fleet,
    )


def _fleet_of(said: ScenarioKeys, n_depots: int) -> tuple[Fleet, list[int]]:
    """Return the fleet a scenario describes, and of each UAV the number of its depot among `n_depots` listed.

    Raises InputError that names table, key and value.
    """
    uavs = [UavTable(depot=k) for k in range(n_depots)] if said.uav is None else said.uav
    at: list[int] = []
    for number, uav in enumerate(uavs, 1):
        depot = 0 if uav.depot is None and n_depots == 1 else uav.depot
        if depot is None or depot >= n_depots:
            raise InputError(
                f"[[uav]] {number} depot must be the number of a depot, 0 to {n_depots - 1}, got {shown(depot)}"
            )
        at += [depot] * uav.count
    for k in range(n_depots):
        if k not in at:
            raise InputError(f"depots[{k}] has no [[uav]]")
    each = [uav for uav in uavs for _ in range(uav.count)]
    speeds = np.array([said.speed if uav.speed is None else uav.speed for uav in each])
    endurance = np.array([math.inf if uav.endurance is None else uav.endurance for uav in each])
    radii = [uav.turning_radius for uav in each if uav.turning_radius is not None]
    if radii and len(radii) < len(each):
        raise InputError("[[uav]] turning_radius: give it for all UAVs or for none")
    return Fleet(
        None if (speeds == said.speed).all() else speeds,
        None if np.isinf(endurance).all() else endurance,
        np.array(said.service) if isinstance(said.service, list) else said.service,
        said.returns,
        np.array(radii) if radii else None,
        said.window,
    ), at


def _radio(said: ScenarioKeys, table: Mapping[str, Any], places: Places) -> Mapping[str, Any] | None:
    """Return the table [radio] as it is given, its position in the plane."""
    if said.radio is None or said.radio.position is None:
        return table.get("radio")
    return {**table["radio"], "position": list(local_pair(said.radio.position, "radio.position", places))}


def write_scenario(scenario: Scenario, path: Path | str) -> None:
    """Write a scenario file, and beside it ``<stem>-region.geojson`` and ``<stem>-no-fly.geojson`` where needed.

    They are in local metres, and end in ``.json`` where that is no GeoJSON because the plane's place is known.
    """
    path = Path(path)
    ending = "geojson" if scenario.plane is None else "json"
    table: dict[str, Any] = {"name": scenario.name}
    if scenario.cost is not CostKind.ENERGY:
        table["cost"] = str(scenario.cost)
    table[scenario.cost.speed_key] = scenario.speed
    x0, y0, x1, y1 = scenario.region.bounds
    if x0 == y0 == 0.0 and scenario.region.polygon.equals(Region.rectangle(x1, y1).polygon):
        table["size"] = [x1, y1]
    else:
        table["region"] = f"{path.stem}-region.{ending}"
        scenario.region.write(path.with_name(table["region"]))
    if scenario.no_fly:
        table["no_fly"] = f"{path.stem}-no-fly.{ending}"
        zones = {"type": "Feature", "properties": {}, "geometry": mapping(MultiPolygon(list(scenario.no_fly)))}
        write_aside(path.with_name(table["no_fly"]), json.dumps(zones))
    if scenario.plane is not None:
        table |= {"origin": [scenario.plane.latitude, scenario.plane.longitude], "crs": LOCAL}
    elif could_be_degrees(scenario.region.polygon):
        table["crs"] = LOCAL
    table["depots"] = scenario.depots.tolist()
    table["tasks"] = scenario.n_tasks if scenario.tasks is None else scenario.tasks.tolist()
    table |= scenario.fleet.to_toml(scenario.n_depots)
    if scenario.terrain is not None:
        table["terrain"] = str(scenario.terrain)
    if scenario.wind is not None:
        table["wind"] = scenario.wind.to_toml(path.parent)
    for key, value in (("radio", scenario.radio), ("provenance", scenario.provenance)):
        if value:
            table[key] = dict(value)
    write_aside(path, toml_text(table))


def _points(value: ArrayLike, label: str, region: Region, plane: TangentPlane | None) -> Floats:
    """Return points (k, 2) [m] in `region`, k ≥ 1."""
    try:
        p = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{label} must be a list of points [x, y] [m]") from None
    if p.ndim != 2 or p.shape[1] != 2 or len(p) < 1:
        raise InputError(f"{label} must be a list of at least one point [x, y] [m], got shape {p.shape}")
    for i in np.flatnonzero(~np.isfinite(p).all(axis=1)).tolist():
        raise InputError(f"{label}[{i}] = {p[i].tolist()} is not finite")
    for i in np.flatnonzero(~region.contains(p)).tolist():
        where = f"{p[i].tolist()}{on_earth(plane, p[i])}"
        raise InputError(f"{label}[{i}] = {where} lies outside the region or in a no-fly zone")
    p.setflags(write=False)
    return p
