"""A scenario file as it is declared: every key, what it takes, its unit, its meaning and an example."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from msgspec import Meta, field

from instances.declared.types import (
    FileName,
    Name,
    Natural,
    NotNegative,
    Number,
    Pair,
    Positive,
    Table,
    about,
)
from instances.declared.winds import Wind
from instances.errors import InputError
from instances.fleet import MOST_UAVS, Return
from instances.moving_cost import CostKind

Places = Annotated[list[Pair], Meta(min_length=1)]


class RadioTable(Table, frozen=True, kw_only=True):
    """One transmitter, whose signal a mission measures where its [field] names no file."""

    position: Annotated[
        Pair | None,
        about("where the transmitter stands, as depots", "m", example=[10000.0, 10000.0], words="two numbers [x, y]"),
    ] = None
    height: Annotated[Positive, about("of its mast above the ground", "m", example=10.0)] = 10.0
    frequency: Annotated[Positive, about("of the signal", "Hz", example=146e6)] = 146e6
    power_dbm: Annotated[Number, about("transmitted power", "dBm", example=40.0)] = 40.0
    transmitter_gain_dbi: Annotated[Number, about("gain of the transmitter's antenna", "dBi", example=6.0)] = 6.0
    receiver_gain_dbi: Annotated[Number, about("gain of the UAVs' antennas", "dBi", example=2.0)] = 2.0


class UavTable(Table, frozen=True, kw_only=True):
    """UAVs that differ. Without any there is one at each depot, all alike."""

    depot: Annotated[
        Annotated[int, Meta(ge=0)] | None,
        about("where it starts: number in depots, from 0; may be left out where there is one", example=0),
    ] = None
    count: Annotated[int, Meta(ge=1, le=MOST_UAVS), about("so many like it", example=1)] = 1
    speed: Annotated[Positive | None, about("in place of the scenario's", "m/s", example=25.0)] = None
    endurance: Annotated[
        Positive | None, about("of its battery, in seconds of cost; unlimited unless given", "s", example=3600.0)
    ] = None
    turning_radius: Annotated[
        Positive | None,
        about(
            "least radius of its turns: legs are then Dubins paths between headings; for all UAVs or for none",
            "m",
            example=120.0,
        ),
    ] = None


class ScenarioKeys(Table, frozen=True, kw_only=True):
    """What a scenario and a mission file both take."""

    name: Annotated[Name | None, about("short name; the file's name unless given", example="survey")] = None
    cost: Annotated[
        CostKind,
        about("what a leg costs: the paper's energy at ground_speed, or flight time at airspeed", example="energy"),
    ] = CostKind.ENERGY
    ground_speed: Annotated[
        Positive | None, about("speed over ground, v0, with cost = energy", "m/s", example=100.0)
    ] = None
    airspeed: Annotated[
        Positive | None, about("speed through the air, with cost = time", "m/s", example=30.0, given=False)
    ] = None
    size: Annotated[
        tuple[Positive, Positive] | None,
        about("rectangle with (0, 0) in its lower left corner; or give region", "m", example=[20000.0, 20000.0]),
    ] = None
    region: Annotated[
        FileName | None,
        about(
            "its polygon, KML, KMZ, GeoJSON, GeoPackage or Shapefile; instead of size", example="area.kml", given=False
        ),
    ] = None
    no_fly: Annotated[
        FileName | None, about("polygons that nobody may enter, as region", example="zones.kml", given=False)
    ] = None
    depots: Annotated[
        Places | FileName | None,
        about(
            "one UAV at each",
            "m",
            example=[[10000.0, 19000.0], [1000.0, 1000.0], [19000.0, 1000.0]],
            words="a list of at least one point [x, y] [m] or [lon, lat], or a file of them",
        ),
    ] = None
    tasks: Annotated[
        Natural | Places | FileName | None,
        about(
            "how many tasks to place, or where they are",
            "m",
            example=40,
            words="points, or a file of them, or a whole number of at least 1",
        ),
    ] = None
    crs: Annotated[
        str | None,
        about(
            "reference system of lists and of files that state none, or local: docs/coordinates.md",
            example="EPSG:4326",
            given=False,
        ),
    ] = None
    origin: Annotated[
        Pair | None,
        about(
            "of the point (0, 0); without it no files for other software",
            "degrees",
            example=[36.0, 128.0],
            words="[latitude, longitude] in degrees",
        ),
    ] = None
    terrain: Annotated[FileName | None, about("elevation model, GeoTIFF or NetCDF", example="dem.tif", given=False)] = (
        None
    )
    uav: Annotated[
        list[UavTable] | None,
        about(
            "UAVs that differ: depot counts from 0, speed instead of the scenario's, endurance in seconds of cost, "
            "turning_radius in metres",
            example=[{"depot": 0, "speed": 25.0, "endurance": 3600.0, "count": 1}],
            words="tables",
            given=False,
        ),
    ] = None
    service: Annotated[
        NotNegative | list[NotNegative],
        about(
            "time spent at each task, or at one after the other",
            "s",
            example=30.0,
            given=False,
        ),
    ] = 0.0
    window: Annotated[
        NotNegative,
        about(
            "longest wait before take-off, in a wind that changes: it may keep a flight within endurance",
            "s",
            example=600.0,
            given=False,
        ),
    ] = 0.0
    returns: Annotated[
        Return, about("where tours end: at their own depot, at any, at their last task", example="own")
    ] = field(default=Return.OWN, name="return")
    wind: Annotated[Wind | None, about("calm unless given", example={"kind": "uniform", "velocity": [-5.0, 0.0]})] = (
        None
    )
    radio: Annotated[RadioTable | None, about("one transmitter", example={"position": [10000.0, 10000.0]})] = None
    provenance: Annotated[
        dict[str, Any],
        about("where the scenario comes from; kept, not read", example={"made": "by hand"}, given=False),
    ] = field(default_factory=dict)

    def check(self) -> None:
        """Raise InputError where keys contradict each other, or one is missing that none can stand in for."""
        timed = self.cost is CostKind.TIME
        if timed and self.ground_speed is not None:
            raise InputError("cost = 'time' is reckoned at a constant airspeed: give 'airspeed', not 'ground_speed'")
        if self.ground_speed is not None and self.airspeed is not None:
            raise InputError(
                "cost = 'energy' is reckoned at a constant ground_speed: give 'ground_speed' alone, not 'airspeed' too"
            )
        if self.size is not None and self.region is not None:
            raise InputError("either 'size' or 'region' must be given, not both")
        needed: dict[str, object] = {
            "'airspeed'" if timed else "'ground_speed'": self.ground_speed or self.airspeed,
            "'depots'": self.depots,
            "'tasks'": self.tasks,
            "'size' or 'region'": self.size or self.region,
        }
        for keys, value in needed.items():
            if value is None:
                raise InputError(f"the key {keys} is missing")

    @property
    def speed(self) -> float:
        """The speed that the cost holds constant [m/s]; an energy's may stand under its old key 'airspeed'."""
        found = self.airspeed if self.ground_speed is None else self.ground_speed
        assert found is not None  # see `check`
        return found


class ScenarioTable(ScenarioKeys, frozen=True, kw_only=True):
    """A scenario: where it is flown, from where, how fast, in what wind, and to which tasks. TOML."""

    RULES: ClassVar[dict[str, Any]] = {
        "required": ["depots", "tasks"],
        "oneOf": [{"required": ["size"]}, {"required": ["region"]}],
        "if": {"properties": {"cost": {"const": "time"}}, "required": ["cost"]},
        "then": {"required": ["airspeed"], "not": {"required": ["ground_speed"]}},
        "else": {"oneOf": [{"required": ["ground_speed"]}, {"required": ["airspeed"]}]},
    }
    """What `check` refuses, for the JSON Schema."""

    def __post_init__(self) -> None:
        self.check()
