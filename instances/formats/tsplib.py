"""TSPLIB and its relatives: ``.tsp .atsp``, LKH-style ``.mtsp``, VRPLIB ``.vrp``, and ``.mdm`` (min-max, multi-depot).

What these files say of UAVs and depots, and how it is read:

* DEPOT_SECTION holds ``node`` or ``node count`` (1-based; count UAVs stand there), closed by −1. A depot with count c
  is c depots at one place. LKH's keyword DEPOT names a single one. Without either node 1 is the depot.
* VEHICLES (or SALESMEN) is m. With one depot and no count, all m start there; with as many depots as vehicles, one
  each; where counts are given, their sum must be m. Without it there is one UAV per depot listed.
* Every other node is a task, in the order of the file. ``provenance["nodes"]`` maps our node numbers to the file's
  (1-based), so that tours in the file's numbering can be evaluated.
* Weights are taken as seconds; the diagonal, which TSPLIB leaves open, becomes 0. Capacity, demand and the like have
  no place in the min-max problem and are left out; ``provenance["ignored"]`` lists them.

vrplib reads keywords and coordinates. Depot counts and weights that wrap over lines are beyond it (version 1.5/2.0),
and so are TSPLIB's roundings; these are read here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import vrplib

from instances.arrays import Floats, Ints
from instances.disk import read_text
from instances.errors import InputError, naming, shown
from instances.formats.edge_weights import explicit_weights, metric_of
from instances.formats.format import Format
from instances.instance import Instance, check_size
from instances.metrics import metric_cost

KEYWORDS = frozenset({"NAME", "TYPE", "COMMENT", "DIMENSION", "VEHICLES", "SALESMEN", "DEPOT", "EDGE_WEIGHT_TYPE"}) | {
    "EDGE_WEIGHT_FORMAT",
    "NODE_COORD_TYPE",
    "DISPLAY_DATA_TYPE",
}
"""Keywords that are understood."""

SECTIONS = frozenset({"NODE_COORD", "EDGE_WEIGHT", "DEPOT", "DISPLAY_DATA"})
"""Sections that are understood."""

SCALE = re.compile(r"cost \[s\] = weight / ([0-9.e+-]+)")
"""What our own ``.atsp`` files say in their COMMENT about integer weights (`formats.atsp`)."""


def read_tsplib(path: Path) -> Instance:
    """Read a file of the TSPLIB kind; InputError names the file, the field and the value that cannot be used."""
    text = read_text(path)
    with naming(path):
        specs, sections = _split(text)
        size = _whole(specs, "DIMENSION")
        if size is None:
            raise InputError("the keyword DIMENSION is missing")
        if "DEPOT" in specs and "DEPOT" in sections:
            raise InputError("both DEPOT and DEPOT_SECTION are given")
        depots = [specs["DEPOT"]] if "DEPOT" in specs else sections.get("DEPOT")
        nodes, n_depots = _nodes(depots, _vehicles(specs), size)
        place = np.array(nodes) - 1
        coordinates = _coordinates(sections, size)
        if coordinates is not None:
            coordinates = coordinates[place]
        provenance: dict[str, Any] = {"source": path.name, "nodes": nodes}
        for key in ("TYPE", "COMMENT"):
            if key in specs:
                provenance[key.lower()] = specs[key]
        ignored = sorted((specs.keys() - KEYWORDS) | {f"{s}_SECTION" for s in sections.keys() - SECTIONS})
        if ignored:
            provenance["ignored"] = ignored
        cost = _cost(specs, sections, size, place, coordinates, provenance)
        name = specs.get("NAME", "") or path.name.split(".")[0]
        return Instance(name, cost, len(nodes) - n_depots, n_depots, coordinates, provenance)


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


def _whole(specs: Mapping[str, str], key: str) -> int | None:
    """Return the positive whole number of a keyword, None where it is missing."""
    if key not in specs:
        return None
    value = specs[key]
    if not (value.isascii() and value.isdigit() and len(value) < 10 and int(value) >= 1):
        raise InputError(f"{key} must be a whole number of at least 1, got {shown(value)}")
    return int(value)


def _vehicles(specs: Mapping[str, str]) -> int | None:
    vehicles, salesmen = _whole(specs, "VEHICLES"), _whole(specs, "SALESMEN")
    if vehicles is not None and salesmen is not None and vehicles != salesmen:
        raise InputError(f"VEHICLES is {vehicles} but SALESMEN is {salesmen}")
    return vehicles if vehicles is not None else salesmen


def _nodes(depot_lines: list[str] | None, vehicles: int | None, size: int) -> tuple[list[int], int]:
    """Return the file's node numbers in our order, tasks first, and the number of depots m."""
    places, counts = _depot_lines(depot_lines, size) if depot_lines is not None else ([1], None)
    if counts is None:
        if vehicles is None or vehicles == len(places):
            counts = [1] * len(places)
        elif len(places) == 1:
            counts = [vehicles]
        else:
            raise InputError(
                f"VEHICLES is {vehicles} for {len(places)} depots: DEPOT_SECTION must say 'node count' for each"
            )
    elif vehicles is not None and vehicles != sum(counts):
        raise InputError(f"VEHICLES is {vehicles} but the counts in DEPOT_SECTION add up to {sum(counts)}")
    check_size(size - len(places), sum(counts))
    depots = [node for node, count in zip(places, counts, strict=True) for _ in range(count)]
    at = set(places)
    tasks = [node for node in range(1, size + 1) if node not in at]
    if not tasks:
        raise InputError(f"every one of the {size} nodes is a depot: there is no task")
    return tasks + depots, len(depots)


