"""The file metric `wind`: moving costs in winds whose vorticity is the same everywhere, over the open plane.

    C = τ·g(κd/2) − (1/v0²) ∫_chord w·dσ,   τ = d/v0,   κ = |curl w|/v0,   g(s) = (asin(s)/s + √(1 − s²))/2,   g(0) = 1

for nodes at a distance d. Why this is C(σ) of the cheapest path is derived in `formulations.moving_cost.closed_form`,
which uses it. It is computed here because it is what the cost of an instance file means where the file names this
metric, and files are read without formulations.

Valid where |w| < v0 (otherwise the cost is no metric: Randers) and κd/2 ≤ 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.wind import Rotation, Shear, Uniform, WindField
from instances.environment.wind_table import Sum
from instances.errors import InputError
from instances.moving_cost import moving_cost

BLOCK = 2_000_000
"""Pairs computed at a time: bounds the memory beside the matrix itself."""


def wind_metric(v0: float, wind: WindField | None) -> dict[str, Any]:
    """Return the metric as it stands in an instance file, where the ground speed v0 [m/s] has its old key."""
    return {"metric": "wind", "airspeed": v0, "wind": None if wind is None else wind.to_toml()}


def vorticity(wind: WindField | None) -> float:
    """Return the constant curl [1/s] of `wind`; InputError where it has none in closed form."""
    match wind:
        case None | Uniform():
            return 0.0
        case Rotation():
            return 2.0 * wind.rate
        case Shear():
            return -wind.rate
        case Sum():
            return sum(vorticity(part) for part in wind.parts)
    raise InputError(f"wind: there is no closed form for a {type(wind).__name__}, only for uniform, shear and rotation")


def pair_costs(a: ArrayLike, b: ArrayLike, v0: float, wind: WindField | None) -> Floats:
    """Return the cost [s] of the cheapest path a → b over open country, shape (k,), for `a`, `b` (k, 2) [m].

    InputError where a pair is too far apart for its arc: κd/2 > 1.
    """
    p, q = np.asarray(a, dtype=float).reshape(-1, 2), np.asarray(b, dtype=float).reshape(-1, 2)
    d = np.sqrt(((q - p) ** 2).sum(axis=1))
    tau = d / v0
    curl = vorticity(wind)
    if curl:
        s = (0.5 * abs(curl) / v0) * d
        if s.size and not s.max() <= 1.0:
            raise InputError(
                f"wind: its vorticity of {curl:g} 1/s is too strong for points {d.max():g} m apart at a ground speed "
                f"of {v0:g} m/s: at most {2 * v0 / abs(curl):g} m"
            )
        arc_over_chord = np.divide(np.arcsin(s), s, out=np.ones_like(s), where=s > 0)
        tau *= 0.5 * (arc_over_chord + np.sqrt(1.0 - s * s))
    return tau if wind is None else moving_cost(tau, wind.line_integral(p, q), v0)


def cost_matrix(points: ArrayLike, v0: float, wind: WindField | None) -> Floats:
    """Return ``cost[i, j]`` [s], shape (k, k), of the cheapest paths between `points` (k, 2) [m] over open country.

    Raises InputError where the wind reaches the ground speed on an arc or among the points, and where there is no arc.
    """
    p = np.asarray(points, dtype=float).reshape(-1, 2)
    check_wind(p, v0, wind)
    k = len(p)
    cost = np.empty((k, k))
    step = max(1, BLOCK // k)
    for i in range(0, k, step):
        rows = p[i : i + step]
        cost[i : i + step] = pair_costs(np.repeat(rows, k, axis=0), np.tile(p, (len(rows), 1)), v0, wind).reshape(
            len(rows), k
        )
    np.fill_diagonal(cost, 0.0)
    return cost


def check_wind(points: Floats, v0: float, wind: WindField | None) -> None:
    """Raise InputError where `wind` may reach the ground speed in the bounding box of `points`, or where an arc bulges.

    |w| is convex for a linear field, so its corners decide for the box.
    """
    if wind is None:
        return
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    fastest = float(np.linalg.norm(wind([(x0, y0), (x0, y1), (x1, y0), (x1, y1)]), axis=1).max())
    curl = vorticity(wind)
    if curl:
        radius = v0 / abs(curl)
        half = min(float(np.hypot(x1 - x0, y1 - y0)) / 2, radius)
        bulge = radius - np.sqrt(radius**2 - half**2)
        fastest += _gradient(wind) * float(bulge)
    if not fastest < v0:
        raise InputError(
            f"wind: it reaches {fastest:g} m/s where legs may lead, but must stay below the ground speed {v0:g} m/s"
        )


def _gradient(wind: WindField) -> float:
    """Return how fast |w| can grow with distance at most [1/s]."""
    match wind:
        case Rotation() | Shear():
            return abs(wind.rate)
        case Sum():
            return sum(_gradient(part) for part in wind.parts)
    return 0.0
