"""The depots option of every family: spread over the region, clustered at one site, or shared by all UAVs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from instances.arrays import Floats
from instances.environment.region import Region
from instances.families.parameter import Parameter, Values

PARAMETERS = (Parameter("depots", "spread", "", "where the UAVs start", ("spread", "clustered", "shared")),)
"""Parameters every family has."""

CANDIDATES = 32
"""Random points drawn per spread depot."""

SITE = 0.05
"""Radius of the site of clustered depots, as a fraction of the region's diameter."""


def place_depots(region: Region, count: int, rng: np.random.Generator, values: Values) -> Floats:
    """Return `count` depots in the region, shape (count, 2) [m]."""
    if values["depots"] == "spread":
        return _far_apart(region.sample(CANDIDATES * count, rng), count)
    site = region.sample(1, rng)
    if values["depots"] == "shared":
        return np.repeat(site, count, axis=0)
    x0, y0, x1, y1 = region.bounds
    radius = SITE * float(np.hypot(x1 - x0, y1 - y0))
    return _inside(region, lambda size: site + radius * _disc(size, rng), count)


def _far_apart(candidates: Floats, count: int) -> Floats:
    """Return `count` of the candidates, each the farthest from those before it (Gonzalez 1985)."""
    chosen = [0]
    distance = np.full(len(candidates), np.inf)
    while len(chosen) < count:
        distance = np.minimum(distance, ((candidates - candidates[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(distance.argmax()))
    return candidates[chosen]


def _inside(region: Region, draw: Callable[[int], Floats], count: int) -> Floats:
    """Return `count` drawn points, those outside the region drawn again."""
    points = draw(count)
    while (outside := ~region.contains(points)).any():
        points[outside] = draw(int(outside.sum()))
    return points


def _disc(size: int, rng: np.random.Generator) -> Floats:
    radius, angle = np.sqrt(rng.uniform(0, 1, size)), rng.uniform(0, 2 * np.pi, size)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
