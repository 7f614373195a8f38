"""Settings of a mission: the scenario, what is measured, and the tables of each stage, as they are declared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta
from msgspec import field as key

from formulations.limits import LARGEST_SEED, LONGEST, MOST_THREADS
from formulations.mapping.heights import Altitude, Frame
from instances.declared.scenario import ScenarioKeys, ScenarioTable
from instances.declared.types import FileName, Table, Text, Vector, about
from instances.formats.mavlink_items import Vehicle
from instances.geodesy import TangentPlane
from instances.registry import LARGEST
from instances.scenario import Scenario
from workbench.map_keys import MAXIMISED, Criterion, PriorSd, Weights

SMALLEST = 1e-100
"""The square of a smaller positive number is 0 in float64."""
MOST = 10_000
"""Of whatever is counted, unless the key says otherwise."""
SCENARIO_KEYS = ScenarioKeys.__struct_encode_fields__
"""Every key of a scenario."""
Positive = Annotated[float, Meta(ge=SMALLEST, le=LARGEST)]
NotNegative = Annotated[float, Meta(ge=0, le=LARGEST)]
Lengths = Positive | Annotated[list[Positive], Meta(min_length=2, max_length=2)]
"""One length or two. No tuple: beside a bounded number msgspec 0.22 crashes on one of fixed length."""
TimeLimit = Annotated[float, Meta(ge=SMALLEST, le=LONGEST)]
Seed = Annotated[int, Meta(ge=0, le=LARGEST_SEED)]
MOST_LAPS = 1000
Cells = Annotated[int, Meta(ge=1, le=1000)]


class FieldSettings(Table, frozen=True, kw_only=True):
    """What is measured; the altitude is [flight]'s."""

    file: Annotated[
        FileName | None,
        about(
            "what is measured, from a file: CSV, NetCDF or GeoTIFF; of several times in NetCDF, it changes in flight, "
            "linear between them, from the first at take-off, the last held; made from [radio] where none is given",
            example="field.nc",
        ),
    ] = None
    unit: Annotated[Text | None, about("unit of a file's values, what the file says unless given", example="K")] = None
    model: Annotated[
        Literal["diffraction", "free-space", "itm"], about("propagation of [radio]: diffraction, free-space or itm")
    ] = "diffraction"
    shadowing_sd: Annotated[NotNegative, about("standard deviation of the shadowing, drawn at random", "dB")] = 4.0
    decorrelation: Annotated[Positive, about("distance at which the shadowing's correlation falls to 1/e", "m")] = (
        2000.0
    )
    tau: Annotated[
        Positive | None,
        about(
            "time in which the shadowing's correlation falls to 1/e: it drifts in flight; it stays unless given",
            "s",
            example=600.0,
        ),
    ] = None
    cells: Annotated[Annotated[int, Meta(ge=2, le=2000)], about("nodes of the field along the longer side")] = 200
    seed: Annotated[Seed, about("seed of the shadowing")] = 0


class PlaceSettings(Table, frozen=True, kw_only=True):
    """Sub-problem 1, task locations."""

    method: Annotated[
        Text,
        about("how tasks are placed: nlp, l-bfgs-b, greedy-swap, greedy … (workbench place --help), or module:Class"),
    ] = "nlp"
    options: Annotated[dict[str, Any], about("options of the method", example={"starts": 8})] = key(
        default_factory=dict
    )
    criterion: Annotated[Criterion, about(MAXIMISED)] = "b"
    weights: Weights = None
    prior_sd: PriorSd = None
    tests: Annotated[
        tuple[Cells, Cells], about("columns and rows of the test points, at which the field is to be known")
    ] = (20, 20)
    signal_sd: Annotated[
        Positive, about("σ_f of the planning kernel, in the field's unit; information is stated under this kernel")
    ] = 30.0
    length_scale: Annotated[Lengths, about("length scale of the planning kernel, or two along x and y", "m")] = 4000.0
    noise_sd: Annotated[Positive, about("σ_n of a reading at a task, for planning, in the field's unit")] = 1.0
    seed: Annotated[Seed, about("seed of the method")] = 0
    certificate: Annotated[bool, about("whether an upper bound on the information is computed, too")] = True
    polish: Annotated[
        bool,
        about(
            "whether the tours' waypoints, tasks among them, are moved for what is sensed along the paths, within "
            "[flight] endurance; without one, no tour gets longer than the longest"
        ),
    ] = False


class CostSettings(Table, frozen=True, kw_only=True):
    """Sub-problem 2, moving costs. Zones are widened by the clearance, tasks placed as far from the border."""

    method: Annotated[
        Text, about("how paths are planned: refined, fmt-star, dijkstra, closed-form, or module:Class")
    ] = "refined"
    options: Annotated[dict[str, Any], about("options of the method", example={"samples": 2000})] = key(
        default_factory=dict
    )
    clearance: Annotated[
        NotNegative | None,
        about("room for turns at zones, inlets and border; twice the turning radius unless given", "m", example=100.0),
    ] = None


