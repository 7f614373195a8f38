"""Study: items × methods × seeds × limits, read from TOML.

name = "mine"
problem = "routing"              # or placement, moving-cost; the keys of each are said in workbench.problems
seeds = 3                        # so many (0, 1, 2), or a list
time_limit = 10                  # [s], or a list
threads = 1

[[methods]]                      # [[solvers]] where the problem is routing
name = "nlp"                     # seeds, time_limit, threads, iterations here override those above
options = { starts = [4, 8] }    # a grid: every list is tried in every combination
max_tasks = 200                  # larger items are not given to this method
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from formulations.limits import LARGEST_SEED, Limits
from instances.disk import read_toml
from instances.errors import InputError
from instances.instance import check_name
from workbench.jobs.job import Job
from workbench.jobs.problem import Problem, Source
from workbench.jobs.tables import MOST_RUNS, grid, known_keys, listed, seeds_from, tables_of, typed

STUDY_KEYS = ("name", "problem", "description", "seeds", "time_limit")
ENTRY_KEYS = ("name", "options", "seeds", "time_limit", "max_tasks")


@dataclass(frozen=True)
class Entry:
    """One method of a study with one set of options (those that differ from the default), its seeds and limits [s]."""

    method: str
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

    def jobs(self, folder: str, size: int) -> Iterator[Job]:
        """Yield this entry's jobs on the item of `size` tasks kept in `folder`."""
        if self.max_tasks is not None and size > self.max_tasks:
            return
        for limit, seed in itertools.product(self.time_limits, self.seeds):
            yield Job(folder, self.method, self.options, seed, limit, self.threads, self.iterations)


@dataclass(frozen=True)
class Study:
    """What to run: a problem, where its items come from, and the methods' entries; `asked` is what the file says.

    Raises InputError where these are more than MOST_RUNS runs.
    """

    name: str
    problem: Problem[Any]
    sources: tuple[Source[Any], ...]
    entries: tuple[Entry, ...]
    asked: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        runs = max(1, len(self.sources)) * sum(len(each.seeds) * len(each.time_limits) for each in self.entries)
        if runs > MOST_RUNS:
            raise InputError(
                f"study {self.name}: asks for {runs} runs, more than {MOST_RUNS}; make several studies of it"
            )

    @property
    def plugins(self) -> list[str]:
        """What it names that is not built in: code of others, which running it imports."""
        methods = [each.method for each in self.entries if each.method not in self.problem.methods.built_in]
        makers = [getattr(source, "plugin", "") for source in self.sources]
        return [name for name in dict.fromkeys([*methods, *makers]) if name]

    def with_files(self, paths: Iterable[Path]) -> Study:
        """Return the study with more items: files, or folders of them."""
        return replace(self, sources=(*self.sources, *self.problem.from_files(paths)))


def shipped_studies() -> dict[str, Path]:
    """Return the studies that come with the workbench: name → file."""
    folder = Path(str(files("workbench") / "studies"))
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def load_tables(path: Path) -> dict[str, Any]:
    """Return what the study file says; InputError where it cannot be read."""
    return read_toml(path)


def study_from(
    data: Mapping[str, Any], problem: Problem[Any], *, name: str, base: Path, changes: Mapping[str, Any] | None = None
) -> Study:
    """Return the study of `problem` written as `data`, its files relative to `base`; InputError says what is wrong.

    changes : seeds, time_limit or threads that take the place of those in `data`, each method's included.
    """
    changes = changes or {}
    known_keys(data, (*STUDY_KEYS, *problem.limits, *problem.keys, problem.entries), "study")
    for key in changes:
        if key in ("threads", "iterations") and key not in problem.limits:
            raise InputError(f"compare: --{key} cannot be given with a {problem.name} study")
    asked = {"name": name, **data, **changes}
    check_name(typed(asked["name"], str, "name"))  # its results go into a folder of this name
    for key, read in READERS.items():  # also what no method takes, as every one has its own
        if key in data:
            read(data[key], key)
    sources = tuple(itertools.islice(problem.sources(data, base), MOST_RUNS + 1))
    entries: list[Entry] = []
    for number, table in enumerate(tables_of(data, problem.entries), 1):
        entries += _entries(problem, table, data, changes, f"{problem.entries}[{number}]")
    if not entries:
        raise InputError(f"study: names no {problem.entries} ([[{problem.entries}]] with name = …)")
    typed(data.get("description", ""), str, "description")  # for people: it is checked and stored, and no more
    return Study(asked["name"], problem, sources, tuple(entries), asked)


def checked_entry(problem: Problem[Any], method: str, options: dict[str, Any], **rest: Any) -> Entry:
    """Return an Entry whose method and options are known to exist; InputError, or the reason it is not available.

    Code of others is not imported here: the child process that does says what is wrong with it.
    """
    try:
        asked = problem.methods.asked(method, options)
    except ImportError as error:
        raise InputError(f"{problem.methods.kind} {method} is not available here: {error}") from None
    return Entry(method, asked, **rest)


def _entries(
    problem: Problem[Any], table: dict[str, Any], study: Mapping[str, Any], changes: Mapping[str, Any], where: str
) -> list[Entry]:
    known_keys(table, (*ENTRY_KEYS, *problem.limits), where)
    if "name" not in table:
        raise InputError(f"{where}: 'name' is missing")
    name = typed(table["name"], str, f"{where}.name")

    def either(key: str, default: Any) -> Any:
        for holder, place in ((changes, key), (table, f"{where}.{key}"), (study, key)):
            if key in holder:
                return READERS[key](holder[key], place)
        return default

    given = {
        "threads": either("threads", 1),
        "iterations": either("iterations", None),
        "time_limits": either("time_limit", (problem.default_limit,)),
        "seeds": either("seeds", (0,)),
        "max_tasks": typed(table["max_tasks"], int, f"{where}.max_tasks") if "max_tasks" in table else None,
    }
    combinations = grid(typed(table.get("options", {}), dict, f"{where}.options"), f"{where}.options")
    return [checked_entry(problem, name, options, **given) for options in combinations]


def _limits(value: Any, where: str) -> tuple[float, ...]:
    return tuple(float(typed(limit, (int, float), where)) for limit in listed(value))


def _whole(value: Any, where: str) -> int:
    return int(typed(value, int, where))


READERS: dict[str, Callable[[Any, str], Any]] = {
    "threads": _whole,
    "iterations": _whole,
    "time_limit": _limits,
    "seeds": seeds_from,
}
"""Key that a study and each of its methods may have → how it is read."""
