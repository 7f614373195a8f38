"""Settings of a mission: the scenario, what is measured, and the tables of each stage, every key checked."""

# ruff: noqa: RUF009 - keys.* make dataclass fields

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from formulations.limits import LONGEST, MOST_THREADS
from formulations.mapping.heights import Altitude, Frame
from instances.errors import InputError, shown, suggestion
from instances.formats.mavlink_items import FIRMWARE, KINDS, Vehicle
from instances.geodesy import TangentPlane
from instances.scenario import Scenario
from workbench.mission import keys


@dataclass(frozen=True)
class FieldSettings:
    """[field]: what is measured: a `file` (CSV, NetCDF or GeoTIFF), or the signal of [radio] under `model`.

    unit of a file's values, what the file says unless given. shadowing_sd [dB]; decorrelation [m] of the shadowing;
    cells along the longer side; the altitude is [flight]'s.
    """

    file: str | None = keys.text(None)
    unit: str | None = keys.text(None)
    model: str = keys.text("diffraction")
    shadowing_sd: float = keys.not_negative(4.0, "dB")
    decorrelation: float = keys.positive(2000.0, "m")
    cells: int = keys.count(200, 2, 2000)
    seed: int = keys.seed()


@dataclass(frozen=True)
class PlaceSettings:
    """[place]: sub-problem 1. tests = [columns, rows] of test points; kernel and noise of the planning."""

    method: str = keys.text("nlp")
    options: dict[str, Any] = keys.options()
    criterion: str = keys.text("b")
    tests: list[int] = keys.counts([20, 20])
    signal_sd: float = keys.positive(30.0)
    length_scale: float | list[float] = keys.one_or_two(4000.0, "m")
    noise_sd: float = keys.positive(1.0)
    seed: int = keys.seed()
    certificate: bool = keys.switch(True)


@dataclass(frozen=True)
class CostSettings:
    """[costs]: sub-problem 2. clearance [m]: room for turns, twice the turning radius unless given.

    No-fly zones are widened by it for planning, and tasks placed as far from the region's border.
    """

    method: str = keys.text("refined")
    options: dict[str, Any] = keys.options()
    clearance: float | None = keys.not_negative(None, "m")


@dataclass(frozen=True)
class RouteSettings:
    """[routes]: sub-problem 3, by any registered solver. time_limit [s]; bound_time_limit [s] of its bound."""

    solver: str = keys.text("memetic")
    options: dict[str, Any] = keys.options()
    time_limit: float = keys.positive(10.0, "s", LONGEST)
    bound_time_limit: float = keys.not_negative(5.0, "s")
    threads: int = keys.count(1, 1, MOST_THREADS)
    seed: int = keys.seed()


@dataclass(frozen=True)
class FlightSettings:
    """[flight]: Dubins at speed v [m/s] (the scenario's unless given), turning_radius r_min [m].

    altitude [m] in a frame: "amsl" (above mean sea level), "above-ground" (the track follows the ground within climb
    and descent [m/s]) or "above-home" (each UAV above its depot). clearance [m]: least height above the ground.
    border_clearance [m]: flown tracks keep at least so far from the region's border and from no-fly zones.
    """

    speed: float | None = keys.positive(None, "m/s")
    turning_radius: float = keys.positive(50.0, "m")
    altitude: float = keys.not_negative(3000.0, "m")
    frame: str = keys.text("amsl")
    clearance: float = keys.not_negative(50.0, "m")
    climb: float = keys.positive(5.0, "m/s")
    descent: float = keys.positive(3.0, "m/s")
    border_clearance: float = keys.not_negative(0.0, "m")


@dataclass(frozen=True)
class SensingSettings:
    """[sensing]: a measurement every `period` seconds, with noise σ_n = noise_sd in the field's unit."""

    period: float = keys.positive(10.0, "s")
    noise_sd: float = keys.positive(1.0)
    seed: int = keys.seed()


@dataclass(frozen=True)
class MapSettings:
    """[map]: sub-problem 4. Kernel at the start, ticks between maximum-likelihood fits (0 for none), map cells a side.

    frames : maps that are kept for the report.
    """

    signal_sd: float = keys.positive(30.0)
    length_scale: float | list[float] = keys.one_or_two(4000.0, "m")
    refit_every: int = keys.count(10, 0)
    cells: int = keys.count(100, 4, 1000)
    frames: int = keys.count(30, 2)


@dataclass(frozen=True)
class CompareSettings:
    """[compare]: what else is flown, over so many `seeds` of field and noise; time_limit [s] of each solve.

    draws : different random tours, taken in turn over the seeds.
    """

    baselines: list[str] = keys.texts(["lawnmower", "random", "greedy"])
    seeds: int = keys.count(8, 1, 1000)
    draws: int = keys.count(8, 1, 1000)
    time_limit: float = keys.positive(1.0, "s", LONGEST)
    seed: int = keys.seed()


@dataclass(frozen=True)
class ExportSettings:
    """[export]: who flies the plans: firmware "px4" or "ardupilot", vehicle "fixed-wing" or "multirotor"."""

    firmware: str = keys.one_of("px4", FIRMWARE)
    vehicle: str = keys.one_of("fixed-wing", KINDS)


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