class RouteSettings(Table, frozen=True, kw_only=True):
    """Sub-problem 3, routes."""

    solver: Annotated[Text, about("who routes: any of workbench solvers, or module:Class")] = "memetic"
    options: Annotated[dict[str, Any], about("options of the solver", example={"removals": 10})] = key(
        default_factory=dict
    )
    time_limit: Annotated[TimeLimit, about("wall clock of the solver", "s")] = 10.0
    bound_time_limit: Annotated[
        NotNegative, about("wall clock for a bound beside the routes; 0 for the quick bounds alone", "s")
    ] = 5.0
    threads: Annotated[Annotated[int, Meta(ge=1, le=MOST_THREADS)], about("threads of the solver")] = 1
    seed: Annotated[Seed, about("seed of the solver")] = 0
    risk: Annotated[
        Literal["mean", "cvar", "worst"] | None,
        about(
            "what of the longest tours over [wind] members the routes are chosen by: their mean, the mean of the worst "
            "fifth, or the worst; the longest in the forecast planned with unless given",
            example="cvar",
        ),
    ] = None


class FlightSettings(Table, frozen=True, kw_only=True):
    """Dubins tours of turning radius r_min at speed v, and how high."""

    speed: Annotated[Positive | None, about("flying speed; the scenario's unless given", "m/s", example=100.0)] = None
    turning_radius: Annotated[Positive, about("least radius of any turn", "m")] = 50.0
    coupled: Annotated[
        bool,
        about(
            "whether routes and headings are planned together, for the least flight time, turns included, and flown "
            "as planned: for tasks less than five turning radii apart, in calm air or, with cost = time, a uniform "
            "wind; needs a solver that takes states"
        ),
    ] = False
    altitude: Annotated[NotNegative, about("flying altitude, in the frame", "m")] = 3000.0
    frame: Annotated[
        Frame, about("what the altitude is above: amsl, above-ground (the track follows the ground) or above-home")
    ] = Frame.AMSL
    clearance: Annotated[
        NotNegative, about("least height of a track above the ground; lower ones are refused", "m")
    ] = 50.0
    climb: Annotated[Positive, about("greatest rate of climb, where a track follows the ground", "m/s")] = 5.0
    descent: Annotated[Positive, about("greatest rate of descent, where a track follows the ground", "m/s")] = 3.0
    laps: Annotated[
        Annotated[int, Meta(ge=1, le=MOST_LAPS)] | Literal["endurance"],
        about(
            "how often each UAV flies its tour, all laps within its endurance; endurance: as often as that lasts",
        ),
    ] = 1
    border_clearance: Annotated[
        NotNegative, about("what flown tracks keep from the region's border and from no-fly zones", "m")
    ] = 0.0
    endurance: Annotated[
        Positive | None,
        about(
            "most that the costs of a UAV's tour, with all its laps, may add up to; where that is too little for all "
            "tasks, those that fit and tell most are flown",
            "s",
            example=3600.0,
        ),
    ] = None


class SensingSettings(Table, frozen=True, kw_only=True):
    """What the UAVs measure on their way."""

    period: Annotated[Positive, about("time between two measurements of a UAV", "s")] = 10.0
    noise_sd: Annotated[Positive, about("σ_n of a measurement, in the field's unit")] = 1.0
    seed: Annotated[Seed, about("seed of the noise")] = 0


class MapSettings(Table, frozen=True, kw_only=True):
    """Sub-problem 4, the Gaussian process."""

    signal_sd: Annotated[Positive, about("σ_f believed at take-off, in the field's unit")] = 30.0
    length_scale: Annotated[Lengths, about("length scale believed at take-off, or two along x and y", "m")] = 4000.0
    prior_sd: Annotated[
        FileName | None,
        about(
            "a map in place of signal_sd, [place] prior_sd unless given; fits change its height", example="unsure.tif"
        ),
    ] = None
    kernel: Annotated[
        Literal["auto", "se", "matern52", "matern32", "matern12"],
        about(
            "covariance of the map, from se (smooth) to matern12 (rough); auto is the likeliest; planning is under se"
        ),
    ] = "auto"
    mean: Annotated[
        Literal["constant", "path-loss", "propagation", "auto"],
        about("mean of the map: a constant, or beside it distance from the transmitter or diffraction, where likelier"),
    ] = "constant"
    tau: Annotated[
        Positive | Literal["auto"] | None,
        about(
            "time in which the field's correlation falls to 1/e, so that old readings count less; auto: taken to drift "
            "where that is likelier; the field is taken to stay unless given",
            "s",
            example=600.0,
        ),
    ] = None
    refit_every: Annotated[
        Annotated[int, Meta(ge=0, le=MOST)], about("measuring rounds between fits of the map's model; 0 for none")
    ] = 10
    cells: Annotated[Annotated[int, Meta(ge=4, le=1000)], about("cells of the map along the longer side")] = 100
    frames: Annotated[Annotated[int, Meta(ge=2, le=MOST)], about("maps that are kept for the report")] = 30


