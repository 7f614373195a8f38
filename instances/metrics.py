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
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from instances.arrays import Floats
from instances.declared.instance import (
    AttTable,
    EuclideanTable,
    GeoTable,
    ManhattanTable,
    MaximumTable,
    Metric,
    WindMetricTable,
)
from instances.declared.reading import read_declared
from instances.environment.wind import WindField
from instances.environment.wind_table import wind_of
from instances.errors import InputError
from instances.wind_metric import BLOCK, cost_matrix, pair_costs

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
    said = declared_metric(metric)
    if coordinates is None:
        raise InputError(f"cost: the metric '{metric['metric']}' needs coordinates")
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused by Instance, by its entry
        if isinstance(said, GeoTable):
            return _geo(coordinates)
        return _wind(coordinates, said) if isinstance(said, WindMetricTable) else _matrix(said, coordinates)


def declared_metric(metric: Mapping[str, Any]) -> Metric:
    """Return a metric as it is declared; InputError names the key and the value."""
    said: Any = read_declared(Metric, metric, at=["cost"], toml=False)  # type: ignore[arg-type]  # a union
    return said


def pairs_by(said: Metric) -> Callable[[Floats, Floats], Floats] | None:
    """Return the function that gives the costs [s] of pairs of points (…, 2) [m], which broadcast.

    None for metrics that only give a matrix: on the Earth, and around walls.
    """
    if isinstance(said, WindMetricTable):
        if said.region is not None:
            return None
        v0, wind = said.airspeed, None if said.wind is None else wind_of(said.wind, Path())
        return lambda a, b: _wind_between(a, b, v0, wind)
    function = BETWEEN.get(type(said))
    return None if function is None else partial(_between, function, said)


def _between(function: Callable[[Floats, Any], Floats], said: Metric, a: Floats, b: Floats) -> Floats:
    return function(b - a, said)


def _wind_between(a: Floats, b: Floats, v0: float, wind: WindField | None) -> Floats:
    a, b = np.broadcast_arrays(a, b)
    return pair_costs(a.reshape(-1, 2), b.reshape(-1, 2), v0, wind).reshape(a.shape[:-1])


def _matrix(said: Metric, points: Floats) -> Floats:
    """Return the matrix a metric of `BETWEEN` gives, a block of rows at a time; symmetric to the last bit."""
    k, function = len(points), BETWEEN[type(said)]
    cost = np.empty((k, k))
    step = max(1, BLOCK // k)
    for i in range(0, k, step):
        cost[i : i + step] = function(points[i : i + step, None] - points, said)
    return cost


def distances(points: Floats) -> Floats:
    """Return |x_j − x_i|, shape (k, k), of `points` (k, 2), or (k, 3); symmetric to the last bit."""
    squared = np.subtract.outer(points[:, 0], points[:, 0])
    np.multiply(squared, squared, out=squared)
    for axis in points.T[1:]:
        along = np.subtract.outer(axis, axis)
        np.multiply(along, along, out=along)
        squared += along
    return np.sqrt(squared, out=squared)


def _lengths(apart: Floats) -> Floats:
    """Return the lengths of vectors (…, 2), or (…, 3), added up axis by axis as `distances` does."""
    squared = apart[..., 0] ** 2
    for axis in range(1, apart.shape[-1]):
        squared += apart[..., axis] ** 2
    return np.sqrt(squared)


def _euclidean(apart: Floats, said: EuclideanTable) -> Floats:
    return ROUNDINGS[said.rounding](_lengths(apart) / said.speed)


def _att(apart: Floats, said: AttTable) -> Floats:
    r = _lengths(apart) / np.sqrt(10.0)
    t = np.floor(r + 0.5)
    return np.where(t < r, t + 1.0, t)


def _manhattan(apart: Floats, said: ManhattanTable) -> Floats:
    return ROUNDINGS[said.rounding](np.abs(apart).sum(axis=-1))


def _maximum(apart: Floats, said: MaximumTable) -> Floats:
    return ROUNDINGS[said.rounding](np.abs(apart).max(axis=-1))


BETWEEN: dict[type, Callable[[Floats, Any], Floats]] = {
    EuclideanTable: _euclidean,
    ManhattanTable: _manhattan,
    MaximumTable: _maximum,
    AttTable: _att,
}
"""Metric, as declared → its function of x_j − x_i, shape (…, 2) or (…, 3) [m]; all are symmetric."""


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


def _wind(points: Floats, said: WindMetricTable) -> Floats:
    v0, field = said.airspeed, None if said.wind is None else wind_of(said.wind, Path())
    if said.region is None:
        return cost_matrix(points, v0, field)
    # here, not above: shapely takes its time, and few files need it
    from instances.environment.region import Region, single_polygon
    from instances.old_corridor_metric import old_corridor_costs

    return old_corridor_costs(
        points, Region(single_polygon({"type": "Polygon", "coordinates": said.region})), v0, field
    )
