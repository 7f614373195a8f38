"""Study: instances × solvers × seeds × limits, read from TOML.

name = "mine"
seeds = 3                        # so many (0, 1, 2), or a list
time_limit = 10                  # [s], or a list
threads = 1
files = ["sets/*.json"]          # instance files, folders and patterns, relative to this file

[[families]]                     # a grid: every list is tried in every combination
family = "uniform"
tasks = [10, 20]
depots = [2, 3]
seeds = 5
parameters = { wind = ["none", "shear"] }

[[solvers]]                      # seeds, time_limit, threads, iterations here override those above
name = "ga"
options = { population = [200, 400] }
max_tasks = 200                  # larger instances are not given to this solver
"""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import Any

from formulations.routing.registry import make_solver, option_defaults
from formulations.routing.solver import Limits
from instances.errors import InputError, suggestion
from workbench.job import Job
from workbench.making import check_family
from workbench.sources import FamilySource, FileSource, Source, instance_files

STUDY_KEYS = (
    "name",
    "description",
    "seeds",
    "time_limit",
    "threads",
    "iterations",
    "files",
    "families",
    "solvers",
)
FAMILY_KEYS = ("family", "tasks", "depots", "seeds", "parameters")
LARGEST_SEED = 2**31 - 1
"""The largest every engine takes."""
NONE: Mapping[str, Any] = MappingProxyType({})
SOLVER_KEYS = ("name", "options", "seeds", "time_limit", "threads", "iterations", "max_tasks")


@dataclass(frozen=True)
class Entry:
    """One solver of a study with one set of options (those that differ from the default), its seeds and limits [s]."""

    solver: str
    options: dict[str, Any]
    seeds: tuple[int, ...]
    time_limits: tuple[float, ...]
    threads: int = 1
    iterations: int | None = None
    max_tasks: int | None = None

    def __post_init__(self) -> None:
        for limit in self.time_limits:
            Limits(time=limit, threads=self.threads, iterations=self.iterations)
            if limit == math.inf:
                raise InputError("time limit must be finite [s], got inf")
        for seed in self.seeds:
            if not 0 <= seed <= LARGEST_SEED:
                raise InputError(f"seed must be from 0 to {LARGEST_SEED}, got {seed}")

    def jobs(self, folder: str, n_tasks: int) -> Iterator[Job]:
        """Yield this entry's jobs on the instance kept in `folder`."""
        if self.max_tasks is not None and n_tasks > self.max_tasks:
            return
        for limit, seed in itertools.product(self.time_limits, self.seeds):
            yield Job(folder, self.solver, self.options, seed, limit, self.threads, self.iterations)


@dataclass(frozen=True)
class Study:
    """What to run: where instances come from, and the solvers' entries; `asked` is what the file says."""

    name: str
    description: str
    sources: tuple[Source, ...]
    entries: tuple[Entry, ...]
    asked: dict[str, Any] = field(default_factory=dict)

    def with_files(self, paths: Iterable[Path]) -> Study:
        """Return the study with more instances: files, or folders of them."""
        more = tuple(FileSource(path) for given in paths for path in instance_files(given))
        return replace(self, sources=self.sources + more)


