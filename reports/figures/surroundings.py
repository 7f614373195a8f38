"""Surroundings: the region and wind an instance was made in.

An instance made by a family states them in its provenance: under ``surroundings`` or, over open country and in old
files, under ``metric``, the same table its costs come from.
"""

from __future__ import annotations

from collections.abc import Mapping

from instances import InputError, Instance
from instances.environment.region import Region, single_polygon
from instances.environment.wind import WindField
from instances.environment.wind_table import wind_from_toml


def surroundings(instance: Instance) -> tuple[Region | None, WindField | None]:
    """Return the region (None: open country) and wind (None: calm or not stated) of `instance`."""
    stated = instance.provenance.get("surroundings", instance.provenance.get("metric"))
    if not isinstance(stated, Mapping):
        return None, None
    try:
        walls, wind = stated.get("region"), stated.get("wind")
        region = Region(single_polygon({"type": "Polygon", "coordinates": walls})) if walls else None
        return region, wind_from_toml(wind) if wind else None
    except InputError:
        return None, None
