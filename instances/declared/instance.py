"""An instance file as it is declared. JSON; costs of many nodes are read apart from the rest (`formats.native`)."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta, field

from instances.declared.types import Name, Pair, Positive, Table, about
from instances.declared.winds import Wind

SCHEMA = 1
"""Version of the format that is written, and the newest that is read."""
Size = Annotated[int, Meta(ge=1)]
Rows = list[list[float]]


class MetricTable(Table, frozen=True, kw_only=True, tag_field="metric"):
    """Costs that follow from the coordinates."""


Rounding = Annotated[Literal["none", "nearest", "up", "down"], about("of the distances", example="nearest")]


class EuclideanTable(MetricTable, frozen=True, kw_only=True, tag="euclidean"):
    """Straight lines at one speed."""

    speed: Annotated[Positive, about("at which they are flown", "m/s", example=20.0)] = 1.0
    rounding: Rounding = "none"


class ManhattanTable(MetricTable, frozen=True, kw_only=True, tag="manhattan"):
    """Distances along the axes, added up."""

    rounding: Rounding = "none"


class MaximumTable(MetricTable, frozen=True, kw_only=True, tag="maximum"):
    """The greatest of the distances along the axes."""

    rounding: Rounding = "none"


class GeoTable(MetricTable, frozen=True, kw_only=True, tag="geo"):
    """TSPLIB's distance on the Earth [km], of degrees and minutes."""


class AttTable(MetricTable, frozen=True, kw_only=True, tag="att"):
    """TSPLIB's pseudo-Euclidean distance."""


class WindMetricTable(MetricTable, frozen=True, kw_only=True, tag="wind"):
    """Straight lines, or around the walls of a region, at constant speed over ground in a wind of closed form."""

    airspeed: Annotated[Positive, about("v0, speed over ground", "m/s", example=20.0)]
    wind: Annotated[
        Wind | None, about("as [wind] of a scenario; null is calm", example={"kind": "shear", "rate": 5e-4})
    ] = None
    region: Annotated[
        list[list[Pair]] | None,
        about("rings of a polygon that legs stay in", "m", words="rings of points [x, y], or null"),
    ] = None


class TravelTable(Table, frozen=True, kw_only=True):
    """What a leg costs where one matrix does not suffice."""

    cost: Annotated[
        list[list[list[list[float | None]]]],
        about(
            "of each class at each departure, state to state; null where a class cannot fly a leg",
            "s",
            words="lists of numbers, class by class and knot by knot",
        ),
    ]
    classes: Annotated[list[int], about("class of each UAV, from 0", example=[0, 1])]
    departures: Annotated[list[float], about("knots of time, from 0, rising", "s", example=[0.0, 600.0])] = field(
        default_factory=lambda: [0.0]
    )
    nodes: Annotated[list[int], about("node of each state; one state a node unless given", example=[0, 0, 1])] = field(
        default_factory=list
    )
    closed: Annotated[bool, about("whether a tour ends in the state of its depot that it began in", example=False)] = (
        False
    )
    window: Annotated[
        float, Meta(ge=0), about("longest wait before take-off, to keep within endurance", "s", example=300.0)
    ] = 0.0


class InstanceTable(Table, frozen=True, kw_only=True):
    """An instance: what it costs to fly between n tasks and m depots, numbered from 0, tasks first."""

    schema: Annotated[int, Meta(ge=1, le=SCHEMA), about("version of the format", example=SCHEMA)]
    name: Annotated[Name, about("short name", example="uniform-n10-m3-s1")]
    n_tasks: Annotated[Size, about("number of tasks n", example=10)]
    n_depots: Annotated[Size, about("number of depots m, one UAV at each", example=3)]
    cost: Annotated[
        Rows | EuclideanTable | ManhattanTable | MaximumTable | AttTable | GeoTable | WindMetricTable | None,
        about(
            "entry [i][j] from node i to node j; may be left out beside travel",
            "s",
            example=[[0.0, 3.5], [4.0, 0.0]],
            words="a list of rows, each of n + m numbers, or an object that names a metric",
        ),
    ] = None
    coordinates: Annotated[list[Pair] | None, about("of the nodes", "m", example=[[0.0, 0.0], [3.0, 4.0]])] = None
    provenance: Annotated[
        dict[str, Any], about("where it comes from: free", example={"family": "uniform"}, words="an object")
    ] = field(default_factory=dict)
    travel: Annotated[
        TravelTable | None, about("where UAVs differ, time counts, or nodes have several states", words="an object")
    ] = None
    endurance: Annotated[
        list[float | None] | None, about("of each UAV, null where unlimited", "s", example=[3600.0, None])
    ] = None

    RULES: ClassVar[dict[str, Any]] = {
        "anyOf": [
            {"required": ["cost"], "properties": {"cost": {"type": ["array", "object"]}}},
            {"required": ["travel"], "properties": {"travel": {"type": "object"}}},
        ]
    }
    """What is refused beyond single keys, for the JSON Schema."""


Metric = EuclideanTable | ManhattanTable | MaximumTable | AttTable | GeoTable | WindMetricTable
