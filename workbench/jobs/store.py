"""Store: results on disk. The folder is the database: what exists is done, and nothing needs a lock.

    RUNS/study.json                                     what was asked: every run's path
    RUNS/environments/<digest>.json                     machine and versions, stated once
    RUNS/<item>-<digest>/…                              what is solved: instance.json(.gz), problem.json, …
    RUNS/<item>-<digest>/<method>-<options>-s<seed>-t<limit>.json

Every file is written aside, flushed to disk and renamed, so a file that exists is whole unless the disk damaged it.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from instances.disk import write_aside
from instances.errors import InputError
from reports.record import Run, read_run
from workbench.jobs.job import Job, folder_of
from workbench.jobs.problem import Named, Problem
from workbench.settings import make_folder

RUN_FILE = re.compile(r"[^.].*-s\d+-t[^/]*\.json")
"""How the file of a run is named (`Job.path`), unlike anything else in its folder."""
KIND = "a folder for results"


class Store:
    """One folder of runs."""

    def __init__(self, root: Path | str) -> None:
        self.root = Path(root)

    def create(self) -> None:
        """Make the folder and make sure it can be written to; InputError where not."""
        probe = make_folder(self.root, KIND) / ".probe"
        write_aside(probe, "")
        probe.unlink(missing_ok=True)

    def has(self, job: Job) -> bool:
        """Return whether a file is there for `job` (whole or not)."""
        return (self.root / job.path).exists()

    def get(self, path: str) -> Run:
        """Return the run stored at `path` (relative); InputError names a damaged or foreign file."""
        try:
            return read_run(self.root / path)
        except InputError as error:
            raise InputError(f"{self.root / path}: {error}; left alone") from None

    def put(self, path: str, run: Run) -> None:
        """Store `run` at `path` (relative), whole or not at all."""
        write_aside(self.root / path, run.to_json())

    def put_environment(self, digest: str, environment: dict[str, Any]) -> None:
        """State machine and versions, once."""
        path = make_folder(self.root / "environments", KIND) / f"{digest}.json"
        if not path.exists():
            write_aside(path, json.dumps(environment, indent=1))

    def put_item(self, problem: Problem[Any], item: Named) -> str:
        """Keep a copy of `item`, where there is none yet, and return the name of its folder."""
        folder = folder_of(item)
        problem.write(item, make_folder(self.root / folder, KIND))
        return folder

    def put_study(self, asked: dict[str, Any], paths: Iterable[str]) -> None:
        """State what was asked, together with what had been asked of this folder before."""
        planned = list(dict.fromkeys([*self.planned(), *paths]))
        write_aside(self.root / "study.json", json.dumps({"schema": 1, "study": asked, "runs": planned}))

    def planned(self) -> list[str]:
        """Return the path (relative) of every run asked for so far."""
        path = self.root / "study.json"
        if not path.exists():
            return []
        try:
            return [str(run) for run in json.loads(path.read_bytes())["runs"]]
        except (OSError, ValueError, KeyError, TypeError):
            raise InputError(f"{path}: is damaged or not ours; move it away to go on") from None

    def paths(self) -> Iterator[str]:
        """Yield the path (relative) of every run's file, whole or not."""
        if not self.root.is_dir():
            raise InputError(f"{self.root}: is not a folder of runs")
        for folder in sorted(path for path in self.root.iterdir() if path.is_dir()):
            for name in sorted(os.listdir(folder)):
                if RUN_FILE.fullmatch(name):
                    yield f"{folder.name}/{name}"
