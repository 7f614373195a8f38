"""Settings of a mission: the scenario, what is measured, and the tables of each stage, every key checked."""

# ruff: noqa: RUF009 - keys.* make dataclass fields

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from formulations.kernel import KERNELS
from formulations.limits import LONGEST, MOST_THREADS
from formulations.mapping.heights import Altitude, Frame
from instances.errors import InputError, shown, suggestion
from instances.formats.mavlink_items import FIRMWARE, KINDS, Vehicle
from instances.geodesy import TangentPlane
from instances.scenario import Scenario
from workbench.mission import keys

MEANS = ("constant", "path-loss", "propagation")
"""What [map] mean may name beside auto, which offers all of them."""


@dataclass(frozen=True)
class FieldSettings:
    """[field]: what is measured; the altitude is [flight]'s."""

    file: str | None = keys.text(
        None,
        meaning="what is measured, from a file: CSV, NetCDF or GeoTIFF; made from [radio] where none is given",
        example="field.nc",
    )
    unit: str | None = keys.text(None, meaning="unit of a file's values, what the file says unless given", example="K")
    model: str = keys.text("diffraction", meaning="propagation of [radio]: diffraction, free-space or itm")
    shadowing_sd: float = keys.not_negative(4.0, "dB", meaning="standard deviation of the shadowing, drawn at random")
    decorrelation: float = keys.positive(
        2000.0, "m", meaning="distance at which the shadowing's correlation falls to 1/e"
    )
    cells: int = keys.count(200, 2, 2000, meaning="nodes of the field along the longer side")
    seed: int = keys.seed(meaning="seed of the shadowing")


@dataclass(frozen=True)
class PlaceSettings:
    """[place]: sub-problem 1, task locations."""

    method: str = keys.text(
        "nlp",
        meaning="how tasks are placed: nlp, l-bfgs-b, greedy-swap, greedy … (workbench place --help), or module:Class",
    )
    options: dict[str, Any] = keys.options(meaning="options of the method", example={"starts": 8})
    criterion: str = keys.text(
        "b", meaning="information that is maximised: b both noisy, a latent tests, ig information gain"
    )
    tests: list[int] = keys.counts(
        [20, 20], meaning="columns and rows of the test points, at which the field is to be known"
    )
    signal_sd: float = keys.positive(
        30.0, meaning="σ_f of the planning kernel, in the field's unit; information is stated under this kernel"
    )
    length_scale: float | list[float] = keys.one_or_two(
        4000.0, "m", meaning="length scale of the planning kernel, or two along x and y"
    )
    noise_sd: float = keys.positive(1.0, meaning="σ_n of a reading at a task, for planning, in the field's unit")
    seed: int = keys.seed(meaning="seed of the method")
    certificate: bool = keys.switch(True, meaning="whether an upper bound on the information is computed, too")


@dataclass(frozen=True)
class CostSettings:
    """[costs]: sub-problem 2, moving costs. Zones are widened by the clearance, tasks placed as far from the border."""

    method: str = keys.text(
        "refined", meaning="how paths are planned: refined, fmt-star, dijkstra, closed-form, or module:Class"
    )
    options: dict[str, Any] = keys.options(meaning="options of the method", example={"samples": 2000})
    clearance: float | None = keys.not_negative(
        None,
        "m",
        meaning="room for turns at zones, inlets and border; twice the turning radius unless given",
        example=100.0,
    )


@dataclass(frozen=True)
class RouteSettings:
    """[routes]: sub-problem 3, routes."""

    solver: str = keys.text("memetic", meaning="who routes: any of workbench solvers, or module:Class")
    options: dict[str, Any] = keys.options(meaning="options of the solver", example={"removals": 10})
    time_limit: float = keys.positive(10.0, "s", LONGEST, meaning="wall clock of the solver")
    bound_time_limit: float = keys.not_negative(
        5.0, "s", meaning="wall clock for a bound beside the routes; 0 for the quick bounds alone"
    )
    threads: int = keys.count(1, 1, MOST_THREADS, meaning="threads of the solver")
    seed: int = keys.seed(meaning="seed of the solver")


@dataclass(frozen=True)
class FlightSettings:
    """[flight]: Dubins tours of turning radius r_min at speed v, and how high."""

    speed: float | None = keys.positive(None, "m/s", meaning="flying speed; the scenario's unless given", example=100.0)
    turning_radius: float = keys.positive(50.0, "m", meaning="least radius of any turn")
    altitude: float = keys.not_negative(3000.0, "m", meaning="flying altitude, in the frame")
    frame: str = keys.text(
        "amsl", meaning="what the altitude is above: amsl, above-ground (the track follows the ground) or above-home"
    )
    clearance: float = keys.not_negative(
        50.0, "m", meaning="least height of a track above the ground; lower ones are refused"
    )
    climb: float = keys.positive(5.0, "m/s", meaning="greatest rate of climb, where a track follows the ground")
    descent: float = keys.positive(3.0, "m/s", meaning="greatest rate of descent, where a track follows the ground")
    border_clearance: float = keys.not_negative(
        0.0, "m", meaning="what flown tracks keep from the region's border and from no-fly zones"
    )
    endurance: float | None = keys.positive(
        None,
        "s",
        meaning="most that the costs of a UAV's tour may add up to; where that is too little for all tasks, those that "
        "fit and tell most are flown",
        example=3600.0,
    )


