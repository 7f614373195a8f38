"""The families `wind-uniform`, `wind-vortices`, `wind-mountains`: missions with no-fly zones in a wind with vorticity.

A wind without vorticity changes no tour, so each wind here carries some.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from instances.environment.region import Region
from instances.environment.wind import Uniform, WindField
from instances.environment.wind_table import Sum
from instances.environment.wind_vortices import Vortices
from instances.errors import InputError
from instances.families import depots
from instances.families.family import Family, Legs
from instances.families.parameter import GROUND_SPEED, Parameter, Values
from instances.families.square import SIZE, square, uniform_tasks
from instances.families.wind_zones import PARAMETERS as ZONES
from instances.families.wind_zones import no_fly_zones
from instances.scenario import Scenario

STEADY = (
    GROUND_SPEED,
    Parameter("wind_speed", 7.0, "m/s", "speed of the steady wind", at_least=0.0),
    Parameter("wind_direction", 225.0, "degree", "where the steady wind blows to, anticlockwise from east"),
)

TURBULENCE = (
    Parameter("turbulence", 2.0, "m/s", "root mean square speed of the turbulence (stream function)", at_least=0.0),
    Parameter("eddy_size", 6_000.0, "m", "size of its largest eddies", at_least=1.0),
)

MakeWind = Callable[[Region, np.random.Generator, Values], WindField]


@dataclass(frozen=True)
class WindFamily(Family):
    """A family with no-fly zones and a wind that is drawn."""

    wind: MakeWind | None = None
    """Region, random numbers, parameters → the wind."""

    def scenario(self, n_tasks: int, n_depots: int, seed: int, given: Mapping[str, Any]) -> Scenario:
        """Return the mission of this size and seed; zones, wind, tasks and depots have separate random numbers."""
        values = self.values(given)
        region = self.region(values)
        streams = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(4))
        for_zones, for_wind, for_tasks, for_depots = streams
        assert self.wind is not None
        try:
            zones, wind = no_fly_zones(region, for_zones, values), self.wind(region, for_wind, values)
        except InputError as error:
            raise InputError(f"family {self.name}: {error}") from None
        free = region.minus(zones)
        return Scenario(
            name=f"{self.name}-n{n_tasks}-m{n_depots}-s{seed}",
            region=region,
            depots=depots.place_depots(free, n_depots, for_depots, values),
            speed=values["ground_speed"],
            wind=wind,
            tasks=self.tasks(free, n_tasks, for_tasks, values),
            no_fly=zones,
            provenance={"family": self.name, "parameters": values, "seed": seed},
        )


def _steady(values: Values) -> Uniform:
    angle = math.radians(values["wind_direction"])
    return Uniform((values["wind_speed"] * math.cos(angle), values["wind_speed"] * math.sin(angle)))


def _with_turbulence(wind: WindField, rng: np.random.Generator, values: Values) -> WindField:
    from instances.environment.wind_turbulence import Turbulence  # here: numba takes its time

    if values["turbulence"] == 0:
        return wind
    return Sum((wind, Turbulence(values["turbulence"], values["eddy_size"], int(rng.integers(2**31)))))


def _vortices(region: Region, rng: np.random.Generator, values: Values) -> WindField:
    return Sum((_steady(values), draw_vortices(region, rng, values)))


def draw_vortices(region: Region, rng: np.random.Generator, values: Values) -> Vortices:
    """Return vortices in the region, well apart; InputError where they do not fit into it."""
    count, core = values["vortices"], values["core"]
    candidates = region.sample(64 * count, rng)
    centres = candidates[:1]
    for p in candidates[1:]:
        if len(centres) < count and np.hypot(*(centres - p).T).min() > 2.5 * core:
            centres = np.vstack([centres, p])
    if len(centres) < count:
        raise InputError(f"{count} vortices with cores of {core:g} m do not fit into the region")
    # A Scully vortex is fastest at the edge of its core, with Γ/(4π c).
    gamma = 4 * math.pi * core * values["vortex_speed"] * rng.choice([-1.0, 1.0], count)
    return Vortices(tuple((float(x), float(y)) for x, y in centres), tuple(map(float, gamma)), (core,) * count)


def _mountains(region: Region, rng: np.random.Generator, values: Values) -> WindField:
    from instances.environment.mass_consistent import Inflow  # here: numba takes its time
    from instances.environment.wind_terrain import TerrainWind

    ground = {
        "size": values["size"],
        "relief": values["relief"],
        "length_scale": values["range_size"],
        "seed": int(rng.integers(2**31)),
    }
    inflow = Inflow(_steady(values).velocity, values["profile"], reference=1000.0)
    flow = TerrainWind(inflow, values["altitude"], None, ground, values["cells"])
    return _with_turbulence(flow, rng, values)


WIND_UNIFORM = WindFamily(
    "wind-uniform",
    (SIZE, *STEADY, *TURBULENCE, *ZONES, *depots.PARAMETERS),
    square,
    uniform_tasks,
    Legs.INSIDE,
    wind=lambda region, rng, values: _with_turbulence(_steady(values), rng, values),
)

WIND_VORTICES = WindFamily(
    "wind-vortices",
    (
        SIZE,
        *STEADY,
        Parameter("vortices", 4, "", "number of vortices, either way round", at_least=1),
        Parameter("vortex_speed", 5.0, "m/s", "largest speed in a vortex", at_least=0.0),
        Parameter("core", 1_500.0, "m", "radius at which a vortex is fastest", at_least=1.0),
        *ZONES,
        *depots.PARAMETERS,
    ),
    square,
    uniform_tasks,
    Legs.INSIDE,
    wind=_vortices,
)

WIND_MOUNTAINS = WindFamily(
    "wind-mountains",
    (
        SIZE,
        *STEADY,
        Parameter("relief", 1_500.0, "m", "height of the mountains over the valleys", at_least=0.0),
        Parameter("range_size", 10_000.0, "m", "size of the mountains", at_least=1.0),
        Parameter("altitude", 1_600.0, "m", "altitude of the flight, above the highest ground", at_least=0.0),
        Parameter("profile", "log", "", "how the inflow varies with height above ground", ("uniform", "log", "power")),
        Parameter("cells", 160, "", "cells of the flow along a side", at_least=8),
        *TURBULENCE,
        *ZONES,
        *depots.PARAMETERS,
    ),
    square,
    uniform_tasks,
    Legs.INSIDE,
    wind=_mountains,
)
