"""Study: items × methods × seeds × limits, read from TOML. Its keys: `jobs.study_table` and `problems.tables`."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from formulations.limits import Limits
from instances.declared.reading import read_declared
from instances.disk import read_toml
from instances.errors import InputError
from instances.instance import check_name
from workbench.jobs.job import Job
from workbench.jobs.problem import Problem, Source
from workbench.jobs.study_table import Changes, Limited, MethodTable, listed, seeds_of
from workbench.jobs.tables import MOST_RUNS, grid


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
    for key in changes or {}:
        if key in ("threads", "iterations") and key not in problem.limits:
            raise InputError(f"compare: --{key} cannot be given with a {problem.name} study")
    flags = read_declared(Changes, changes or {})
    said = read_declared(problem.study, data)
    asked = {"name": name, **data, **(changes or {})}
    check_name(asked["name"])  # its results go into a folder of this name
    sources = tuple(itertools.islice(problem.sources(said, base), MOST_RUNS + 1))
    tables: list[MethodTable] = getattr(said, problem.entries)
    entries = [
        each
        for number, table in enumerate(tables, 1)
        for each in _entries(problem, table, (flags, table, said), f"[[{problem.entries}]] {number}")
    ]
    if not entries:
        raise InputError(f"study: names no {problem.entries} ([[{problem.entries}]] with name = …)")
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


def _entries(problem: Problem[Any], table: MethodTable, holders: Sequence[Limited], where: str) -> list[Entry]:
    """Return a method with every combination of its options; the first of `holders` that says a limit sets it."""

    def first(key: str, default: Any) -> Any:
        said = (getattr(holder, key, None) for holder in holders)
        return next((value for value in said if value is not None), default)

    limits = {
        "threads": first("threads", 1),
        "iterations": first("iterations", None),
        "time_limits": tuple(listed(first("time_limit", problem.default_limit))),
        "seeds": seeds_of(first("seeds", 1)),
        "max_tasks": table.max_tasks,
    }
    combinations = grid(table.options, f"{where} options")
    return [checked_entry(problem, table.name, options, **limits) for options in combinations]
