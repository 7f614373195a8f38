"""Mission file: a scenario, what is measured, and the settings of each stage. TOML, SI units, every key checked.

    scenario = "file.toml"       # or the scenario's own keys here: airspeed, size, depots, tasks, [wind], [radio] …
    origin = [lat, lon]          # of the point (0, 0) [degrees], for ground-control files
    [field] [place] [costs] [routes] [flight] [sensing] [map] [compare]    # the classes below

Files are relative to the mission file.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from instances.disk import read_text
from instances.errors import InputError, naming, suggestion
from instances.geodesy import TangentPlane
from instances.scenario import KEYS as SCENARIO_KEYS
from instances.scenario import Scenario, read_scenario, scenario_of

T = TypeVar("T")


def _positive(default: float | None, unit: str = "") -> Any:
    return field(default=default, metadata={"least": 0.0, "strict": True, "unit": unit})


def _least(default: float, least: float, unit: str = "") -> Any:
    return field(default=default, metadata={"least": least, "strict": False, "unit": unit})


@dataclass(frozen=True)
class FieldSettings:
    """[field]: what is measured. `file` (CSV, NetCDF or GeoTIFF), or the signal of [radio] under `model`.

    shadowing_sd [dB]; decorrelation [m] of the shadowing; cells along the longer side; altitude is [flight]'s.
    """

    file: str | None = None
    model: str = "diffraction"
    shadowing_sd: float = _least(4.0, 0.0, "dB")
    decorrelation: float = _positive(2000.0, "m")
    cells: int = _least(200, 2)
    seed: int = _least(0, 0)


@dataclass(frozen=True)
class PlaceSettings:
    """[place]: sub-problem 1. tests = [columns, rows] of test points; kernel and noise of the planning."""

    method: str = "nlp"
    options: dict[str, Any] = field(default_factory=dict)
    criterion: str = "b"
    tests: list[int] = field(default_factory=lambda: [10, 10])
    signal_sd: float = _positive(30.0)
    length_scale: float | list[float] = _positive(4000.0, "m")  # noqa: RUF009 - a field
    noise_sd: float = _positive(1.0)
    seed: int = _least(0, 0)
    certificate: bool = True


@dataclass(frozen=True)
class CostSettings:
    """[costs]: sub-problem 2. clearance [m]: no-fly zones are widened by it; twice the turning radius unless given."""

    method: str = "refined"
    options: dict[str, Any] = field(default_factory=dict)
    clearance: float | None = field(default=None, metadata={"least": 0.0, "strict": False, "unit": "m"})


@dataclass(frozen=True)
class RouteSettings:
    """[routes]: sub-problem 3, by any registered solver. time_limit [s]."""

    solver: str = "ruin-recreate"
    options: dict[str, Any] = field(default_factory=dict)
    time_limit: float = _positive(10.0, "s")
    threads: int = _least(1, 1)
    seed: int = _least(0, 0)


@dataclass(frozen=True)
class FlightSettings:
    """[flight]: Dubins at speed v [m/s] (the airspeed unless given), turning_radius r_min [m], altitude [m]."""

    speed: float | None = _positive(None, "m/s")
    turning_radius: float = _positive(50.0, "m")
    altitude: float = _least(3000.0, 0.0, "m")


@dataclass(frozen=True)
class SensingSettings:
    """[sensing]: a measurement every `period` seconds, with noise σ_n = noise_sd in the field's unit."""

    period: float = _positive(10.0, "s")
    noise_sd: float = _positive(1.0)
    seed: int = _least(0, 0)


@dataclass(frozen=True)
class MapSettings:
    """[map]: sub-problem 4. Kernel at the start, ticks between maximum-likelihood fits (0 for none), map cells a side.

    frames : maps that are kept for the report.
    """

    signal_sd: float = _positive(30.0)
    length_scale: float | list[float] = _positive(4000.0, "m")  # noqa: RUF009 - a field
    refit_every: int = _least(10, 0)
    cells: int = _least(100, 4)
    frames: int = _least(30, 2)


