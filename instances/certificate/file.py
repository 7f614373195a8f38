"""The certificate of a lower bound: a tree of cases and, in each, the prices at which it is closed; and its file.

The file is JSON in gzip. It says nothing that has to be believed: prices may be any numbers, and what they prove is
computed anew (`checking`).
"""

from __future__ import annotations

import gzip
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from instances.disk import read_unpacked, write_aside
from instances.documents import json_of, text_of
from instances.errors import InputError, naming, shown

SUFFIX = ".certificate.json.gz"
_FORMAT, _BY_TOURS, _BY_ARCS, _WITH_JOINT = "mmmdmtsp-certificate", 1, 2, 3
"""A file of version 1 closes its cases by tours alone, one of version 2 has no cuts of all UAVs."""


@dataclass(frozen=True)
class Prices:
    """Dual prices: `task` π_i [s] (n,); `uav` σ_k ≥ 0 (m,), Σσ ≤ 1; `rho` ρ_S ≥ 0 [s] of the `sets` S of three tasks.

    least : r_k ≤ 0 [s] (m,), what the reduced costs of the tours of UAV k are said not to fall below.
    """

    task: tuple[float, ...]
    uav: tuple[float, ...]
    least: tuple[float, ...]
    sets: tuple[tuple[int, int, int], ...] = ()
    rho: tuple[float, ...] = ()


@dataclass(frozen=True)
class ArcPrices:
    """Dual prices of arcs: `uav` σ_k ≥ 0 (m,); `potential` w_k(i) [s] (m, n + 1), the depot's last; `use` u_k ≤ 0 [s],
    (m,); `mu` μ ≥ 0 [s] of the `cuts` of these numbers; `rho` ρ ≥ 0 [s] of what the case needs, in the order it came;
    `nu` ν ≥ 0 [s] of the cuts of all UAVs of the numbers `joint`.
    """

    uav: tuple[float, ...]
    potential: tuple[tuple[float, ...], ...]
    use: tuple[float, ...]
    cuts: tuple[int, ...] = ()
    mu: tuple[float, ...] = ()
    rho: tuple[float, ...] = ()
    joint: tuple[int, ...] = ()
    nu: tuple[float, ...] = ()


@dataclass(frozen=True)
class Cut:
    """That UAV `uav` enters the `tasks` if it visits the task `visited` among them (paper, const6)."""

    uav: int
    visited: int
    tasks: tuple[int, ...]


@dataclass(frozen=True)
class Blossom:
    """That what crosses the tasks `handle` is even: with `teeth` (i, j), of odd number and flown once at most, either
    way where both are tasks, something else crosses, or not all of them are flown. The depot comes after the tasks.
    """

    handle: tuple[int, ...]
    teeth: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Crowd:
    """That the `tasks` are entered twice, as a 1-tree at `potential` [s], the depot's first, says that no UAV can take
    them all within the bound."""

    tasks: tuple[int, ...]
    potential: tuple[float, ...]


@dataclass(frozen=True)
class Node:
    """A case: that of `parent` (none: all routes) in which `task` is forbidden to the UAVs `forbidden`, or one of the
    `arcs` between tasks is `flown` by some UAV, or none of them is."""

    parent: int | None = None
    task: int | None = None
    forbidden: tuple[int, ...] = ()
    arcs: tuple[tuple[int, int], ...] = ()
    flown: bool = False


@dataclass(frozen=True)
class Step:
    """What is done in case `node` at `prices`: tours are put aside, those of the UAVs `listed` from then on one by one,
    or, where it `closes`, the case is at its end, as it always is at prices of arcs."""

    node: int
    prices: Prices | ArcPrices
    listed: tuple[int, ...] = ()
    closes: bool = False


