"""Depots and UAVs in TSPLIB, LKH and VRPLIB files: which nodes are depots, and how many UAVs stand at each.

* DEPOT_SECTION holds ``node`` or ``node count`` (1-based; count UAVs stand there), closed by −1. A depot with count c
  is c depots at one place. LKH's keyword DEPOT names a single one. Without either node 1 is the depot.
* VEHICLES (or SALESMEN) is m. With one depot and no count, all m start there; with as many depots as vehicles, one
  each; where counts are given, their sum must be m. Without it there is one UAV per depot listed.
* VEHICLES_DEPOT_SECTION (PyVRP) holds ``vehicle node``: the depot of each UAV, in order.
* Every other node is a task, in the order of the file.
"""

from __future__ import annotations

from collections.abc import Mapping

from instances.errors import InputError, shown
from instances.instance import MAX_NODES, check_size


def nodes_of(specs: Mapping[str, str], sections: Mapping[str, list[str]], size: int) -> tuple[list[int], int]:
    """Return the file's node numbers in our order, tasks first, and the number of depots m."""
    if "DEPOT" in specs and "DEPOT" in sections:
        raise InputError("both DEPOT and DEPOT_SECTION are given")
    lines = [specs["DEPOT"]] if "DEPOT" in specs else sections.get("DEPOT")
    places, counts = _depot_lines(lines, size) if lines is not None else ([1], None)
    vehicles = _vehicles(specs)
    if "VEHICLES_DEPOT" in sections:
        depots = _depot_of_each(sections["VEHICLES_DEPOT"], places)
        if vehicles is not None and vehicles != len(depots):
            raise InputError(f"VEHICLES is {vehicles} but VEHICLES_DEPOT_SECTION has {len(depots)} lines")
    else:
        counts = counts or _counts(len(places), vehicles)
        if vehicles is not None and vehicles != sum(counts):
            raise InputError(f"VEHICLES is {vehicles} but the counts in DEPOT_SECTION add up to {sum(counts)}")
        check_size(size - len(places), sum(counts), MAX_NODES)
        depots = [node for node, count in zip(places, counts, strict=True) for _ in range(count)]
    check_size(size - len(places), len(depots), MAX_NODES)
    at = set(places)
    tasks = [node for node in range(1, size + 1) if node not in at]
    if not tasks:
        raise InputError(f"every one of the {size} nodes is a depot: there is no task")
    return tasks + depots, len(depots)


def whole_number(specs: Mapping[str, str], key: str) -> int | None:
    """Return the positive whole number of a keyword, None where it is missing."""
    if key not in specs:
        return None
    value = specs[key]
    if not (_is_whole(value) and int(value) >= 1):
        raise InputError(f"{key} must be a whole number of at least 1, got {shown(value)}")
    return int(value)


def _vehicles(specs: Mapping[str, str]) -> int | None:
    vehicles, salesmen = whole_number(specs, "VEHICLES"), whole_number(specs, "SALESMEN")
    if vehicles is not None and salesmen is not None and vehicles != salesmen:
        raise InputError(f"VEHICLES is {vehicles} but SALESMEN is {salesmen}")
    return vehicles if vehicles is not None else salesmen


def _counts(n_places: int, vehicles: int | None) -> list[int]:
    """Return how many UAVs stand at each depot where the lines do not say it."""
    if vehicles is None or vehicles == n_places:
        return [1] * n_places
    if n_places == 1:
        return [vehicles]
    raise InputError(f"VEHICLES is {vehicles} for {n_places} depots: DEPOT_SECTION must say 'node count' for each")


def _depot_lines(lines: list[str], size: int) -> tuple[list[int], list[int] | None]:
    """Return the depots' nodes, and how many UAVs stand there where the lines say so."""
    places: list[int] = []
    counts: list[int] = []
    for line in lines:
        words = line.split()
        if words[:1] == ["-1"]:
            break
        if len(words) not in (1, 2) or not all(map(_is_whole, words)):
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


def _depot_of_each(lines: list[str], places: list[int]) -> list[int]:
    """Return the depot's node of each UAV."""
    depots: list[int] = []
    for number, line in enumerate(lines, 1):
        words = line.split()
        if len(words) != 2 or words[0] != str(number) or not _is_whole(words[1]):
            raise InputError(f"VEHICLES_DEPOT_SECTION must hold 'vehicle node' from 1 in order, got {shown(line)}")
        if int(words[1]) not in places:
            raise InputError(f"VEHICLES_DEPOT_SECTION names node {words[1]}, which is no depot")
        depots.append(int(words[1]))
    if not depots:
        raise InputError("VEHICLES_DEPOT_SECTION names no vehicle")
    return depots


def _is_whole(word: str) -> bool:
    return word.isascii() and word.isdigit() and len(word) < 10
