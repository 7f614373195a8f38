"""Store: results on disk. The folder is the database: what exists is done.

    RUNS/study.json                                     what was asked: every run's path
    RUNS/environments/<digest>.json                     machine and versions, stated once
    RUNS/<item>-<digest>/…                              what is solved: instance.json(.gz), problem.json, …
    RUNS/<item>-<digest>/<method>-<options>-s<seed>-t<limit>.json

Every file is written aside, flushed to disk and renamed, so a file that exists is whole unless the disk damaged it.
Several processes may share a store: `claims` say who runs what. A plug-in has the rights of its user: what it deletes,
replaces or closes while a study runs is put there again, as far as this process had put it there.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import secrets
import threading
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from instances.disk import write_aside
from instances.errors import InputError
from reports.record import ITEM_FILES, Run, read_json, read_run
from workbench.jobs.claims import Claims
from workbench.jobs.job import Job, file_safe, folder_of
from workbench.jobs.problem import Named, Problem, Source
from workbench.jobs.rows import Rows
from workbench.settings import make_folder

RUN_FILE = re.compile(r"[^.].*-s\d+-t[^/]*\.json")
"""How the file of a run is named (`Job.path`), unlike anything else in its folder."""
KIND = "a folder for results"
PROBE = bytes(1 << 14)
"""What is written to learn whether a store can be written to: as much as a run takes."""

Version = tuple[int, int, int]
"""Which file lies at a path: inode, time of last change [ns], size. Another one once a run is stored again."""


class Store:
    """One folder of runs, and what this process has put there."""

    def __init__(self, root: Path | str) -> None:
        self.root = Path(root)
        self._rows = Rows()
        self._environments: dict[str, dict[str, Any]] = {}
        self._sources: dict[str, tuple[Problem[Any], Source[Any]]] = {}
        self._kept: dict[str, dict[str, Version | None]] = {}
        self._asked: tuple[dict[str, Any], list[str]] | None = None
        self._restoring = threading.Lock()

    def create(self) -> None:
        """Make the folder and make sure it can be written to; InputError where not."""
        probe = make_folder(self.root, KIND) / f".{secrets.token_hex(4)}.probe"
        write_aside(probe, PROBE)
        probe.unlink(missing_ok=True)

    def has(self, job: Job) -> bool:
        """Return whether a file is there for `job` (whole or not)."""
        return (self.root / job.path).exists()

    def version(self, path: str) -> Version | None:
        """Return which file lies at `path` (relative); None where there is none."""
        try:
            found = os.stat(self.root / path)
        except (OSError, ValueError):
            return None
        return found.st_ino, found.st_mtime_ns, found.st_size

    def get(self, path: str) -> Run:
        """Return the run stored at `path` (relative); InputError names a damaged file, a foreign one, another run's."""
        try:
            run = read_run(self.root / path)
            if _path_of(run) != path:
                raise InputError("holds another run than its name and its folder say")
            return run
        except InputError as error:
            raise InputError(f"{self.root / path}: {error}; left alone") from None

    def put(self, path: str, run: Run) -> None:
        """Store `run` at `path` (relative), whole or not at all; InputError where that cannot be done."""
        row = run.to_json().encode()
        folder = (self.root / path).parent
        gone = not folder.is_dir()
        self._make_way(folder)
        self._write(path, row)
        self._rows.remember(path, row)
        if gone:
            self.restore()

    def put_environment(self, digest: str, environment: dict[str, Any]) -> None:
        """State machine and versions, once."""
        self._environments[digest] = environment
        path = self.root / "environments" / f"{digest}.json"
        if not path.exists():
            self._make_way(path.parent)
            write_aside(path, json.dumps(environment, indent=1))

    def put_item(self, problem: Problem[Any], item: Named) -> str:
        """Keep a copy of `item`, where there is none yet, and return the name of its folder."""
        folder = folder_of(item)
        self._make_way(self.root / folder)
        problem.write(item, self.root / folder)
        return folder

    def keep_items(self, problem: Problem[Any], sources: Mapping[str, Source[Any]]) -> None:
        """Keep a copy of the item of every folder, and remember its source, to make it again where the copy is lost."""
        for folder, source in sources.items():
            self._sources[folder] = problem, source
            self._keep_item(folder)

    def item(self, folder: str) -> Any:
        """Return the item of `folder`, made again where its copy is gone or damaged; InputError where it cannot be."""
        with contextlib.suppress(InputError):
            return self._sources[folder][0].read(self.root / folder)
        with self._restoring:
            return self._renewed(folder)

    def put_study(self, asked: dict[str, Any], paths: Iterable[str]) -> None:
        """State what was asked, together with what had been asked of this folder before, by whatever process."""
        self._asked = asked, list(paths)
        path = self.root / "study.json"
        with Claims().holding(path):
            planned = list(dict.fromkeys([*self.planned(), *self._asked[1]]))
            write_aside(path, json.dumps({"schema": 1, "study": asked, "runs": planned}))

    def planned(self) -> list[str]:
        """Return the path (relative) of every run asked for so far."""
        path = self.root / "study.json"
        if not path.exists():
            return []
        with contextlib.suppress(InputError, KeyError, TypeError):
            runs = read_json(path)["runs"]
            if isinstance(runs, list) and all(isinstance(run, str) for run in runs):
                return runs
        raise InputError(f"{path}: is damaged or not ours; move it away to go on")

    def paths(self) -> Iterator[str]:
        """Yield the path (relative) of every run's file, whole or not."""
        if not self.root.is_dir():
            raise InputError(f"{self.root}: is not a folder of runs")
        try:
            for folder in sorted(path for path in self.root.iterdir() if path.is_dir()):
                for name in sorted(os.listdir(folder)):
                    if RUN_FILE.fullmatch(name):
                        yield f"{folder.name}/{name}"
        except OSError as error:
            raise InputError(f"{self.root}: cannot be read ({error.strerror or error})") from None

    def restore(self) -> None:
        """Put again what this process had put here and something has deleted since; InputError where it cannot."""
        with self._restoring:
            self._make_way(self.root)
            for digest, environment in self._environments.items():
                self.put_environment(digest, environment)
            if self._asked is not None and not (self.root / "study.json").is_file():
                _move_aside(self.root / "study.json")
                self.put_study(*self._asked)
            for folder, kept in self._kept.items():
                if self._item_files(folder) != kept:
                    with contextlib.suppress(InputError):  # its source is gone too: its rows are kept all the same
                        self._renewed(folder)
            for path in self._rows:
                if not (target := self.root / path).is_file():
                    self._make_way(target.parent)
                    self._write(path, self._rows[path])

    def usable(self) -> bool:
        """Return whether the store can still be written to."""
        try:
            self._make_way(self.root)
            self.create()
        except InputError:
            return False
        return True

    def _write(self, path: str, row: bytes) -> None:
        target = self.root / path
        if not target.is_file():
            _move_aside(target)
        write_aside(target, row)

    def _keep_item(self, folder: str) -> None:
        problem, source = self._sources[folder]
        if not any((self.root / folder / name).is_file() for name in ITEM_FILES.get(problem.name, ())):
            item = source.load()
            if folder_of(item) != folder:
                raise InputError(f"{self.root / folder}: its {problem.item} cannot be made again: its source changed")
            self.put_item(problem, item)
        problem.keep_beside(source, self.root / folder)
        self._kept[folder] = self._item_files(folder)

    def _renewed(self, folder: str) -> Any:
        """Return the item of `folder`, having made it again where it cannot be read."""
        problem, source = self._sources[folder]
        try:
            item = problem.read(self.root / folder)
        except InputError:
            for name in ITEM_FILES.get(problem.name, ()):
                _move_aside(self.root / folder / name)
            self._keep_item(folder)
            item = problem.read(self.root / folder)
        problem.keep_beside(source, self.root / folder)
        self._kept[folder] = self._item_files(folder)
        return item

    def _item_files(self, folder: str) -> dict[str, Version | None]:
        """Return which files lie beside the runs of `folder`."""
        try:
            names = os.listdir(self.root / folder)
        except OSError:
            return {}
        return {
            name: self.version(f"{folder}/{name}")
            for name in names
            if not name.startswith(".") and not RUN_FILE.fullmatch(name)
        }

    def _make_way(self, folder: Path) -> None:
        """Make `folder`; what is no folder in its place is moved aside, the permission to write there is taken back."""
        for place in (self.root, folder):
            if not place.is_dir():
                _move_aside(place)
                make_folder(place, KIND)
            if not os.access(place, os.W_OK | os.X_OK):
                with contextlib.suppress(OSError):
                    place.chmod(place.stat().st_mode | 0o700)


def _path_of(run: Run) -> str:
    """Return where `run` belongs, relative to a store; "" where its names cannot be those of files."""
    try:
        folder = f"{file_safe(run.instance['name'])}-{run.instance['digest']}"
        threads = 1 if run.threads is None else run.threads
        return Job(folder, run.solver, run.options, run.seed, run.time_limit, threads, run.iterations).path
    except UnicodeEncodeError:
        return ""


def _move_aside(path: Path) -> None:
    """Give whatever lies at `path` a hidden name beside it; nothing where nothing lies there."""
    try:
        path.rename(path.with_name(f".{path.name}.{secrets.token_hex(4)}.displaced"))
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise InputError(f"{path}: cannot be moved aside ({error.strerror or error})") from None
