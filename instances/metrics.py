"""Costs named by a metric on the coordinates, where storing (n+m)² numbers would be waste.

A metric is a small dictionary, as it stands in an instance file's `cost`:

* ``{"metric": "euclidean", "speed": v, "rounding": r}``: c_ij = r(|x_j − x_i| / v) with speed v [m/s], 1 if left
  out, and r one of ``none`` (if left out), ``nearest`` (TSPLIB EUC_2D), ``up`` (CEIL_2D), ``down`` (FLOOR_2D);
* ``{"metric": "manhattan", "rounding": r}`` and ``"maximum"``: Σ |x_j − x_i| and max |x_j − x_i| (MAN_2D, MAX_2D);
* ``{"metric": "att"}``: TSPLIB's pseudo-Euclidean distance;
* ``{"metric": "geo"}``: TSPLIB's distance [km] on a sphere, coordinates latitude and longitude as DDD.MM;
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

PI, RRR = 3.141592, 6378.388
"""TSPLIB's π and its radius of the Earth [km]."""


def metric_cost(metric: Mapping[str, Any], coordinates: Floats | None) -> Floats:
    """Return ``cost[i, j]`` [s], shape (k, k), of `metric` on `coordinates` (k, 2) [m]; else InputError.

    Metrics that are sums or maxima over axes take (k, 3) as well.
    """
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
    """Return |x_j − x_i|, shape (k, k), of `points` (k, 2), or (k, 3); symmetric to the last bit."""
    squared = np.subtract.outer(points[:, 0], points[:, 0])
    np.multiply(squared, squared, out=squared)
    for axis in points.T[1:]:
        along = np.subtract.outer(axis, axis)
        np.multiply(along, along, out=along)
        squared += along
    return np.sqrt(squared, out=squared)


def _rounded(d: Floats, rounding: Any) -> Floats:
    if not isinstance(rounding, str) or rounding not in ROUNDINGS:
        raise InputError(f"cost: unknown rounding {shown(rounding)} (known: {', '.join(ROUNDINGS)})")
    return ROUNDINGS[rounding](d)


def _euclidean(points: Floats, speed: Any = 1.0, rounding: Any = "none") -> Floats:
    d = distances(points)
    d /= positive(speed, "cost: speed")
    return _rounded(d, rounding)


def _att(points: Floats) -> Floats:
    r = distances(points)
    r /= np.sqrt(10.0)
    t = np.floor(r + 0.5)
    return np.where(t < r, t + 1.0, t)


def _manhattan(points: Floats, rounding: Any = "none") -> Floats:
    return _rounded(sum(_apart(points), np.zeros((len(points), len(points)))), rounding)


def _maximum(points: Floats, rounding: Any = "none") -> Floats:
    return _rounded(np.maximum.reduce(_apart(points)), rounding)


def _apart(points: Floats) -> list[Floats]:
    """Return |x_j − x_i| along each axis, (k, k) each."""
    return [np.abs(np.subtract.outer(axis, axis)) for axis in points.T]


def _geo(points: Floats) -> Floats:
    """TSPLIB's GEO, with its own π and radius [km]; published optima hold with degrees cut off, not rounded."""
    degrees = np.trunc(points)
    latitude, longitude = (PI * (degrees + 5.0 * (points - degrees) / 3.0) / 180.0).T
    q1 = np.cos(np.subtract.outer(longitude, longitude))
    q2 = np.cos(np.subtract.outer(latitude, latitude))
    q3 = np.cos(np.add.outer(latitude, latitude))
    d = np.floor(RRR * np.arccos(np.clip(0.5 * ((1.0 + q1) * q2 - (1.0 - q1) * q3), -1.0, 1.0)) + 1.0)
    np.fill_diagonal(d, 0.0)
    return d


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
    "manhattan": (_manhattan, ("rounding",)),
    "maximum": (_maximum, ("rounding",)),
    "att": (_att, ()),
    "geo": (_geo, ()),
    "wind": (_wind, ("airspeed", "wind", "region")),
}
"""Name of a metric → its function of the coordinates and the keys that parametrise it."""