@dataclass(frozen=True)
class CompareSettings:
    """[compare]: what else is flown over the same field: lawnmower, random and greedy; draws of the random tours."""

    baselines: list[str] = field(default_factory=lambda: ["lawnmower", "random", "greedy"])
    draws: int = _least(1, 1)
    time_limit: float = _positive(3.0, "s")
    seed: int = _least(0, 0)


BASELINES = ("lawnmower", "random", "greedy")


@dataclass(frozen=True, eq=False)
class Mission:
    """What a mission file says. `folder` is where its files are; `table` is the file as read."""

    scenario: Scenario
    origin: TangentPlane | None
    folder: Path
    table: Mapping[str, Any]
    field: FieldSettings
    place: PlaceSettings
    costs: CostSettings
    routes: RouteSettings
    flight: FlightSettings
    sensing: SensingSettings
    map: MapSettings
    compare: CompareSettings

    @property
    def speed(self) -> float:
        """Flying speed v [m/s]."""
        return self.scenario.airspeed if self.flight.speed is None else self.flight.speed

    @property
    def clearance(self) -> float:
        """How far no-fly zones are widened for planning [m]."""
        return 2 * self.flight.turning_radius if self.costs.clearance is None else self.costs.clearance


TABLES: dict[str, type[Any]] = {
    "field": FieldSettings,
    "place": PlaceSettings,
    "costs": CostSettings,
    "routes": RouteSettings,
    "flight": FlightSettings,
    "sensing": SensingSettings,
    "map": MapSettings,
    "compare": CompareSettings,
}
KEYS = ("scenario", "origin", *SCENARIO_KEYS, *TABLES)
"""Every key of a mission file."""


def shipped_mission() -> Path:
    """Return the mission file that comes with the workbench: the paper's numerical example."""
    return Path(str(files("workbench") / "missions" / "paper.toml"))


def read_mission(path: Path | str) -> Mission:
    """Read a mission file; InputError names the file, the key and the value that cannot be used."""
    path = Path(path)
    text = read_text(path)
    try:
        table = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise InputError(f"{path}: is not valid TOML ({error})") from None
    with naming(path):
        return mission_of(table, path.parent, path.stem)


def mission_of(table: Mapping[str, Any], folder: Path, name: str) -> Mission:
    """Return the mission a parsed TOML table describes, its files relative to `folder`; InputError names the key."""
    for key in table:
        if key not in KEYS:
            raise InputError(f"unknown key '{key[:40]}'{suggestion(key, KEYS)}")
    settings = {key: settings_of(cls, table.get(key, {}), key) for key, cls in TABLES.items()}
    mission = Mission(_scenario(table, folder, name), _origin(table), folder, table, **settings)
    check_mission(mission)
    return mission


def _scenario(table: Mapping[str, Any], folder: Path, name: str) -> Scenario:
    own = {key: value for key, value in table.items() if key in SCENARIO_KEYS}
    if "scenario" not in table:
        return scenario_of(own, folder, name)
    if own:
        raise InputError(
            f"'{next(iter(own))}' belongs into the scenario file, which 'scenario' names; give one of them"
        )
    if not isinstance(table["scenario"], str):
        raise InputError(f"scenario must be the name of a file, got {table['scenario']!r}")
    return read_scenario(folder / table["scenario"])


def _origin(table: Mapping[str, Any]) -> TangentPlane | None:
    if "origin" not in table:
        return None
    origin = table["origin"]
    if not (isinstance(origin, list) and len(origin) == 2 and all(_is_number(c) for c in origin)):
        raise InputError(f"origin must be [latitude, longitude] in degrees, got {origin!r}")
    return TangentPlane(float(origin[0]), float(origin[1]))


