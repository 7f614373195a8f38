"""Costs named by a metric on the coordinates, where storing (n+m)² numbers would be waste.

A metric is a small dictionary, as it stands in an instance file's `cost`:

* ``{"metric": "euclidean", "speed": v, "rounding": r}``: c_ij = r(|x_j − x_i| / v) with speed v [m/s], 1 if left
  out, and r one of ``none`` (if left out), ``nearest`` (TSPLIB EUC_2D), ``up`` (CEIL_2D), ``down`` (FLOOR_2D);
* ``{"metric": "att"}``: TSPLIB's pseudo-Euclidean distance;
* ``{"metric": "wind", "airspeed": v0, "wind": {...}}``: the moving cost in a wind of constant vorticity over open
  country, `instances.wind_metric`; in old files with a ``"region"``, `instances.old_corridor_metric`.

Source of the TSPLIB roundings: G. Reinelt, TSPLIB 95, 1995, §2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from instances.arrays import Floats
from instances.environment.wind_table import wind_from_toml
from instances.errors import InputError, shown, suggestion
from instances.extent import positive
from instances.wind_metric import cost_matrix

ROUNDINGS: dict[str, Callable[[Floats], Floats]] = {
    "none": lambda d: d,
    "nearest": lambda d: np.floor(d + 0.5),
    "up": np.ceil,
    "down": np.floor,
}
"""Name of a rounding → what it does to the distances."""


def metric_cost(metric: Mapping[str, Any], coordinates: Floats | None) -> Floats:
    """Return ``cost[i, j]`` [s], shape (k, k), of `metric` on `coordinates` (k, 2) [m]; else InputError."""
    name = metric.get("metric")
    if not isinstance(name, str) or name not in METRICS:
        near = suggestion(name, METRICS) if isinstance(name, str) else ""
        raise InputError(f"cost: unknown metric {shown(name)}{near} (known: {', '.join(METRICS)})")
    if coordinates is None:
        raise InputError(f"cost: the metric '{name}' needs coordinates")
    compute, keys = METRICS[name]
    for key in metric:
        if key not in ("metric", *keys):
            raise InputError(f"cost: unknown key {shown(key)} of the metric '{name}'{suggestion(str(key), keys)}")
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused by Instance, by its entry
        return compute(coordinates, **{key: metric[key] for key in keys if key in metric})


def distances(points: Floats) -> Floats:
    """Return |x_j − x_i|, shape (k, k), of `points` (k, 2); symmetric to the last bit."""
    squared = np.subtract.outer(points[:, 0], points[:, 0])
    np.multiply(squared, squared, out=squared)
    dy = np.subtract.outer(points[:, 1], points[:, 1])
    np.multiply(dy, dy, out=dy)
    squared += dy
    return np.sqrt(squared, out=squared)


def _euclidean(points: Floats, speed: Any = 1.0, rounding: Any = "none") -> Floats:
    if not isinstance(rounding, str) or rounding not in ROUNDINGS:
        raise InputError(f"cost: unknown rounding {shown(rounding)} (known: {', '.join(ROUNDINGS)})")
    d = distances(points)
    d /= positive(speed, "cost: speed")
    return ROUNDINGS[rounding](d)


def _att(points: Floats) -> Floats:
    r = distances(points)
    r /= np.sqrt(10.0)
    t = np.floor(r + 0.5)
    return np.where(t < r, t + 1.0, t)


def _wind(points: Floats, airspeed: Any = None, wind: Any = None, region: Any = None) -> Floats:
    v0 = positive(airspeed, "cost: airspeed")
    if wind is not None and not isinstance(wind, Mapping):
        raise InputError(f"cost: wind must be a table or null, got {shown(wind)}")
    field = None if wind is None else wind_from_toml(wind)
    if region is None:
        return cost_matrix(points, v0, field)
    # here, not above: shapely takes its time, and few files need it
    from instances.environment.region import Region, single_polygon
    from instances.old_corridor_metric import old_corridor_costs

    return old_corridor_costs(points, Region(single_polygon({"type": "Polygon", "coordinates": region})), v0, field)


METRICS: dict[str, tuple[Callable[..., Floats], tuple[str, ...]]] = {
    "euclidean": (_euclidean, ("speed", "rounding")),
    "att": (_att, ()),
    "wind": (_wind, ("airspeed", "wind", "region")),
}
"""Name of a metric → its function of the coordinates and the keys that parametrise it."""
