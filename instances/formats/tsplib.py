"""Reading TSPLIB and its relatives: ``.tsp .atsp``, LKH's ``.mtsp``, VRPLIB's ``.vrp``, and ``.mdm`` (min-max).

* What they say of UAVs and depots is read by `formats.depots`. ``provenance["nodes"]`` maps our node numbers to the
  file's (1-based), so that tours in the file's numbering can be evaluated.
* Weights are taken as seconds; the diagonal, which TSPLIB leaves open, becomes 0. Capacity, demand, time windows, fixed
  edges and the like have no place in the min-max problem and are left out; ``provenance["ignored"]`` lists them, and a
  notice is logged unless they bind nothing: demands that add up to no more than one CAPACITY.

vrplib reads keywords and coordinates. Depot counts and weights that wrap over lines are beyond it (version 1.5/2.0),
and so are TSPLIB's roundings; these are read here.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import vrplib

from instances.arrays import Floats, Ints
from instances.disk import read_text
from instances.errors import LONGEST_SENTENCE, LONGEST_VALUE, InputError, naming, one_line, shown
from instances.formats.depots import nodes_of, whole_number
from instances.formats.edge_weights import explicit_weights, metric_of
from instances.formats.format import Format
from instances.instance import Instance, check_size
from instances.metric_costs import MATRIX_NODES
from instances.metrics import metric_cost

KEYWORDS = frozenset({"NAME", "TYPE", "COMMENT", "DIMENSION", "VEHICLES", "SALESMEN", "DEPOT", "EDGE_WEIGHT_TYPE"}) | {
    "EDGE_WEIGHT_FORMAT",
    "NODE_COORD_TYPE",
    "DISPLAY_DATA_TYPE",
}
"""Keywords that are understood."""

SECTIONS = frozenset({"NODE_COORD", "EDGE_WEIGHT", "DEPOT", "VEHICLES_DEPOT", "DISPLAY_DATA"})
"""Sections that are understood."""

SCALE = re.compile(r"cost \[s\] = weight / ([0-9.e+-]+)")
"""What our own files say in their COMMENT about integer weights (`formats.tsplib_text`)."""


def read_tsplib(path: Path) -> Instance:
    """Read a file of the TSPLIB kind; InputError names the file, the field and the value that cannot be used."""
    text = read_text(path)
    with naming(path):
        specs, sections = _split(text)
        size = whole_number(specs, "DIMENSION")
        if size is None:
            raise InputError("the keyword DIMENSION is missing")
        nodes, n_depots = nodes_of(specs, sections, size)
        place = np.array(nodes) - 1
        coordinates = _coordinates(specs, sections, size)
        if coordinates is not None:
            coordinates = coordinates[place]
        provenance: dict[str, Any] = {"source": path.name, "nodes": nodes}
        for key in ("TYPE", "COMMENT"):
            if key in specs:
                provenance[key.lower()] = specs[key]
        ignored = sorted((specs.keys() - KEYWORDS) | {f"{s}_SECTION" for s in sections.keys() - SECTIONS})
        metric = _metric(specs, sections, coordinates)
        large = len(nodes) > MATRIX_NODES
        spatial = specs.get("EDGE_WEIGHT_TYPE", "").endswith("3D")
        if metric is None or spatial:
            check_size(len(nodes) - n_depots, n_depots)
        else:
            provenance["metric"] = metric
        at = coordinates if coordinates is None or spatial else coordinates[:, :2]
        cost = None if large else _cost(specs, sections, size, place, at, metric)
        if coordinates is not None and coordinates.shape[1] == 3:
            coordinates = coordinates[:, :2]
            ignored.append("the third coordinate (a cost may count it)")
        if ignored:
            provenance["ignored"] = ignored
        name = specs.get("NAME", "") or path.name.split(".")[0]
        n_tasks = len(nodes) - n_depots
        if cost is not None:
            instance = Instance(name, cost, n_tasks, n_depots, coordinates, provenance)
        else:
            assert metric is not None
            assert coordinates is not None
            instance = Instance.of_metric(name, metric, coordinates, n_tasks, n_depots, provenance=provenance)
        _tell_left_out(path, ignored, specs, sections)
        return instance


def _tell_left_out(path: Path, ignored: list[str], specs: Mapping[str, str], sections: Mapping[str, list[str]]) -> None:
    """Log a notice of what the file says beyond the min-max problem, save demands that bind nothing."""
    free = {"CAPACITY", "DEMAND_SECTION"} if _fits_all(specs, sections) else set()
    told = [one_line(each, LONGEST_VALUE) for each in ignored if each not in free]
    if told:
        words = f"{path}: left out, as the min-max problem has no place for it: {', '.join(told)}"
        logging.getLogger(__name__).warning(one_line(words, LONGEST_SENTENCE))


def _fits_all(specs: Mapping[str, str], sections: Mapping[str, list[str]]) -> bool:
    """Return whether one vehicle of CAPACITY can carry all demands: then they forbid no routes."""
    try:
        total = sum(float(line.split()[1]) for line in sections.get("DEMAND", ()))
        return total <= float(specs["CAPACITY"])
    except (KeyError, IndexError, ValueError):
        return False


def _split(text: str) -> tuple[dict[str, str], dict[str, list[str]]]:
    """Return keyword → value and section → lines; both without ``_SECTION``, in upper case."""
    specs: dict[str, str] = {}
    sections: dict[str, list[str]] = {}
    current: list[str] | None = None
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.strip()
        if not line or line.startswith("#"):
            continue
        if line.upper() == "EOF":
            break
        head = line.rstrip(" :").upper()
        if re.fullmatch(r"[A-Z_]+_SECTION", head):
            name = head.removesuffix("_SECTION")
            if name in sections:
                raise InputError(f"line {number}: {head} is given twice")
            current = sections[name] = []
        elif re.match(r"[A-Za-z_]+\s*:", line):
            key, value = (part.strip() for part in line.split(":", 1))
            if key.upper() in specs and key.upper() != "COMMENT":
                raise InputError(f"line {number}: {key.upper()} is given twice")
            specs[key.upper()] = f"{specs[key.upper()]} {value}" if key.upper() in specs else value
            current = None
        elif current is not None:
            current.append(line)
        else:
            raise InputError(f"line {number} is neither 'KEYWORD : value' nor part of a section: {shown(line)}")
    return specs, sections


def _coordinates(specs: Mapping[str, str], sections: Mapping[str, list[str]], size: int) -> Floats | None:
    """Return the coordinates (size, 2), or (size, 3), in file order, None where the file has none."""
    name = "NODE_COORD" if "NODE_COORD" in sections else "DISPLAY_DATA"
    if name not in sections:
        return None
    lines = sections[name]
    solid = specs.get("EDGE_WEIGHT_TYPE", "").endswith("3D") or specs.get("NODE_COORD_TYPE") == "THREED_COORDS"
    spatial = name == "NODE_COORD" and solid
    axes = ["x", "y", "z"] if spatial else ["x", "y"]
    if len(lines) != size:
        raise InputError(f"{name}_SECTION has {len(lines)} lines, must have DIMENSION = {size}")
    for number, line in enumerate(lines, 1):
        words = line.split()
        if len(words) != 1 + len(axes):
            raise InputError(f"{name}_SECTION must hold 'node {' '.join(axes)}', got {shown(line)}")
        if words[0] != str(number):
            raise InputError(
                f"{name}_SECTION must list the nodes 1 to {size} in order, got {shown(words[0])} as {number}"
            )
    try:  # vrplib takes a line with a colon for a specification and refuses it
        parsed = vrplib.parse.parse_vrplib(f"{name}_SECTION\n" + "\n".join(lines) + "\nEOF", compute_edge_weights=False)
        xy = np.array(parsed[name.lower()], dtype=np.float64).reshape(size, len(axes))
    except (ValueError, OverflowError):
        raise InputError(f"{name}_SECTION holds something that is not a number") from None
    if not np.isfinite(xy).all():
        raise InputError(f"{name}_SECTION: node {int(np.argwhere(~np.isfinite(xy))[0][0]) + 1} is not finite")
    return xy


def _metric(
    specs: Mapping[str, str], sections: Mapping[str, list[str]], coordinates: Floats | None
) -> dict[str, Any] | None:
    """Return the metric of a file's EDGE_WEIGHT_TYPE, None where weights are EXPLICIT."""
    kind = specs.get("EDGE_WEIGHT_TYPE", "EXPLICIT" if "EDGE_WEIGHT" in sections else None)
    if kind is None:
        raise InputError("the keyword EDGE_WEIGHT_TYPE is missing")
    if kind == "EXPLICIT":
        return None
    metric = metric_of(kind)
    if coordinates is None or "NODE_COORD" not in sections:
        raise InputError(f"EDGE_WEIGHT_TYPE {kind} needs a NODE_COORD_SECTION")
    return metric