def settings_of(cls: type[T], table: Any, name: str) -> T:
    """Return the settings a table of a mission file holds; InputError names key, value and unit."""
    if not isinstance(table, Mapping):
        raise InputError(f"[{name}] must be a table, got {table!r}")
    known = {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
    values = {}
    for key, value in table.items():
        if key not in known:
            raise InputError(f"[{name}]: unknown key '{key[:40]}'{suggestion(key, known)} (known: {', '.join(known)})")
        values[key] = _checked(value, str(known[key].type), known[key].metadata, f"{name}.{key}")
    return cls(**values)


def _checked(value: Any, kind: str, meta: Mapping[str, Any], where: str) -> Any:
    unit = f" [{meta['unit']}]" if meta.get("unit") else ""
    if kind.startswith("bool"):
        wanted, fits = "true or false", isinstance(value, bool)
    elif kind.startswith("str"):
        wanted, fits = "a text", isinstance(value, str) and value != ""
    elif kind.startswith("dict"):
        wanted, fits = "a table", isinstance(value, dict)
    elif kind.startswith("list[str]"):
        wanted, fits = "a list of texts", isinstance(value, list) and all(isinstance(v, str) for v in value)
    elif kind.startswith("list[int]"):
        wanted = "two whole numbers of at least 1"
        fits = isinstance(value, list) and len(value) == 2 and all(type(v) is int and v >= 1 for v in value)
    elif kind.startswith("int"):
        wanted, fits = f"a whole number of at least {meta['least']}", type(value) is int and value >= meta["least"]
    else:
        pair = "list" in kind and isinstance(value, list) and len(value) == 2
        wanted = ("a positive number" if meta["strict"] else f"a number of at least {meta['least']:g}") + unit
        wanted += " or two of them" if "list" in kind else ""
        fits = all(_is_number(v) and (v > meta["least"] or (v == meta["least"] and not meta["strict"]))
                   for v in (value if pair else [value]))  # fmt: skip
    if not fits:
        raise InputError(f"{where} must be {wanted}, got {value!r}")
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300


def check_mission(mission: Mission) -> None:
    """Raise InputError where settings do not fit together: names, counts, and lengths in the wrong unit."""
    from formulations.moving_cost.registry import make_method as make_cost_method
    from formulations.registry import make_solver
    from formulations.task_location.registry import make_method as make_placement_method

    scenario = mission.scenario
    if scenario.n_tasks < scenario.n_depots:
        raise InputError(f"there are more UAVs ({scenario.n_depots} depots) than tasks ({scenario.n_tasks})")
    make_placement_method(mission.place.method, mission.place.options)
    make_cost_method(mission.costs.method, mission.costs.options)
    try:
        make_solver(mission.routes.solver, mission.routes.options)
    except ImportError as error:
        raise InputError(f"routes.solver: {mission.routes.solver} is not available here: {error}") from None
    for name in mission.compare.baselines:
        if name not in BASELINES:
            raise InputError(f"compare.baselines: unknown '{name}'{suggestion(name, BASELINES)} (known: "
                             f"{', '.join(BASELINES)})")  # fmt: skip
    if mission.field.file is None and scenario.radio is None:
        raise InputError('there is nothing to measure: give a table [radio], or [field] with file = "…"')
    _check_units(mission)


MOST_G = 200.0
"""Load factors beyond this are no flight but a length in the wrong unit (the paper's own example flies 20 g)."""


def _check_units(mission: Mission) -> None:
    x0, y0, x1, y1 = mission.scenario.region.bounds
    size = max(x1 - x0, y1 - y0)
    for name, given in (("place", mission.place.length_scale), ("map", mission.map.length_scale)):
        for scale in given if isinstance(given, list) else [given]:
            if scale < size / 1000:
                raise InputError(
                    f"{name}.length_scale = {scale:g} m is less than a thousandth of the region ({size:g} m): "
                    "lengths are in metres"
                )
    radius, speed = mission.flight.turning_radius, mission.speed
    if speed**2 / radius > MOST_G * 9.81:
        raise InputError(
            f"flight.turning_radius = {radius:g} m at {speed:g} m/s would need {speed**2 / radius / 9.81:.0f} g: "
            "lengths are in metres"
        )
    if radius > size / 4:
        raise InputError(f"flight.turning_radius = {radius:g} m is more than a quarter of the region ({size:g} m)")
    # No tour is longer than flying across the region for every task.
    tasks = mission.scenario.n_tasks
    longest = (tasks + 1) * 2 * ((x1 - x0) + (y1 - y0)) / speed
    if mission.sensing.period > longest:
        raise InputError(
            f"sensing.period = {mission.sensing.period:g} s is longer than any tour of {tasks} tasks could "
            f"last ({longest:.0f} s)"
        )
