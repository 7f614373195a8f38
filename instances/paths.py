"""Paths between nodes, their files, and their independent check: length, wind integral and collision, recomputed.

`check_paths` trusts neither a planner's costs (`moving_cost.CostMeasure`) and the integrals they are made of nor its
collision tests: it samples the wind itself and asks the region's polygon. What it confirms is what a path costs and
that it can be flown, not that no other path is cheaper.

The file lies beside the instance, ``NAME.paths.json.gz`` for ``NAME.json``; its points are rounded to the millimetre.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from instances.arrays import Floats, Ints
from instances.disk import read_json, write_aside
from instances.environment.region import Region
from instances.environment.wind import WindField
from instances.errors import InputError, naming, shown
from instances.extent import LARGEST, check_positions
from instances.instance import Instance
from instances.moving_cost import CostKind, moving_cost, segments
from instances.wind_triangle import ground_speeds

ENDING = ".paths.json.gz"
NEAR = 5e-3
"""A path may miss its end or leave the region by so much [m]: points in files are rounded to the millimetre."""
PIECE = 50.0
"""Length [m] of the pieces on which the check integrates the wind, by three Gauss points each."""
MOST_PIECES = 10_000
"""Pieces of a segment: one of more than 500 km is cut into longer ones."""
AT_ONCE = 1_000_000
"""Pieces about which the wind is asked at a time: bounds the memory."""
TOLERANCE = 1e-5
"""Difference between a claimed and a recomputed cost, over the flight time, that counts as agreement."""


@dataclass(frozen=True, eq=False)
class Paths:
    """A polyline for every ordered pair of N nodes, held end to end.

    The path from i to j is ``points[offsets[k]:offsets[k + 1]]`` [m] with k = i·N + j; that from i to itself is
    empty.

    others : the paths of further classes of UAV, where they are planned for each; these are those of class 0.
    later, departures : in a wind that changes, further paths and the moments [s] they are planned for; of all these,
        whoever departs flies the one that is quickest from then on (`instances.paths_clocked`).
    """

    n_nodes: int
    points: Floats
    offsets: Ints
    others: tuple[Paths, ...] = ()
    later: tuple[Paths, ...] = ()
    departures: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if (
            self.n_nodes < 1
            or len(self.offsets) != self.n_nodes**2 + 1
            or self.offsets[0] != 0
            or self.offsets[-1] != len(self.points)
        ):
            raise InputError(f"paths: {self.n_nodes} nodes need {self.n_nodes**2} paths, held end to end")
        if len(self.departures) != len(self.later):
            raise InputError(f"paths: {len(self.later)} later ones need as many departures, got {len(self.departures)}")

    @classmethod
    def of(cls, n_nodes: int, paths: Sequence[Floats]) -> Paths:
        """Return n_nodes² polylines as Paths, in the order (0, 0), (0, 1), …"""
        offsets = np.concatenate([[0], np.cumsum([len(p) for p in paths])]).astype(np.int64)
        return cls(n_nodes, np.concatenate([np.asarray(p, dtype=float).reshape(-1, 2) for p in paths]), offsets)

    def of_class(self, g: int) -> Paths:
        """Return the paths of class `g` of UAV."""
        return (self, *self.others)[g]

    def between(self, i: int, j: int) -> Floats:
        """Return the polyline from node i to node j, shape (k, 2) [m]."""
        k = i * self.n_nodes + j
        return self.points[self.offsets[k] : self.offsets[k + 1]]

    def along(self, stops: Sequence[int]) -> Floats:
        """Return the polyline through the nodes `stops` in order, shape (k, 2) [m]."""
        legs = [self.between(i, j) for i, j in pairwise(stops) if i != j]
        return np.concatenate([legs[0][:1], *(leg[1:] for leg in legs)]) if legs else np.empty((0, 2))

    def repeated(self, of: Ints, coordinates: Floats) -> Paths:
        """Return the paths of a larger set of nodes: node a lies at ``coordinates[a]`` and is node ``of[a]`` here.

        Between two nodes that are the same here the path is its two equal ends.
        """
        n = len(of)
        paths = [
            self.between(of[a], of[b]) if of[a] != of[b] else coordinates[[a, b]] if a != b else np.empty((0, 2))
            for a in range(n)
            for b in range(n)
        ]
        later = tuple(each.repeated(of, coordinates) for each in self.later)
        return replace(Paths.of(n, paths), later=later, departures=self.departures)


def check_paths(
    paths: Paths,
    cost: Floats,
    coordinates: Floats,
    region: Region,
    wind: WindField | None,
    v0: float,
    potential: Floats | None = None,
    kind: CostKind = CostKind.ENERGY,
    legs: Callable[[Floats], Floats] | None = None,
) -> list[str]:
    """Return what is wrong with `paths`, a sentence each; an empty list means that all of it is confirmed.

    cost : claimed costs [s], shape (N, N). coordinates : of the nodes (N, 2) [m]. region : without its no-fly
    zones. potential : node potentials p [s], shape (N,), where ``cost[i, j]`` is C(σ) + p_j − p_i. kind : what costs
    are, at the speed v0 [m/s]. legs : what legs cost where paths cost so much, (N, N) [s], if that is more (service).
    """
    n = paths.n_nodes
    if cost.shape != (n, n) or coordinates.shape != (n, 2):
        return [f"There are paths between {n} nodes but costs between {len(cost)} and {len(coordinates)} coordinates."]
    faults, fatal = shape_faults(paths, coordinates, region)
    if fatal:
        return faults
    i, j = np.divmod(np.flatnonzero(~np.eye(n, dtype=bool)), n)
    k = i * n + j
    lengths, found = _recomputed(paths, wind, v0, kind)
    tau = lengths[k] / v0
    actual = found[k] if kind is CostKind.TIME else moving_cost(tau, found[k], v0)
    if np.isnan(actual).any():
        q = int(np.argmax(np.isnan(actual)))
        return [*faults, f"The path from {i[q]} to {j[q]} meets a wind in which the airspeed cannot keep it."]
    if legs is not None:
        all_paths = np.zeros((n, n))
        all_paths[i, j] = actual
        actual = legs(all_paths)[i, j]
    if potential is not None:
        actual = actual + potential[j] - potential[i]
    wrong = np.abs(cost[i, j] - actual) > TOLERANCE * np.maximum(tau, 1e-3)
    if wrong.any():
        q = int(np.argmax(np.where(wrong, np.abs(cost[i, j] - actual), -1.0)))
        faults.append(
            f"The path from {i[q]} to {j[q]} costs {actual[q]:.9g} s, not the {cost[i[q], j[q]]:.9g} s claimed "
            f"({int(wrong.sum())} of {len(k)} differ)."
        )
    return faults


def shape_faults(paths: Paths, coordinates: Floats, region: Region) -> tuple[list[str], bool]:
    """Return what is wrong with where `paths` lead, a sentence each, and whether nothing can be said of their costs."""
    n, faults = paths.n_nodes, list[str]()
    i, j = np.divmod(np.flatnonzero(~np.eye(n, dtype=bool)), n)
    k = i * n + j
    size = np.diff(paths.offsets)[k]
    if (size < 2).any():
        q = int(np.argmax(size < 2))
        return [f"There is no path from node {i[q]} to node {j[q]} ({int((size < 2).sum())} are missing)."], True
    if np.diff(paths.offsets)[:: n + 1].any():
        return ["A node has a path to itself."], True
    first, last = paths.points[paths.offsets[k]], paths.points[paths.offsets[k + 1] - 1]
    for end, node, word in ((first, i, "start"), (last, j, "end")):
        off = np.hypot(*(end - coordinates[node]).T)
        if off.max() > NEAR:
            q = int(np.argmax(off))
            faults.append(f"The path from {i[q]} to {j[q]} does not {word} at node {node[q]}, but {off[q]:.3g} m away.")
    outside = paths_outside(paths, region)
    if len(outside):
        p, q = divmod(int(outside[0]), n)
        room = region.polygon.buffer(NEAR)
        far = shapely.length(shapely.difference(shapely.linestrings(paths.between(p, q)), room))
        faults.append(
            f"The path from {p} to {q} runs {far:.3g} m outside the region or in a no-fly zone "
            f"({len(outside)} of {len(k)} paths do)."
        )
    return faults, False


def paths_outside(paths: Paths, region: Region) -> Ints:
    """Return the numbers k = i·N + j of the paths that leave `region`."""
    size = np.diff(paths.offsets)
    flown = np.flatnonzero(size)
    lines = shapely.linestrings(paths.points, indices=np.repeat(np.arange(len(flown)), size[flown]))
    room = region.polygon.buffer(NEAR)
    shapely.prepare(room)
    return flown[~np.asarray(shapely.covers(room, lines))]


def _recomputed(paths: Paths, wind: WindField | None, v0: float, kind: CostKind) -> tuple[Floats, Floats]:
    """Return of each path its length [m] and ∫ w·dσ [m²/s], or for times the time [s], NaN where it cannot be flown."""
    a, b, owner = segments(paths.points, paths.offsets)
    size = np.hypot(*(b - a).T)
    count = paths.n_nodes**2
    lengths = np.bincount(owner, size, minlength=count).astype(float)
    if wind is None:
        return lengths, lengths / v0 if kind is CostKind.TIME else np.zeros(count)
    total = np.zeros(count)
    pieces = np.clip(np.ceil(size / PIECE), 1, MOST_PIECES).astype(np.int64)
    for part in np.split(np.arange(len(a)), np.flatnonzero(np.diff(np.cumsum(pieces) // AT_ONCE)) + 1):
        found = _integrals(a[part], b[part], pieces[part], wind, v0, kind)
        total += np.bincount(owner[part], found, minlength=count)
    return lengths, total


def _integrals(a: Floats, b: Floats, pieces: Ints, wind: WindField, v0: float, kind: CostKind) -> Floats:
    """Return ∫ w·dσ [m²/s] or the times [s] along the segments `a` → `b`, by composite Gauss quadrature."""
    d = b - a
    size = np.hypot(*d.T)
    tangents = np.divide(d, size[:, None], out=np.zeros_like(d), where=size[:, None] > 0)
    which = np.repeat(np.arange(len(a)), pieces)
    number = np.arange(len(which)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    total = np.zeros(len(which))
    for node, weight in ((-(0.6**0.5), 5 / 18), (0.0, 8 / 18), (0.6**0.5, 5 / 18)):
        t = (number + 0.5 + 0.5 * node) / pieces[which]
        w = wind(a[which] + t[:, None] * d[which])
        if kind is CostKind.TIME:
            speeds = ground_speeds(w, tangents[which], v0)
            value = size[which] / np.where(speeds > 0, speeds, np.nan)
        else:
            value = np.einsum("ij,ij->i", w, d[which])
        total += weight * value / pieces[which]
    return np.bincount(which, total, minlength=len(a)).astype(float)


def paths_file(instance_file: Path | str) -> Path:
    """Return where the paths of an instance file are kept: beside it, ``NAME.paths.json.gz``."""
    path = Path(instance_file)
    return path.with_name(path.name.removesuffix(".gz").removesuffix(".json").removesuffix(".atsp") + ENDING)


def write_paths(paths: Paths, instance: Instance, path: Path | str, scenario: str = "") -> None:
    """Write the paths behind the costs of `instance`; `scenario` names the file they were planned in."""
    table = {
        "schema": 1,
        "instance": instance.name,
        "digest": instance.digest,
        "scenario": scenario,
        "n_nodes": paths.n_nodes,
        **_lines(paths),
    }
    if paths.others:
        table["others"] = [_lines(each) for each in paths.others]
    write_aside(path, gzip.compress(json.dumps(table, separators=(",", ":")).encode(), mtime=0))


def _lines(paths: Paths) -> dict[str, Any]:
    """Return the polylines of `paths`, and of those planned for later departures, as JSON values."""
    table: dict[str, Any] = {"offsets": paths.offsets.tolist(), "points": np.round(paths.points, 3).tolist()}
    if paths.later:
        table["later"] = [
            {"departure": t, **_lines(each)} for t, each in zip(paths.departures, paths.later, strict=True)
        ]
    return table


def read_paths(path: Path | str, instance: Instance) -> Paths:
    """Read the paths behind the costs of `instance`; InputError names the file and what is wrong."""
    return paths_of(read_paths_table(path), instance, path)


def read_paths_table(path: Path | str) -> dict[str, Any]:
    """Read a file of paths as the table it is."""
    table = read_json(path)
    if not isinstance(table, dict) or table.get("schema") != 1:
        raise InputError(f"{path}: is no file of paths of schema 1")
    return table


def paths_of(table: dict[str, Any], instance: Instance, path: Path | str) -> Paths:
    """Return the paths in `table`, read from `path`; InputError where they are not those of `instance`."""
    digest = table.get("digest")
    if digest != instance.digest:
        raise InputError(
            f"{path}: belongs to an instance of digest {shown(digest)}, {instance.name} has {instance.digest}"
        )
    for key in ("n_nodes", "offsets", "points"):
        if key not in table:
            raise InputError(f"{path}: the key '{key}' is missing")
    if table["n_nodes"] != instance.n_nodes:
        raise InputError(f"{path}: n_nodes must be {instance.n_nodes}, got {shown(table['n_nodes'])}")
    with naming(path):
        others = _tables(table, "others", {"points", "offsets"})
        first, *rest = (_read_lines(t, instance.n_nodes) for t in (table, *others))
        return replace(first, others=tuple(rest))


def _tables(table: dict[str, Any], key: str, needed: set[str]) -> list[dict[str, Any]]:
    """Return the list of tables at a key, none where it is missing; InputError where one lacks a key of `needed`."""
    found = table.get(key, [])
    if not isinstance(found, list) or not all(isinstance(t, dict) and needed <= set(t) for t in found):
        raise InputError(f"{key} must be tables of {' and '.join(sorted(needed, reverse=True))}, got {shown(found)}")
    return found


def _read_lines(table: dict[str, Any], n_nodes: int) -> Paths:
    """Return what `_lines` wrote."""
    later = _tables(table, "later", {"points", "offsets", "departure"})
    departures = [t["departure"] for t in later]
    if not all(isinstance(t, float | int) and 0 <= t <= LARGEST for t in departures):
        raise InputError(f"later: each departure must be a time [s] of at least 0, got {shown(departures)}")
    return Paths(
        n_nodes,
        _points(table["points"]),
        _offsets(table["offsets"]),
        later=tuple(_read_lines(t | {"later": []}, n_nodes) for t in later),
        departures=tuple(float(t) for t in departures),
    )


def _points(value: object) -> Floats:
    try:
        points = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError("points must be a list of pairs of numbers [m]")
    check_positions(points, "points")
    return points


def _offsets(value: object) -> Ints:
    if not isinstance(value, list) or not {*map(type, value)} <= {int} or not all(0 <= v < 2**62 for v in value):
        raise InputError("offsets must be a list of whole numbers of at least 0")
    offsets = np.array(value, dtype=np.int64)
    if (np.diff(offsets) < 0).any():
        raise InputError("offsets must rise")
    return offsets
