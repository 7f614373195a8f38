"""Files of instances and routes, read and written by their ending.

| ending | what | in | out |
|---|---|---|---|
| .json, .json.gz | native (`formats.native`) | yes | yes |
| .tsp .atsp .mtsp .vrp | TSPLIB, LKH, VRPLIB (`formats.tsplib`, `formats.tsplib_text`) | yes | yes |
| .mdm | the same with UAVs counted at each depot (`formats.tsplib`) | yes | |
| .txt | team orienteering (`formats.team_orienteering`) | yes | |
| .sol | routes (`formats.sol`) | yes | yes |
| .tour | routes (`formats.tsplib_tour`) | yes | yes |
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from instances.errors import InputError, suggestion
from instances.formats import sol, tsplib_tour
from instances.formats.format import Format
from instances.instance import Instance
from instances.registry import Registry
from instances.routes import Routes

_NATIVE = ("instances.formats.native:NATIVE", "everything an instance holds")
FORMATS: Registry[Format] = Registry(
    "file format",
    {
        ".json": _NATIVE,
        ".json.gz": _NATIVE,
        ".tsp": ("instances.formats.tsplib_text:TSP", "TSPLIB, costs alike in both directions"),
        ".atsp": ("instances.formats.tsplib_text:ATSP", "TSPLIB, costs that differ by direction"),
        ".mtsp": ("instances.formats.tsplib_text:MTSP", "LKH-3, which itself takes one depot"),
        ".vrp": ("instances.formats.tsplib_text:VRP", "VRPLIB, several depots as PyVRP reads them"),
        ".mdm": ("instances.formats.tsplib:TSPLIB", "TSPLIB with UAVs counted at each depot"),
        ".txt": ("instances.formats.team_orienteering:TEAM_ORIENTEERING", "team orienteering: prizes and tmax"),
    },
    group="mmmdmtsp_workbench.formats",
    having=("read", "write"),
)
"""Ending of an instance file → its format."""
ROUTES = (".sol", ".tour")
"""Endings of files of routes."""


def endings(*, written: bool = False) -> tuple[str, ...]:
    """Return the endings of instance files, all that are read or only those that are `written`.

    Formats of third parties are not imported to be asked: they count as written.
    """
    unwritten = {ending for ending in FORMATS.built_in if written and FORMATS.load(ending).write is None}
    return tuple(ending for ending in FORMATS.targets() if ending.startswith(".") and ending not in unwritten)


def read_instance(path: Path | str) -> Instance:
    """Read an instance of any known format.

    Parameters
    ----------
    path
        Its ending names the format.

    Raises
    ------
    InputError
        Names the file, the field and the value.
    """
    return FORMATS.load(_format(path)).read(Path(path))


def write_instance(instance: Instance, path: Path | str) -> None:
    """Write an instance; InputError where the ending is unknown or the file cannot be written."""
    write = FORMATS.load(_format(path, written=True)).write
    if write is None:
        raise InputError(f"{path}: files of this format are only read")
    write(instance, Path(path))


def read_routes(path: Path | str, instance: Instance, *, all_tasks: bool = True) -> Routes:
    """Read the routes of `instance`.

    Parameters
    ----------
    path
        A ``.sol`` or ``.tour`` file.
    instance
        What they are routes of.
    all_tasks
        Whether every task must be visited.

    Raises
    ------
    InputError
        Where they are not feasible for it (`instances.check_routes`).
    """
    return read_claim(path, instance, all_tasks=all_tasks)[0]


def read_claim(path: Path | str, instance: Instance, *, all_tasks: bool = True) -> tuple[Routes, float | None]:
    """Read the routes of `instance` and the cost [s] the file claims, None where it claims none."""
    if _ending(path, ROUTES, "routes") == ".tour":
        return tsplib_tour.read_tour(Path(path), instance, all_tasks=all_tasks), None
    return sol.read_solution(Path(path), instance, all_tasks=all_tasks)


def write_routes(
    routes: Sequence[Sequence[int]], instance: Instance, path: Path | str, *, all_tasks: bool = True
) -> None:
    """Write feasible routes of `instance` with their cost."""
    write = tsplib_tour.write_tour if _ending(path, ROUTES, "routes") == ".tour" else sol.write_solution
    write(routes, instance, Path(path), all_tasks=all_tasks)


def _format(path: Path | str, *, written: bool = False) -> str:
    """Return the ending by which an instance file's format is registered; what is built in comes first."""
    name = Path(path).name.lower()
    found = next((ending for ending in FORMATS.built_in if name.endswith(ending)), None)
    if found is None or (written and FORMATS.load(found).write is None):
        return _ending(path, endings(written=written), "instance")
    return found


def _ending(path: Path | str, known: Collection[str], what: str) -> str:
    name = Path(path).name.lower()
    for ending in known:
        if name.endswith(ending):
            return ending
    suffix = Path(name).suffix
    raise InputError(
        f"{path}: '{suffix}' is no ending of {what} files{suggestion(suffix, known)} (known: {', '.join(known)})"
    )
