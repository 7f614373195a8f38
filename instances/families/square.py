"""Families over a square, open country: tasks uniform, in clusters, or on a ring."""

from __future__ import annotations

import numpy as np

from instances.arrays import Floats
from instances.environment.region import Region
from instances.errors import InputError
from instances.families import depots, winds
from instances.families.family import Family
from instances.families.parameter import Parameter, Values

SIZE = Parameter("size", 20_000.0, "m", "side of the square, its lower left corner at the origin", at_least=1e-3)


def square(values: Values) -> Region:
    """Return the square [0, size]²."""
    return Region.rectangle(values["size"], values["size"])


def uniform_tasks(region: Region, count: int, rng: np.random.Generator, values: Values) -> Floats:
    """Return `count` points uniform in the region."""
    return region.sample(count, rng)


def clustered_tasks(region: Region, count: int, rng: np.random.Generator, values: Values) -> Floats:
    """Return `count` points, each normal around one of the centres, redrawn where outside the region."""
    centres = region.sample(values["clusters"], rng)
    home = centres[rng.integers(0, len(centres), count)]
    points = home + rng.normal(0.0, values["cluster_sd"], (count, 2))
    while (outside := ~region.contains(points)).any():
        points[outside] = home[outside] + rng.normal(0.0, values["cluster_sd"], (int(outside.sum()), 2))
    return points


def ring_tasks(region: Region, count: int, rng: np.random.Generator, values: Values) -> Floats:
    """Return `count` points uniform in the annulus of the given mean radius and width about the square's centre."""
    inner, outer = values["radius"] - values["width"] / 2, values["radius"] + values["width"] / 2
    if inner < 0 or outer > values["size"] / 2:
        raise InputError(
            f"family ring: radius ± width/2 must lie between 0 and size/2 = {values['size'] / 2:g} m, "
            f"got {inner:g} to {outer:g} m"
        )
    radius = np.sqrt(rng.uniform(inner**2, outer**2, count))
    angle = rng.uniform(0.0, 2 * np.pi, count)
    centre = values["size"] / 2
    return centre + np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


UNIFORM = Family("uniform", (SIZE, *winds.PARAMETERS, *depots.PARAMETERS), square, uniform_tasks)

CLUSTERED = Family(
    "clustered",
    (
        SIZE,
        Parameter("clusters", 5, "", "number of clusters", at_least=1),
        Parameter("cluster_sd", 1_000.0, "m", "standard deviation of a cluster, east and north", at_least=0.0),
        *winds.PARAMETERS,
        *depots.PARAMETERS,
    ),
    square,
    clustered_tasks,
)

RING = Family(
    "ring",
    (
        SIZE,
        Parameter("radius", 8_000.0, "m", "mean radius of the ring", at_least=0.0),
        Parameter("width", 2_000.0, "m", "width of the ring", at_least=0.0),
        *winds.PARAMETERS,
        *depots.PARAMETERS,
    ),
    square,
    ring_tasks,
)
