"""Surroundings: the region and wind an instance was made in, and the legs as they are flown around walls.

An instance made by a family keeps both in its provenance, under ``metric``: the same figures its costs come from.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from instances import InputError, Instance
from instances.arrays import Floats
from instances.environment.corner_paths import corner_path_costs, turning_corners
from instances.environment.region import Region, single_polygon
from instances.environment.wind import WindField, wind_from_toml


def surroundings(instance: Instance) -> tuple[Region | None, WindField | None]:
    """Return the region (None: open country) and wind (None: calm or not stated) of `instance`."""
    metric = instance.provenance.get("metric")
    if not isinstance(metric, Mapping):
        return None, None
    try:
        walls, wind = metric.get("region"), metric.get("wind")
        region = Region(single_polygon({"type": "Polygon", "coordinates": walls})) if walls else None
        return region, wind_from_toml(wind) if wind else None
    except InputError:
        return None, None


def flown(instance: Instance, stops: Sequence[int], region: Region | None) -> list[Floats]:
    """Return each leg between the nodes `stops` as a polyline (k, 2) [m]: straight, or bent around corners.

    A leg bends at those corners that lie on its cheapest way: c with cost(a, c) + cost(c, b) = cost(a, b).
    """
    assert instance.coordinates is not None
    ends = instance.coordinates[list(stops)]
    metric = instance.provenance.get("metric")
    if region is None or not isinstance(metric, Mapping) or "airspeed" not in metric:
        return [ends[i : i + 2] for i in range(len(ends) - 1)]
    points = np.concatenate([ends, turning_corners(region)])
    wind = wind_from_toml(metric["wind"]) if metric.get("wind") else None
    cost = corner_path_costs(points, region, float(metric["airspeed"]), wind)
    corners = np.arange(len(ends), len(points))
    legs = []
    for i in range(len(ends) - 1):
        on_the_way = np.isclose(cost[i, corners] + cost[corners, i + 1], cost[i, i + 1], rtol=1e-9, atol=0)
        via = corners[on_the_way]
        legs.append(points[[i, *via[np.argsort(cost[i, via], kind="stable")], i + 1]])
    return legs