def _depot_lines(lines: list[str], size: int) -> tuple[list[int], list[int] | None]:
    """Return the depots' nodes, and how many UAVs stand there where the lines say so."""
    places: list[int] = []
    counts: list[int] = []
    for line in lines:
        words = line.split()
        if words[:1] == ["-1"]:
            break
        if len(words) not in (1, 2) or not all(w.isascii() and w.isdigit() and len(w) < 10 for w in words):
            raise InputError(f"DEPOT_SECTION must hold 'node' or 'node count', got {shown(line)}")
        node, *count = map(int, words)
        if not 1 <= node <= size:
            raise InputError(f"DEPOT_SECTION names node {node}, but the nodes are 1 to {size}")
        if node in places:
            raise InputError(f"DEPOT_SECTION names node {node} twice")
        if count and count[0] < 1:
            raise InputError(f"DEPOT_SECTION puts {count[0]} UAVs at node {node}, must be at least 1")
        places.append(node)
        counts += count
    if not places:
        raise InputError("DEPOT_SECTION names no depot")
    if counts and len(counts) != len(places):
        raise InputError("DEPOT_SECTION gives a count for some depots but not for all")
    return places, counts or None


def _coordinates(sections: Mapping[str, list[str]], size: int) -> Floats | None:
    """Return the coordinates (size, 2) in file order, None where the file has none."""
    name = "NODE_COORD" if "NODE_COORD" in sections else "DISPLAY_DATA"
    if name not in sections:
        return None
    lines = sections[name]
    if len(lines) != size:
        raise InputError(f"{name}_SECTION has {len(lines)} lines, must have DIMENSION = {size}")
    for number, line in enumerate(lines, 1):
        words = line.split()
        if len(words) != 3:
            raise InputError(f"{name}_SECTION must hold 'node x y', got {shown(line)}")
        if words[0] != str(number):
            raise InputError(
                f"{name}_SECTION must list the nodes 1 to {size} in order, got {shown(words[0])} as {number}"
            )
    try:  # vrplib takes a line with a colon for a specification and refuses it
        parsed = vrplib.parse.parse_vrplib(f"{name}_SECTION\n" + "\n".join(lines) + "\nEOF", compute_edge_weights=False)
        xy = np.array(parsed[name.lower()], dtype=np.float64).reshape(size, 2)
    except (ValueError, OverflowError):
        raise InputError(f"{name}_SECTION holds something that is not a number") from None
    if not np.isfinite(xy).all():
        raise InputError(f"{name}_SECTION: node {int(np.argwhere(~np.isfinite(xy))[0][0]) + 1} is not finite")
    return xy


def _cost(
    specs: Mapping[str, str],
    sections: Mapping[str, list[str]],
    size: int,
    place: Ints,
    coordinates: Floats | None,
    provenance: dict[str, Any],
) -> Floats:
    """Return the cost matrix in our node order; a metric is noted in `provenance`."""
    kind = specs.get("EDGE_WEIGHT_TYPE", "EXPLICIT" if "EDGE_WEIGHT" in sections else None)
    if kind is None:
        raise InputError("the keyword EDGE_WEIGHT_TYPE is missing")
    if kind != "EXPLICIT":
        metric = metric_of(kind)
        if "NODE_COORD" not in sections:
            raise InputError(f"EDGE_WEIGHT_TYPE {kind} needs a NODE_COORD_SECTION")
        provenance["metric"] = metric
        return metric_cost(metric, coordinates)
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