def shipped_studies() -> dict[str, Path]:
    """Return the studies that come with the workbench: name → file."""
    folder = Path(str(files("workbench") / "studies"))
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def load_tables(path: Path) -> dict[str, Any]:
    """Return what the TOML file says; InputError where it cannot be read."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a study ({error})") from None


def study_from(data: dict[str, Any], *, name: str, base: Path, changes: Mapping[str, Any] = NONE) -> Study:
    """Return the study written as `data`, its files relative to `base`; InputError says what is wrong.

    changes : seeds, time_limit or threads that take the place of those in `data`, each solver's included.
    """
    _known_keys(data, STUDY_KEYS, "study")
    given = [_typed(item, str, "files") for item in _listed(data.get("files", []))]
    sources: list[Source] = [FileSource(path) for item in given for path in instance_files(base / item)]
    for number, table in enumerate(_tables(data, "families"), 1):
        sources += _families(table, f"families[{number}]")
    entries: list[Entry] = []
    for number, table in enumerate(_tables(data, "solvers"), 1):
        entries += _entries(table, data, changes, f"solvers[{number}]")
    if not entries:
        raise InputError("study: names no solvers ([[solvers]] with name = …)")
    return Study(
        name=_typed(data.get("name", name), str, "name"),
        description=_typed(data.get("description", ""), str, "description"),
        sources=tuple(sources),
        entries=tuple(entries),
        asked=data | dict(changes),
    )


def checked_entry(solver: str, options: dict[str, Any], **rest: Any) -> Entry:
    """Return an Entry whose solver and options are known to exist; InputError, or the reason it is not available."""
    try:
        cls = type(make_solver(solver, options))
    except ImportError as error:
        raise InputError(f"solver {solver} is not available here: {error}") from None
    except TypeError as error:
        raise InputError(f"solver {solver}: {error}") from None
    defaults = option_defaults(cls)
    return Entry(solver, {key: value for key, value in options.items() if value != defaults[key]}, **rest)


def seeds_from(value: Any, where: str = "seeds") -> tuple[int, ...]:
    """Return seeds: so many from 0, or those listed."""
    if isinstance(value, int) and not isinstance(value, bool):
        if value < 1:
            raise InputError(f"{where}: must be at least 1, got {value}")
        return tuple(range(value))
    return tuple(_typed(seed, int, where) for seed in _listed(value))


def _families(table: dict[str, Any], where: str) -> list[Source]:
    _known_keys(table, FAMILY_KEYS, where)
    for key in ("family", "tasks", "depots"):
        if key not in table:
            raise InputError(f"{where}: '{key}' is missing")
    names = [_typed(name, str, f"{where}.family") for name in _listed(table["family"])]
    combinations = _grid(_typed(table.get("parameters", {}), dict, f"{where}.parameters"))
    for name, combination in itertools.product(names, combinations):
        check_family(name, combination)
    tasks = _counts(table["tasks"], f"{where}.tasks")
    depots = _counts(table["depots"], f"{where}.depots")
    seeds = seeds_from(table.get("seeds", 1), f"{where}.seeds")
    return [FamilySource(*made) for made in itertools.product(names, tasks, depots, seeds, combinations)]


def _entries(table: dict[str, Any], study: dict[str, Any], changes: Mapping[str, Any], where: str) -> list[Entry]:
    _known_keys(table, SOLVER_KEYS, where)
    if "name" not in table:
        raise InputError(f"{where}: 'name' is missing")
    name = _typed(table["name"], str, f"{where}.name")

    def either(key: str, default: Any, read: Callable[[Any, str], Any]) -> Any:
        for holder, place in ((changes, key), (table, f"{where}.{key}"), (study, key)):
            if key in holder:
                return read(holder[key], place)
        return default

    threads = either("threads", 1, lambda value, at: _typed(value, int, at))
    iterations = either("iterations", None, lambda value, at: _typed(value, int, at))
    limits: tuple[float, ...] = either("time_limit", (10.0,), _limits)
    seeds: tuple[int, ...] = either("seeds", (0,), seeds_from)
    max_tasks = _typed(table["max_tasks"], int, f"{where}.max_tasks") if "max_tasks" in table else None
    return [
        checked_entry(
            name,
            options,
            seeds=seeds,
            time_limits=limits,
            threads=threads,
            iterations=iterations,
            max_tasks=max_tasks,
        )
        for options in _grid(_typed(table.get("options", {}), dict, f"{where}.options"))
    ]


def _grid(table: dict[str, Any]) -> list[dict[str, Any]]:
    """Return every combination of the lists in `table`; what is no list is a list of one."""
    return [dict(zip(table, values, strict=True)) for values in itertools.product(*map(_listed, table.values()))]


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _limits(value: Any, where: str) -> tuple[float, ...]:
    return tuple(float(_typed(limit, (int, float), where)) for limit in _listed(value))


def _counts(value: Any, where: str) -> list[int]:
    counts = [_typed(count, int, where) for count in _listed(value)]
    for count in counts:
        if count < 1:
            raise InputError(f"{where}: must be at least 1, got {count}")
    return counts


def _tables(data: dict[str, Any], key: str) -> list[dict[str, Any]]:
    tables = data.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise InputError(f"study: {key} must be tables, each headed [[{key}]]")
    return tables


def _known_keys(table: dict[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            raise InputError(f"{where}: unknown key '{key}'{suggestion(key, known)} (known: {', '.join(known)})")


def _typed(value: Any, kind: Any, where: str) -> Any:
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        wanted = {str: "a text", int: "a whole number", dict: "a table"}.get(kind, "a number")
        raise InputError(f"{where}: must be {wanted}, got {value!r}")
    return value