@dataclass(frozen=True)
class Certificate:
    """The claim that no routes of the instance with that `digest` have a longest tour of at most `bound` [s].

    `routes`, where there are any, are those known, of cost `objective` [s]; `cuts` are those that prices of arcs name,
    `joint` those of all UAVs.
    """

    instance: str
    digest: str
    bound: float
    objective: float | None
    routes: tuple[tuple[int, ...], ...]
    nodes: tuple[Node, ...]
    steps: tuple[Step, ...]
    cuts: tuple[Cut, ...] = ()
    joint: tuple[Blossom | Crowd, ...] = ()


def write_certificate(path: Path, certificate: Certificate) -> None:
    """Write the file, whole or not at all."""
    by_arcs = any(isinstance(step.prices, ArcPrices) for step in certificate.steps)
    version = (_WITH_JOINT if certificate.joint else _BY_ARCS) if by_arcs else _BY_TOURS
    text = json.dumps({"format": _FORMAT, "version": version, **asdict(certificate)}, separators=(",", ":"))
    write_aside(path, gzip.compress(text.encode(), mtime=0))


def read_certificate(path: Path) -> Certificate:
    """Return the certificate in the file; InputError names the file and the field that cannot be used."""
    with naming(path):
        content = json_of(text_of(read_unpacked(path)))
        if not isinstance(content, dict) or content.get("format") != _FORMAT:
            raise InputError(f"is no certificate: its format must be {_FORMAT!r}")
        if content.get("version") not in (_BY_TOURS, _BY_ARCS, _WITH_JOINT):
            versions = f"{_BY_TOURS}, {_BY_ARCS} or {_WITH_JOINT}"
            raise InputError(f"version must be {versions}, got {shown(content.get('version'))}")
        try:
            return _certificate(content)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"is no certificate that can be read ({type(error).__name__}: {error})") from None


def _certificate(content: dict[str, Any]) -> Certificate:
    objective = content["objective"]
    return Certificate(
        str(content["instance"]),
        str(content["digest"]),
        float(content["bound"]),
        None if objective is None else float(objective),
        tuple(tuple(int(i) for i in route) for route in content["routes"]),
        tuple(
            Node(
                None if node["parent"] is None else int(node["parent"]),
                None if node["task"] is None else int(node["task"]),
                tuple(int(k) for k in node["forbidden"]),
                tuple((int(i), int(j)) for i, j in node.get("arcs", ())),
                bool(node.get("flown", False)),
            )
            for node in content["nodes"]
        ),
        tuple(
            Step(int(s["node"]), _prices(s["prices"]), tuple(int(k) for k in s["listed"]), bool(s["closes"]))
            for s in content["steps"]
        ),
        tuple(
            Cut(int(cut["uav"]), int(cut["visited"]), tuple(int(i) for i in cut["tasks"]))
            for cut in content.get("cuts", ())
        ),
        tuple(_joint(cut) for cut in content.get("joint", ())),
    )


def _joint(content: dict[str, Any]) -> Blossom | Crowd:
    if "handle" in content:
        teeth = tuple((int(i), int(j)) for i, j in content["teeth"])
        return Blossom(tuple(int(i) for i in content["handle"]), teeth)
    return Crowd(tuple(int(i) for i in content["tasks"]), tuple(float(w) for w in content["potential"]))


def _prices(content: dict[str, Any]) -> Prices | ArcPrices:
    if "potential" in content:
        uav, use, mu, by_need = (tuple(float(x) for x in content[name]) for name in ("uav", "use", "mu", "rho"))
        potential = tuple(tuple(float(x) for x in row) for row in content["potential"])
        joint, nu = tuple(int(c) for c in content.get("joint", ())), tuple(float(x) for x in content.get("nu", ()))
        return ArcPrices(uav, potential, use, tuple(int(c) for c in content["cuts"]), mu, by_need, joint, nu)
    task, uav, least, rho = (tuple(float(x) for x in content[name]) for name in ("task", "uav", "least", "rho"))
    sets = tuple((int(a), int(b), int(c)) for a, b, c in content["sets"])
    return Prices(task, uav, least, sets, rho)