class EventTable(Table, frozen=True, kw_only=True):
    """Something that happens in flight."""

    time: Annotated[Positive, about("when it happens, after take-off", "s", example=120.0)]
    kind: Annotated[
        Literal["lost-uav", "no-fly", "wind"], about("what: lost-uav, no-fly (a new zone) or wind", example="lost-uav")
    ]
    uav: Annotated[
        Annotated[int, Meta(ge=0)] | None, about("of lost-uav: number of the UAV that flies no more", example=0)
    ] = None
    polygon: Annotated[
        Annotated[list[Vector], Meta(min_length=3)] | None,
        about(
            "of no-fly: corners of the zone in the local plane; or give file",
            "m",
            example=[[8000.0, 8000.0], [9000.0, 8000.0], [9000.0, 9000.0]],
        ),
    ] = None
    file: Annotated[FileName | None, about("of no-fly: its polygons from a file, as no_fly", example="closed.kml")] = (
        None
    )
    velocity: Annotated[
        Vector | None, about("of wind: one for the whole region, in place of the wind", "m/s", example=[5.0, 0.0])
    ] = None


class ReplanSettings(Table, frozen=True, kw_only=True):
    """Plans that change in flight, by what was measured and by what happens."""

    every: Annotated[
        Annotated[int, Meta(ge=1, le=MOST)] | None,
        about("measuring rounds between re-plans; none but at events unless given", example=10),
    ] = None
    event: Annotated[
        list[EventTable],
        about(
            "what happens in flight; each is re-planned for",
            example=[{"time": 120.0, "kind": "lost-uav", "uav": 0}],
            words="tables",
        ),
    ] = key(default_factory=list)

    @property
    def wanted(self) -> bool:
        """Whether anything is re-planned."""
        return self.every is not None or bool(self.event)


class CompareSettings(Table, frozen=True, kw_only=True):
    """What else is flown over the same fields."""

    baselines: Annotated[
        list[Literal["lawnmower", "random", "greedy"]], about("what else is flown: lawnmower, random, greedy")
    ] = key(default_factory=lambda: ["lawnmower", "random", "greedy"])
    seeds: Annotated[
        Annotated[int, Meta(ge=1, le=1000)],
        about("noise seeds, each with shadowing of its own, over which verdicts are formed"),
    ] = 8
    draws: Annotated[
        Annotated[int, Meta(ge=1, le=1000)], about("different random tours, taken in turn over the seeds")
    ] = 8
    time_limit: Annotated[TimeLimit, about("wall clock of the solver for each baseline", "s")] = 1.0
    seed: Annotated[Seed, about("seed of what is drawn for the comparison")] = 0


class ExportSettings(Table, frozen=True, kw_only=True):
    """Who flies the plans."""

    firmware: Annotated[Literal["px4", "ardupilot"], about("autopilot of the .plan and .waypoints files")] = "px4"
    vehicle: Annotated[Literal["fixed-wing", "multirotor"], about("vehicle of the .plan and .waypoints files")] = (
        "fixed-wing"
    )


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
    replan: ReplanSettings
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
        """How high is flown."""
        wanted = self.flight
        return Altitude(wanted.altitude, wanted.frame, wanted.climb / self.speed, wanted.descent / self.speed)

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


class MissionTable(ScenarioKeys, frozen=True, kw_only=True):
    """A mission: a scenario, what is measured in it, and the settings of each stage. TOML."""

    scenario: Annotated[
        FileName | None,
        about("a scenario's keys from a file of their own, instead of here", example="scenario.toml", given=False),
    ] = None
    field: Annotated[FieldSettings, about("what is measured")] = FieldSettings()
    place: Annotated[PlaceSettings, about("task locations")] = PlaceSettings()
    costs: Annotated[CostSettings, about("moving costs")] = CostSettings()
    routes: Annotated[RouteSettings, about("routes")] = RouteSettings()
    flight: Annotated[FlightSettings, about("how the tours are flown")] = FlightSettings()
    sensing: Annotated[SensingSettings, about("measurements")] = SensingSettings()
    map: Annotated[MapSettings, about("the map")] = MapSettings()
    replan: Annotated[ReplanSettings, about("re-planning in flight")] = ReplanSettings()
    compare: Annotated[CompareSettings, about("what else is flown")] = CompareSettings()
    export: Annotated[ExportSettings, about("who flies the plans")] = ExportSettings()

    RULES: ClassVar[dict[str, Any]] = {
        "if": {"required": ["scenario"]},
        "then": {"not": {"anyOf": [{"required": [name]} for name in SCENARIO_KEYS if name != "origin"]}},
        "else": ScenarioTable.RULES,
    }
    """What is refused beyond single keys, for the JSON Schema."""

    def __post_init__(self) -> None:
        if self.scenario is None:
            self.check()


TABLES: dict[str, type[Table]] = {
    "field": FieldSettings,
    "place": PlaceSettings,
    "costs": CostSettings,
    "routes": RouteSettings,
    "flight": FlightSettings,
    "sensing": SensingSettings,
    "map": MapSettings,
    "replan": ReplanSettings,
    "compare": CompareSettings,
    "export": ExportSettings,
}
"""Table of a mission file → what it may hold."""
