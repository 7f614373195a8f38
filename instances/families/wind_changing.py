"""The families `wind-turning`, `wind-valley`, `wind-front`, `wind-drifting`: winds that change with time.

Tasks and depots are uniform in a square, from ``numpy.random.default_rng(1000·n + 100·m + seed)``, tasks first, as in
``square_wind.py``; with `depots` = "paper" three depots stand at (½, 1), (0, 0) and (1, 0) of its side. Costs are
flight times at a constant airspeed; `instances.environment.wind_changing` says what the winds are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from instances.arrays import Floats
from instances.environment.region import Region
from instances.environment.wind_changing import ChangingWind, Drifting, Front, Turning, Valley
from instances.errors import InputError
from instances.families.family import Family, Legs
from instances.families.parameter import Parameter, Values
from instances.families.square import SIZE, square, uniform_tasks
from instances.families.wind_missions import draw_vortices
from instances.moving_cost import CostKind
from instances.scenario import Scenario

PAPER_DEPOTS = np.array([[0.5, 1.0], [0.0, 0.0], [1.0, 0.0]])
"""The paper's depots, in sides of the square."""

PARAMETERS = (
    SIZE,
    Parameter("airspeed", 20.0, "m/s", "speed of the UAVs through the air", at_least=1e-9),
    Parameter("depots", "random", "", "uniform, or where the paper's three UAVs start", ("random", "paper")),
)
MEAN = (
    Parameter("wind_speed", 10.0, "m/s", "speed of the wind", at_least=0.0),
    Parameter("wind_direction", 0.0, "degree", "where it blows to at take-off, anticlockwise from east"),
)

MakeWind = Callable[[Region, np.random.Generator, Values], ChangingWind]


@dataclass(frozen=True)
class ChangingFamily(Family):
    """A family whose wind changes with time."""

    wind: MakeWind | None = None
    """Region, random numbers, parameters → the wind."""

    def scenario(self, n_tasks: int, n_depots: int, seed: int, given: Mapping[str, Any]) -> Scenario:
        """Return the mission of this size and seed; the wind has random numbers of its own."""
        values = self.values(given)
        region, stream = self.region(values), 1000 * n_tasks + 100 * n_depots + seed
        points = np.random.default_rng(stream).uniform(0, values["size"], (n_tasks + n_depots, 2))
        assert self.wind is not None
        try:
            if values["depots"] == "paper":
                points[n_tasks:] = _paper_depots(n_depots) * values["size"]
            wind = self.wind(region, np.random.default_rng([stream, 1]), values)
        except InputError as error:
            raise InputError(f"family {self.name}: {error}") from None
        return Scenario(
            name=f"{self.name}-n{n_tasks}-m{n_depots}-s{seed}",
            region=region,
            depots=points[n_tasks:],
            speed=values["airspeed"],
            wind=wind,
            tasks=points[:n_tasks],
            provenance={"family": self.name, "parameters": values, "seed": seed},
            cost=CostKind.TIME,
        )


def _paper_depots(n_depots: int) -> Floats:
    if n_depots != len(PAPER_DEPOTS):
        raise InputError(f"depots: the paper's are {len(PAPER_DEPOTS)}, not {n_depots}")
    return PAPER_DEPOTS


def _towards(speed: float, direction: float) -> tuple[float, float]:
    """Return the velocity [m/s] of `speed` towards `direction` [degree]."""
    return speed * math.cos(math.radians(direction)), speed * math.sin(math.radians(direction))


def _mean(values: Values) -> tuple[float, float]:
    return _towards(values["wind_speed"], values["wind_direction"])


def _drifting(region: Region, rng: np.random.Generator, values: Values) -> Drifting:
    whirls = draw_vortices(region, rng, values)
    drift = _towards(values["drift"], values["wind_direction"])
    return Drifting(_mean(values), drift, whirls.centres, whirls.circulation, whirls.core)


def _front(region: Region, rng: np.random.Generator, values: Values) -> Front:
    after = _towards(values["speed_after"], values["direction_after"])
    place = values["front_speed"], values["front_direction"], values["position"], values["width"]
    return Front(_mean(values), after, *place)


WIND_TURNING = ChangingFamily(
    "wind-turning",
    (*PARAMETERS, *MEAN, Parameter("turning", 90.0, "degree/h", "how fast the wind turns, anticlockwise")),
    square,
    uniform_tasks,
    Legs.STRAIGHT,
    wind=lambda region, rng, values: Turning(_mean(values), math.radians(values["turning"]) / 3600),
)

WIND_VALLEY = ChangingFamily(
    "wind-valley",
    (
        *PARAMETERS,
        Parameter("wind_speed", 2.0, "m/s", "speed of the mean wind", at_least=0.0),
        Parameter("wind_direction", 0.0, "degree", "where the mean wind blows to, anticlockwise from east"),
        Parameter("swing", 8.0, "m/s", "greatest speed up and down the valley", at_least=0.0),
        Parameter("valley", 45.0, "degree", "where the valley leads up to, anticlockwise from east"),
        Parameter("period", 24.0, "h", "from one turn up the valley to the next", at_least=1e-3),
        Parameter("phase", 0.0, "", "share of a period passed at take-off; at 0 the wind turns up the valley"),
    ),
    square,
    uniform_tasks,
    Legs.STRAIGHT,
    wind=lambda region, rng, values: Valley(
        _mean(values), _towards(values["swing"], values["valley"]), 3600 * values["period"], values["phase"]
    ),
)

WIND_FRONT = ChangingFamily(
    "wind-front",
    (
        *PARAMETERS,
        Parameter("wind_speed", 8.0, "m/s", "speed of the wind ahead of the front", at_least=0.0),
        Parameter("wind_direction", 45.0, "degree", "where it blows to ahead of the front, anticlockwise from east"),
        Parameter("speed_after", 10.0, "m/s", "speed of the wind behind the front", at_least=0.0),
        Parameter("direction_after", -45.0, "degree", "where it blows to behind the front"),
        Parameter("front_speed", 8.0, "m/s", "speed of the front", at_least=0.0),
        Parameter("front_direction", 0.0, "degree", "where the front moves to, anticlockwise from east"),
        Parameter("position", 0.0, "m", "of the front at take-off, along its direction from the lower left corner"),
        Parameter("width", 2000.0, "m", "half of that of the front", at_least=1.0),
    ),
    square,
    uniform_tasks,
    Legs.STRAIGHT,
    wind=_front,
)

WIND_DRIFTING = ChangingFamily(
    "wind-drifting",
    (
        *PARAMETERS,
        Parameter("wind_speed", 6.0, "m/s", "speed of the mean wind", at_least=0.0),
        Parameter("wind_direction", 225.0, "degree", "where it and the vortices go, anticlockwise from east"),
        Parameter("drift", 6.0, "m/s", "speed of the vortices' drift"),
        Parameter("vortices", 4, "", "number of vortices, either way round", at_least=1),
        Parameter("vortex_speed", 6.0, "m/s", "largest speed in a vortex", at_least=0.0),
        Parameter("core", 1_500.0, "m", "radius at which a vortex is fastest", at_least=1.0),
    ),
    square,
    uniform_tasks,
    Legs.STRAIGHT,
    wind=_drifting,
)
