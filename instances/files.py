"""Files of instances and routes, read and written by their ending.

| ending | what | in | out |
|---|---|---|---|
| .json, .json.gz | native (`formats.native`) | yes | yes |
| .tsp .atsp .mtsp .mdm .vrp | TSPLIB, LKH, VRPLIB (`formats.tsplib`) | yes | .atsp |
| .sol | routes (`formats.sol`) | yes | yes |
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from instances.errors import InputError, suggestion
from instances.formats import atsp, native, sol, tsplib
from instances.instance import Instance
from instances.routes import Routes

READERS = {
    ".json": native.read_native,
    ".json.gz": native.read_native,
    ".tsp": tsplib.read_tsplib,
    ".atsp": tsplib.read_tsplib,
    ".mtsp": tsplib.read_tsplib,
    ".mdm": tsplib.read_tsplib,
    ".vrp": tsplib.read_tsplib,
}
"""Ending of an instance file → its reader."""

WRITERS = {".json": native.write_native, ".json.gz": native.write_native, ".atsp": atsp.write_atsp}
"""Ending of an instance file → its writer."""


def read_instance(path: Path | str) -> Instance:
    """Read an instance of any known format; InputError names the file, the field and the value."""
    return READERS[_ending(path, READERS, "instance")](Path(path))


def write_instance(instance: Instance, path: Path | str) -> None:
    """Write an instance; InputError where the ending is unknown or the file cannot be written."""
    WRITERS[_ending(path, WRITERS, "instance")](instance, Path(path))


def read_routes(path: Path | str, instance: Instance) -> Routes:
    """Read the routes of `instance`; InputError where they are not feasible for it."""
    _ending(path, (".sol",), "routes")
    return sol.read_solution(Path(path), instance)[0]


def write_routes(routes: Sequence[Sequence[int]], instance: Instance, path: Path | str) -> None:
    """Write feasible routes of `instance` with their cost."""
    _ending(path, (".sol",), "routes")
    sol.write_solution(routes, instance, Path(path))


def _ending(path: Path | str, known: Collection[str], what: str) -> str:
    name = Path(path).name.lower()
    for ending in known:
        if name.endswith(ending):
            return ending
    suffix = Path(name).suffix
    raise InputError(
        f"{path}: '{suffix}' is no ending of {what} files{suggestion(suffix, known)} (known: {', '.join(known)})"
    )
