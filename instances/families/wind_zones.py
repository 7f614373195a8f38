"""No-fly zones for generator families: irregular polygons that leave the region in one piece."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon

from instances.environment.region import Region
from instances.errors import InputError
from instances.families.parameter import Parameter, Values

PARAMETERS = (
    Parameter("zones", 5, "", "number of no-fly zones", at_least=0),
    Parameter("zone_radius", 2_000.0, "m", "largest distance of a zone's corners from its centre", at_least=1.0),
)
"""Parameters of families with no-fly zones."""

APART = 0.15
"""Least distance of zones from each other and from the border, as a fraction of their radius."""
TRIES = 2000


def no_fly_zones(region: Region, rng: np.random.Generator, values: Values) -> list[Polygon]:
    """Return the zones, each with four to seven corners; InputError where so many do not fit."""
    radius, zones = values["zone_radius"], list[Polygon]()
    border = region.polygon.exterior
    for _ in range(TRIES):
        if len(zones) == values["zones"]:
            return zones
        centre = region.sample(1, rng)[0]
        corners = rng.integers(4, 8)
        angle = 2 * np.pi * (np.arange(corners) + rng.uniform(-0.35, 0.35, corners)) / corners
        reach = radius * rng.uniform(0.5, 1.0, corners)
        zone = shapely.Polygon(centre + reach[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))
        inside = region.polygon.covers(zone) and zone.distance(border) > APART * radius
        if zone.is_valid and inside and all(zone.distance(other) > APART * radius for other in zones):
            zones.append(zone)
    raise InputError(f"zones: {values['zones']} no-fly zones of radius {radius:g} m do not fit into the region")
