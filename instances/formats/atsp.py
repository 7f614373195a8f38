"""Instances written as TSPLIB ATSP, full matrix, with VEHICLES and DEPOT_SECTION as in VRPLIB and LKH-3.

TSPLIB weights are integers, and programs that read these files rely on it. So: costs that are whole numbers up to
2³¹ − 1 are written as they are and read back exactly. Others are multiplied by a power of ten, the largest that keeps
the largest weight at most 10⁹, and rounded to nearest; COMMENT states it as ``cost [s] = weight / scale``, and our
reader divides again. What is lost is at most half a unit, that is ½/scale seconds and 5·10⁻⁹ of the largest cost.
(JSON loses nothing.) Node numbers are ours plus one: tasks 1..n, depots n+1..n+m. Coordinates go to
DISPLAY_DATA_SECTION.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from instances.disk import write_aside
from instances.formats.format import Format
from instances.formats.tsplib import read_tsplib
from instances.instance import Instance

LARGEST = 10**9
"""Largest weight where costs are scaled: 32-bit programs can still add two of them."""


def write_atsp(instance: Instance, path: Path) -> None:
    """Write `instance` as TSPLIB ATSP; see the top of the file for what rounding loses."""
    scale = weight_scale(instance)
    # a negative power of ten is no exact float: divide by its exact inverse instead
    scaled = instance.cost * scale if scale >= 1 else instance.cost / round(1 / scale)
    weights = np.rint(scaled).astype(np.int64)
    unit = "cost [s] = weight" if scale == 1 else f"cost [s] = weight / {scale:g}"
    lines = [
        f"NAME : {instance.name}",
        f"COMMENT : min-max multi-depot TSP, {unit}; digest {instance.digest}",
        "TYPE : ATSP",
        f"DIMENSION : {instance.n_nodes}",
        f"VEHICLES : {instance.n_depots}",
        "EDGE_WEIGHT_TYPE : EXPLICIT",
        "EDGE_WEIGHT_FORMAT : FULL_MATRIX",
    ]
    if instance.coordinates is not None:
        lines.append("DISPLAY_DATA_TYPE : TWOD_DISPLAY")
    lines.append("EDGE_WEIGHT_SECTION")
    lines += [" ".join(map(str, row)) for row in weights.tolist()]
    if instance.coordinates is not None:
        lines.append("DISPLAY_DATA_SECTION")
        lines += [f"{i} {x!r} {y!r}" for i, (x, y) in enumerate(instance.coordinates.tolist(), 1)]
    lines.append("DEPOT_SECTION")
    lines += [str(depot + 1) for depot in instance.depots]
    write_aside(path, "\n".join([*lines, "-1", "EOF"]) + "\n")


def weight_scale(instance: Instance) -> float:
    """Return the power of ten that makes the costs integers, 1 where they are integers already."""
    largest = float(instance.cost.max())
    if largest < 2**31 and not (instance.cost % 1).any():
        return 1.0
    exponent = min(math.floor(math.log10(LARGEST) - math.log10(largest)), 300)
    return float(10**exponent) if exponent >= 0 else 1 / float(10**-exponent)


ATSP = Format(read_tsplib, write_atsp)
