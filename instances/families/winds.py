"""The wind option of every family: none, or one of the winds whose moving costs have a closed form.

``wind_speed`` is the largest wind in the region's bounding box, so that |w| < v0 holds wherever tasks can be.
"""

from __future__ import annotations

import math

import numpy as np

from instances.environment.region import Region
from instances.environment.wind import Rotation, Shear, Uniform, WindField
from instances.errors import InputError
from instances.families.parameter import GROUND_SPEED, Parameter, Values

KINDS = ("none", "uniform", "shear", "rotation")
"""Winds to choose from."""

PARAMETERS = (
    GROUND_SPEED,
    Parameter("wind", "none", "", "kind of wind; all but none make costs asymmetric", KINDS),
    Parameter("wind_speed", 8.0, "m/s", "largest speed of the wind in the region", at_least=0.0),
    Parameter("wind_direction", 30.0, "degree", "where a uniform wind blows to, anticlockwise from east"),
)
"""Parameters every family with wind has."""


def make_wind(region: Region, values: Values) -> WindField | None:
    """Return the wind the parameters ask for, None for calm; InputError where it is as fast as the UAVs."""
    kind, speed, most = values["wind"], values["wind_speed"], values["ground_speed"]
    if kind == "none":
        return None
    if speed >= most:
        raise InputError(f"wind_speed: must be below the ground speed of {most:g} m/s, got {speed:g} m/s")
    x0, y0, x1, y1 = region.bounds
    centre = ((x0 + x1) / 2, (y0 + y1) / 2)
    if kind == "uniform":
        angle = math.radians(values["wind_direction"])
        return Uniform((speed * math.cos(angle), speed * math.sin(angle)))
    if kind == "shear":
        return Shear(speed / ((y1 - y0) / 2), centre)
    return Rotation(speed / float(np.hypot(x1 - x0, y1 - y0) / 2), centre)
