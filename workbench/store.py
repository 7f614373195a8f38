"""Store: results on disk. The folder is the database: what exists is done, and nothing needs a lock.

    RUNS/study.json                                     what was asked: every run's path
    RUNS/environments/<digest>.json                     machine and versions, stated once
    RUNS/<instance>-<digest>/instance.json(.gz)         a copy of the instance
    RUNS/<instance>-<digest>/<solver>-<options>-s<seed>-t<limit>.json

Every file is written aside, flushed to disk and renamed, so a file that exists is whole unless the disk damaged it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from instances import InputError, Instance
from instances.disk import write_aside
from instances.files import read_instance, write_instance
from workbench.job import Job, folder_of
from workbench.run import Run

LARGE = 500
"""Nodes from which the copy of an instance is compressed."""


class Store:
    """One folder of runs."""

    def __init__(self, root: Path | str) -> None:
        self.root = Path(root)

    def create(self) -> None:
        """Make the folder and make sure it can be written to; InputError where not."""
        probe = _made(self.root) / ".probe"
        write_aside(probe, "")
        probe.unlink(missing_ok=True)

    def has(self, job: Job) -> bool:
        """Return whether a file is there for `job` (whole or not)."""
        return (self.root / job.path).exists()

    def get(self, path: str) -> Run:
        """Return the run stored at `path` (relative); InputError names a damaged or foreign file."""
        return read_run(self.root / path)

    def put(self, path: str, run: Run) -> None:
        """Store `run` at `path` (relative), whole or not at all."""
        write_aside(self.root / path, run.to_json())

    def put_environment(self, digest: str, environment: dict[str, Any]) -> None:
        """State machine and versions, once."""
        path = _made(self.root / "environments") / f"{digest}.json"
        if not path.exists():
            write_aside(path, json.dumps(environment, indent=1))

    def put_instance(self, instance: Instance) -> str:
        """Keep a copy of `instance` and return the name of its folder."""
        folder = folder_of(instance)
        if self._instance_path(folder) is None:
            _made(self.root / folder)
            name = "instance.json.gz" if instance.n_nodes > LARGE else "instance.json"
            write_instance(instance, self.root / folder / name)
        return folder

    def instance(self, folder: str) -> Instance:
        """Return the instance kept in `folder`; InputError where it is missing or not the one its folder names."""
        path = self._instance_path(folder)
        if path is None:
            raise InputError(f"{self.root / folder}: the copy of the instance is missing")
        instance = read_instance(path)
        if not folder.endswith(instance.digest):
            raise InputError(f"{path}: is not the instance of its folder (its digest is {instance.digest})")
        return instance

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

    def folders(self) -> list[str]:
        """Return the name of every instance's folder."""
        if not self.root.is_dir():
            raise InputError(f"{self.root}: is not a folder of runs")
        return sorted(path.parent.name for path in self.root.glob("*/instance.json*"))

    def paths(self) -> Iterator[str]:
        """Yield the path (relative) of every run's file, whole or not."""
        for folder in self.folders():
            for entry in sorted(os.listdir(self.root / folder)):
                if entry.endswith(".json") and not entry.startswith(".") and entry != "instance.json":
                    yield f"{folder}/{entry}"

    def _instance_path(self, folder: str) -> Path | None:
        candidates = (self.root / folder / name for name in ("instance.json", "instance.json.gz"))
        return next((path for path in candidates if path.exists()), None)


def read_run(path: Path) -> Run:
    """Return the run in the file `path`; InputError names a damaged or foreign file."""
    try:
        return Run.from_json(path.read_bytes())
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: is not a readable run ({error}); left alone") from None


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder for results ({error.strerror})") from None
    return folder