@dataclass(frozen=True)
class SensingSettings:
    """[sensing]: what the UAVs measure on their way."""

    period: float = keys.positive(10.0, "s", meaning="time between two measurements of a UAV")
    noise_sd: float = keys.positive(1.0, meaning="σ_n of a measurement, in the field's unit")
    seed: int = keys.seed(meaning="seed of the noise")


@dataclass(frozen=True)
class MapSettings:
    """[map]: sub-problem 4, the Gaussian process."""

    signal_sd: float = keys.positive(30.0, meaning="σ_f believed at take-off, in the field's unit")
    length_scale: float | list[float] = keys.one_or_two(
        4000.0, "m", meaning="length scale believed at take-off, or two along x and y"
    )
    kernel: str = keys.one_of(
        "auto",
        ("auto", *KERNELS),
        meaning="covariance of the map: auto (chosen by likelihood), se, matern52, matern32 or matern12; planning is "
        "always under se",
    )
    mean: str = keys.one_of(
        "constant",
        ("auto", *MEANS),
        meaning="mean of the map: constant, path-loss (distance from the transmitter), propagation (diffraction over "
        "the terrain) or auto; beside constant, physics is taken only where the likelihood says so",
    )
    refit_every: int = keys.count(10, 0, meaning="measuring rounds between fits of the map's model; 0 for none")
    cells: int = keys.count(100, 4, 1000, meaning="cells of the map along the longer side")
    frames: int = keys.count(30, 2, meaning="maps that are kept for the report")


@dataclass(frozen=True)
class CompareSettings:
    """[compare]: what else is flown over the same fields."""

    baselines: list[str] = keys.texts(
        ["lawnmower", "random", "greedy"], meaning="what else is flown: lawnmower, random, greedy"
    )
    seeds: int = keys.count(
        8, 1, 1000, meaning="noise seeds, each with shadowing of its own, over which verdicts are formed"
    )
    draws: int = keys.count(8, 1, 1000, meaning="different random tours, taken in turn over the seeds")
    time_limit: float = keys.positive(1.0, "s", LONGEST, meaning="wall clock of the solver for each baseline")
    seed: int = keys.seed(meaning="seed of what is drawn for the comparison")


@dataclass(frozen=True)
class ExportSettings:
    """[export]: who flies the plans."""

    firmware: str = keys.one_of("px4", FIRMWARE, meaning="autopilot of the .plan and .waypoints files")
    vehicle: str = keys.one_of("fixed-wing", KINDS, meaning="vehicle of the .plan and .waypoints files")


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
    export: ExportSettings

    @property
    def speed(self) -> float:
        """Flying speed v [m/s]."""
        return self.scenario.speed if self.flight.speed is None else self.flight.speed

    @property
    def vehicle(self) -> Vehicle:
        """What the plans are written for."""
        return Vehicle(self.export.firmware, self.export.vehicle)

    @property
    def altitude(self) -> Altitude:
        """How high is flown; InputError for a frame that is not known."""
        wanted = self.flight
        if wanted.frame not in list(Frame):
            raise InputError(
                f"flight.frame: unknown {shown(wanted.frame)}{suggestion(wanted.frame, list(Frame))} "
                f"(known: {', '.join(Frame)})"
            )
        return Altitude(wanted.altitude, Frame(wanted.frame), wanted.climb / self.speed, wanted.descent / self.speed)

    def altitude_at(self, ground_speed: float) -> Altitude:
        """Return how high is flown where the UAV is never faster over ground than `ground_speed` [m/s]."""
        slower = self.speed / ground_speed
        flown = self.altitude
        return replace(flown, climb=flown.climb * slower, descent=flown.descent * slower)

    @property
    def clearance(self) -> float:
        """How far planning keeps off borders [m]: room for turns beside the clearance that flown tracks keep."""
        turns = 2 * self.flight.turning_radius if self.costs.clearance is None else self.costs.clearance
        return turns + self.flight.border_clearance


TABLES: dict[str, type[Any]] = {
    "field": FieldSettings,
    "place": PlaceSettings,
    "costs": CostSettings,
    "routes": RouteSettings,
    "flight": FlightSettings,
    "sensing": SensingSettings,
    "map": MapSettings,
    "compare": CompareSettings,
    "export": ExportSettings,
}
"""Table of a mission file → what it may hold."""
