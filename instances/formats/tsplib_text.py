"""Writing TSPLIB ``.tsp`` and ``.atsp``, LKH's ``.mtsp`` and VRPLIB's ``.vrp``.

* Nodes are numbered as these formats do, depots first: `formats.numbering`. UAVs that start at one place share a node.
* Costs that an EDGE_WEIGHT_TYPE of TSPLIB gives exactly are written as that and the coordinates, all others as a full
  matrix; in ``.vrp`` always, as readers of VRPLIB do not agree on whether EUC_2D is rounded.
* Weights are whole numbers, and programs that read these files rely on it. So: costs that are whole numbers up to
  2³¹ − 1 are written as they are and read back exactly. Others are multiplied by a power of ten, the largest that keeps
  the largest weight at most 10⁹, and rounded to nearest; COMMENT states it as ``cost [s] = weight / scale``, and our
  reader divides again. What is lost is at most half a unit, that is ½/scale seconds and 5·10⁻⁹ of the largest cost.
* ``.mtsp`` is for LKH-3: SALESMEN, and the parameter it wants, MTSP_OBJECTIVE, in the COMMENT. LKH-3 itself takes one
  depot. ``.vrp`` has demands of 1 and a CAPACITY of n, which bind nothing, as many solvers want some; where UAVs start
  at several places, VEHICLES_DEPOT_SECTION says at which, as PyVRP reads it.

What these formats have no place for is refused: costs by class of UAV, time or state, and limited endurance.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from instances.arrays import Floats
from instances.disk import write_aside
from instances.errors import InputError, naming
from instances.formats.edge_weights import type_of
from instances.formats.format import Format
from instances.formats.numbering import file_nodes, first_of_each
from instances.formats.tsplib import read_tsplib
from instances.instance import Instance
from instances.travel import AXES

FULL = {"EDGE_WEIGHT_TYPE": "EXPLICIT", "EDGE_WEIGHT_FORMAT": "FULL_MATRIX"}
NOTHING: Mapping[str, list[str]] = MappingProxyType({})
LARGEST = 10**9
"""Largest weight where costs are scaled: 32-bit programs can still add two of them."""


def write_tsp(instance: Instance, path: Path) -> None:
    """Write `instance` as TSPLIB TSP; InputError where its costs differ by direction."""
    with naming(path):
        if not _symmetric(instance):
            raise InputError("TSP has one cost for both directions, and those of this instance differ: write .atsp")
        keywords = {"TYPE": "TSP", **_weights(instance)}
        write_aside(path, _text(instance, keywords, "the longest tour is minimised", "VEHICLES"))


def write_atsp(instance: Instance, path: Path) -> None:
    """Write `instance` as TSPLIB ATSP, which is a full matrix."""
    with naming(path):
        keywords = {"TYPE": "ATSP", **FULL}
        write_aside(path, _text(instance, keywords, "the longest tour is minimised", "VEHICLES"))


def write_mtsp(instance: Instance, path: Path) -> None:
    """Write `instance` for LKH-3."""
    with naming(path):
        keywords = {"TYPE": "TSP", **_weights(instance)} if _symmetric(instance) else {"TYPE": "ATSP", **FULL}
        said = "run LKH-3 with SPECIAL and MTSP_OBJECTIVE = MINMAX"
        write_aside(path, _text(instance, keywords, said, "SALESMEN"))


def write_vrp(instance: Instance, path: Path) -> None:
    """Write `instance` for readers of VRPLIB."""
    with naming(path):
        nodes = file_nodes(instance)
        depots = nodes[instance.n_tasks :]
        several = len(set(depots)) > 1
        keywords = {"TYPE": "MDVRP" if several else "CVRP", "CAPACITY": str(instance.n_tasks), **FULL}
        said = "the longest route is minimised, CAPACITY does not bind"
        sections = {"DEMAND": [f"{node} {int(node not in depots)}" for node in sorted(set(nodes))]}
        if several:
            sections["VEHICLES_DEPOT"] = [f"{k} {node}" for k, node in enumerate(depots, 1)]
        write_aside(path, _text(instance, keywords, said, "VEHICLES", sections))


def weight_scale(instance: Instance) -> float:
    """Return the power of ten that makes the costs integers, 1 where they are integers already."""
    largest = float(instance.cost.max())
    if largest < 2**31 and not (instance.cost % 1).any():
        return 1.0
    exponent = min(math.floor(math.log10(LARGEST) - math.log10(largest)), 300)
    return float(10**exponent) if exponent >= 0 else 1 / float(10**-exponent)


def _symmetric(instance: Instance) -> bool:
    if instance.by_metric is not None:
        return instance.by_metric.symmetric
    return bool((instance.cost == instance.cost.T).all())


def _weights(instance: Instance) -> dict[str, str]:
    """Return the keywords of a type that gives the costs exactly, or of a full matrix."""
    kind = type_of(instance)
    return {"EDGE_WEIGHT_TYPE": kind} if kind else FULL


def _text(
    instance: Instance, keywords: Mapping[str, str], said: str, uavs: str, more: Mapping[str, list[str]] = NOTHING
) -> str:
    """Return the file.

    said : what the COMMENT begins with. uavs : the keyword for their number. more : sections.
    """
    if instance.axes - {"metric"}:
        has = " and ".join(AXES[axis] for axis in AXES if axis in instance.axes)
        raise InputError(f"these files have no place for {has}: write .json")
    nodes = file_nodes(instance)
    ours = first_of_each(nodes)
    explicit = keywords["EDGE_WEIGHT_TYPE"] == "EXPLICIT"
    if explicit and instance.by_metric is not None:
        raise InputError(f"this file would hold a matrix of {instance.n_nodes}² numbers: write .json")
    scale = weight_scale(instance) if explicit else 1.0
    unit = "cost [s] = weight" if scale == 1 else f"cost [s] = weight / {scale:g}"
    # tsplib95 takes what it does not know for more of the line before: that of the COMMENT does no harm
    specs = {"NAME": instance.name, "DIMENSION": str(len(ours)), **keywords}
    sections = {}
    if explicit:
        sections["EDGE_WEIGHT"] = _weight_lines(instance.cost[np.ix_(ours, ours)], scale)
    if instance.coordinates is not None:
        # weights and NODE_COORD_SECTION together are for VRPLIB only: LKH and TSPLIB have them to be displayed
        as_nodes = not explicit or "CAPACITY" in keywords
        specs |= {"NODE_COORD_TYPE": "TWOD_COORDS"} if as_nodes else {"DISPLAY_DATA_TYPE": "TWOD_DISPLAY"}
        sections["NODE_COORD" if as_nodes else "DISPLAY_DATA"] = _coordinate_lines(instance.coordinates[ours])
    specs |= {"COMMENT": f"{said}; {unit}; digest {instance.digest}", uavs: str(instance.n_depots)}
    depots = dict.fromkeys(nodes[instance.n_tasks :])
    sections |= {**more, "DEPOT": [*map(str, depots), "-1"]}
    lines = [f"{key} : {value}" for key, value in specs.items()]
    for name, content in sections.items():
        lines += [f"{name}_SECTION", *content]
    return "\n".join([*lines, "EOF"]) + "\n"


def _coordinate_lines(coordinates: Floats) -> list[str]:
    return [f"{node} {x!r} {y!r}" for node, (x, y) in enumerate(coordinates.tolist(), 1)]


def _weight_lines(cost: Floats, scale: float) -> list[str]:
    # a negative power of ten is no exact float: divide by its exact inverse instead
    scaled = cost * scale if scale >= 1 else cost / round(1 / scale)
    return [" ".join(map(str, row)) for row in np.rint(scaled).astype(np.int64).tolist()]


TSP = Format(read_tsplib, write_tsp)
ATSP = Format(read_tsplib, write_atsp)
MTSP = Format(read_tsplib, write_mtsp)
VRP = Format(read_tsplib, write_vrp)