def _cost(
    specs: Mapping[str, str],
    sections: Mapping[str, list[str]],
    size: int,
    place: Ints,
    coordinates: Floats | None,
    metric: Mapping[str, Any] | None,
) -> Floats:
    """Return the cost matrix in our node order."""
    if metric is not None:
        cost = metric_cost(metric, coordinates)
        if specs["EDGE_WEIGHT_TYPE"] == "GEO":
            cost[place[:, None] == place[None, :]] = 0.0  # it has 1 between nodes at one place
        return cost
    if "EDGE_WEIGHT" not in sections:
        raise InputError("EDGE_WEIGHT_TYPE is EXPLICIT but there is no EDGE_WEIGHT_SECTION")
    weights = explicit_weights(sections["EDGE_WEIGHT"], specs.get("EDGE_WEIGHT_FORMAT", "FULL_MATRIX"), size)
    _check_weights(weights)
    cost = weights[np.ix_(place, place)]
    cost[place[:, None] == place[None, :]] = 0.0  # the diagonal, also between UAVs at one depot
    scale = SCALE.search(specs.get("COMMENT", ""))
    if scale:
        try:
            unit = float(scale[1])
        except ValueError:
            unit = 0.0
        if not 0 < unit < np.inf:
            raise InputError(f"COMMENT: the scale {shown(scale[1])} is not a number")
        with np.errstate(over="ignore"):  # refused by Instance
            cost /= unit
    return cost


def _check_weights(weights: Floats) -> None:
    """Complain in the file's own node numbers."""
    off_diagonal = ~np.eye(len(weights), dtype=bool)
    for bad, what in ((np.isnan(weights), "not a number"), (np.isinf(weights), "infinite"), (weights < 0, "negative")):
        if (bad & off_diagonal).any():
            i, j = np.argwhere(bad & off_diagonal)[0]
            raise InputError(f"EDGE_WEIGHT_SECTION: the weight from {i + 1} to {j + 1} is {what} ({weights[i, j]})")


TSPLIB = Format(read_tsplib)
