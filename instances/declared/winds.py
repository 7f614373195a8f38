"""The table ``[wind]`` of a scenario, and of the metric of an instance: a kind, and the keys of that kind."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from instances.declared.types import FileName, NotNegative, Number, Positive, Table, Vector, Whole, about
from instances.extent import FINEST, LARGEST

MOST_MODES = 10_000
"""Every point of a turbulent wind sums them all."""


class WindTable(Table, frozen=True, kw_only=True, tag_field="kind"):
    """A wind, blowing towards (u, v)."""


class UniformTable(WindTable, frozen=True, kw_only=True, tag="uniform"):
    """The same everywhere."""

    velocity: Annotated[Vector, about("(u, v), east and north", "m/s", example=[-5.0, 0.0])]


class ShearTable(WindTable, frozen=True, kw_only=True, tag="shear"):
    """Linear: (rate · (y − y0), 0)."""

    rate: Annotated[Number, about("gain of speed per metre north", "1/s", example=5e-4)]
    centre: Annotated[Vector, about("(x0, y0), where it is calm", "m", example=[10000.0, 10000.0])] = (0.0, 0.0)


class RotationTable(WindTable, frozen=True, kw_only=True, tag="rotation"):
    """Rigid, anticlockwise."""

    rate: Annotated[Number, about("angular velocity", "1/s", example=5e-4)]
    centre: Annotated[Vector, about("about which it turns", "m", example=[10000.0, 10000.0])] = (0.0, 0.0)


class VorticesTable(WindTable, frozen=True, kw_only=True, tag="vortices"):
    """Vortices side by side."""

    centres: Annotated[list[Vector], Meta(min_length=1), about("of each vortex", "m", example=[[6000.0, 8000.0]])]
    circulation: Annotated[
        list[Number], Meta(min_length=1), about("of each, anticlockwise positive", "m²/s", example=[60000.0])
    ]
    core: Annotated[
        list[NotNegative] | None, about("radius of each, where it is fastest; 0 unless given", "m", example=[1500.0])
    ] = None

    def __post_init__(self) -> None:
        core = self.circulation if self.core is None else self.core
        if not len(self.centres) == len(self.circulation) == len(core):
            raise ValueError(
                f"vortices need as many centres, circulations and cores, got {len(self.centres)}, "
                f"{len(self.circulation)} and {len(core)}"
            )


class TurbulenceTable(WindTable, frozen=True, kw_only=True, tag="turbulence"):
    """Random eddies."""

    rms: Annotated[NotNegative, about("root mean square of the speed", "m/s", example=3.0)]
    length_scale: Annotated[
        float, Meta(ge=FINEST, le=LARGEST), about("size of the largest eddies", "m", example=4000.0)
    ]
    seed: Annotated[Whole, about("of what is drawn", example=0)] = 0
    modes: Annotated[int, Meta(ge=1, le=MOST_MODES), about("waves that are summed", example=48)] = 48


class GridTable(WindTable, frozen=True, kw_only=True, tag="grid"):
    """A file of gridded wind; a forecast where it holds several times, with cost = "time"."""

    file: Annotated[FileName, about("NetCDF, or WindNinja's _vel.asc beside its _ang.asc", example="wind.nc")]
    units: Annotated[
        Literal["m/s", "mph", "kph", "knots"] | None,
        about("of a WindNinja file, m/s unless given; NetCDF states its own", example="m/s"),
    ] = None
    members: Annotated[
        list[FileName] | None,
        about(
            "of an ensemble: other forecasts; plans are made in file, and judged in these as well",
            example=["wind-1.nc", "wind-2.nc"],
            given=False,
        ),
    ] = None
    take_off: Annotated[
        NotNegative | None,
        about("of a forecast: when is taken off, after its first time; then unless given", "s", example=1800.0),
    ] = None


class MountainsTable(Table, frozen=True, kw_only=True):
    """Made mountains."""

    size: Annotated[Positive | None, about("side of their square, 20 km unless given", "m", example=20000.0)] = None
    relief: Annotated[NotNegative | None, about("highest peak, 1500 m unless given", "m", example=2000.0)] = None
    length_scale: Annotated[
        Positive | None, about("size of the largest ranges, 10 km unless given", "m", example=12000.0)
    ] = None
    seed: Annotated[Whole | None, about("of what is drawn, 0 unless given", example=0)] = None


class TerrainTable(WindTable, frozen=True, kw_only=True, tag="terrain"):
    """Flow over an elevation model or made mountains."""

    dem: Annotated[FileName | None, about("elevation model; or give mountains", example="dem.tif", given=False)] = None
    mountains: Annotated[
        MountainsTable | None,
        about("made ones; or give dem", example={"seed": 0, "relief": 2000.0, "length_scale": 12000.0}),
    ] = None
    velocity: Annotated[Vector, about("of the inflow, (u, v)", "m/s", example=[-7.0, -7.0])]
    altitude: Annotated[Number, about("of the slice that is flown in, above sea level", "m", example=3000.0)]
    profile: Annotated[Literal["uniform", "log", "power"], about("how the inflow grows with height", example="log")] = (
        "log"
    )
    reference: Annotated[Positive, about("height above ground where velocity is known", "m", example=3000.0)] = 1000.0
    roughness: Annotated[Positive, about("length of a log profile", "m", example=0.5, given=False)] = 0.5
    exponent: Annotated[float, Meta(ge=0, le=10), about("of a power profile", example=0.143, given=False)] = 0.143
    cells: Annotated[int, Meta(ge=2), about("of the flow, along the longer side", example=160)] = 200
    layers: Annotated[int, Meta(ge=2), about("of the flow", example=30)] = 30

    def __post_init__(self) -> None:
        if (self.dem is None) == (self.mountains is None):
            raise ValueError("kind 'terrain' needs either 'dem', a file, or 'mountains', a table")


class TurningTable(WindTable, frozen=True, kw_only=True, tag="turning"):
    """The same everywhere, turning with time; with cost = "time"."""

    velocity: Annotated[Vector, about("at take-off, (u, v)", "m/s", example=[-5.0, 0.0])]
    turning: Annotated[Number, about("angular velocity, anticlockwise", "rad/s", example=4.4e-4)]


class ValleyTable(WindTable, frozen=True, kw_only=True, tag="valley"):
    """Up and down a valley in turn, the same everywhere; with cost = "time"."""

    velocity: Annotated[Vector, about("mean", "m/s", example=[1.0, 0.0])]
    amplitude: Annotated[Vector, about("of the swing", "m/s", example=[6.0, 3.0])]
    period: Annotated[Positive, about("of the swing", "s", example=86400.0)] = 86400.0
    phase: Annotated[Number, about("share of a period passed at take-off", example=0.25)] = 0.0


class FrontTable(WindTable, frozen=True, kw_only=True, tag="front"):
    """A front that passes; with cost = "time"."""

    before: Annotated[Vector, about("wind ahead of the front", "m/s", example=[-5.0, -5.0])]
    after: Annotated[Vector, about("wind behind it", "m/s", example=[8.0, 0.0])]
    speed: Annotated[Number, about("of the front", "m/s", example=8.0)]
    direction: Annotated[Number, about("it moves to, anticlockwise from east", "degree", example=0.0)] = 0.0
    position: Annotated[Number, about("of the front at take-off, along its direction", "m", example=-5000.0)] = 0.0
    width: Annotated[Positive, about("half of that of the transition", "m", example=2000.0)] = 2000.0


class DriftingTable(VorticesTable, frozen=True, kw_only=True, tag="drifting"):
    """Vortices that drift through a mean wind; with cost = "time"."""

    velocity: Annotated[Vector, about("mean wind", "m/s", example=[-5.0, 0.0])]
    drift: Annotated[Vector, about("of the vortices", "m/s", example=[-4.0, 0.0])]


class SumTable(WindTable, frozen=True, kw_only=True, tag="sum"):
    """Several winds together."""

    parts: Annotated[
        list[Wind],
        Meta(min_length=1),
        about(
            "tables, each with its kind",
            example=[
                {"kind": "uniform", "velocity": [-5.0, 0.0]},
                {"kind": "turbulence", "rms": 2.0, "length_scale": 4000.0},
            ],
        ),
    ]


Wind = (
    UniformTable
    | ShearTable
    | RotationTable
    | VorticesTable
    | TurbulenceTable
    | GridTable
    | TerrainTable
    | TurningTable
    | ValleyTable
    | FrontTable
    | DriftingTable
    | SumTable
)
