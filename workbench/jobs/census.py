"""Census: how far a study has got, counted from its folder; again and again at the cost of what is new."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from instances.errors import InputError
from workbench.jobs.store import Store, Version

FAILED = ("ERROR", "KILLED")
"""Endings of a run that count as failures."""


@dataclass(frozen=True)
class Brief:
    """What is kept of a stored run to count it and to name it: times in seconds, `changed` [ns] of its file."""

    instance: str
    label: str
    seed: int
    status: str
    objective: float | None
    elapsed: float
    wall: float | None
    stale: bool
    foreign: bool
    changed: int


@dataclass(frozen=True)
class Census:
    """Counts of a store.

    planned : runs asked for; missing : of these not stored; by_solver : label → status → stored runs; stale : stored
    runs that other code of ours than today's made; foreign : imported runs; damaged : a sentence for each file that is
    not the run its name says.
    """

    planned: int
    missing: int
    by_solver: dict[str, Counter[str]]
    stale: int
    foreign: int
    damaged: tuple[str, ...]

    @property
    def stored(self) -> int:
        """Number of stored runs of ours."""
        return sum(sum(counts.values()) for counts in self.by_solver.values()) - self.foreign

    @property
    def failed(self) -> int:
        """Number of stored runs that were killed or ended in error."""
        return sum(counts[status] for counts in self.by_solver.values() for status in FAILED)


class Counting:
    """The store in `folder`, read again where files are new; it is only looked at, and never claimed."""

    def __init__(self, folder: Path) -> None:
        self.store = Store(folder)
        self.planned: list[str] = []
        self.runs: dict[str, Brief] = {}
        self._damaged: dict[str, str] = {}
        self._versions: dict[str, Version | None] = {}

    def census(self) -> Census:
        """Look at what is new and return the counts; InputError where `folder` is no store."""
        paths = list(self.store.paths())
        self.planned = self.store.planned()
        versions = {path: self.store.version(path) for path in paths}
        for path in paths:
            if versions[path] != self._versions.get(path):
                self._read(path, versions[path])
        self.runs = {path: self.runs[path] for path in paths if path in self.runs}
        self._versions = versions
        by_solver: dict[str, Counter[str]] = {}
        for run in self.runs.values():
            by_solver.setdefault(run.label, Counter())[run.status] += 1
        stale, foreign = (sum(getattr(run, what) for run in self.runs.values()) for what in ("stale", "foreign"))
        damaged = tuple(self._damaged[path] for path in paths if path in self._damaged)
        return Census(len(self.planned), len(set(self.planned).difference(paths)), by_solver, stale, foreign, damaged)

    def _read(self, path: str, version: Version | None) -> None:
        self.runs.pop(path, None)
        self._damaged.pop(path, None)
        try:
            run = self.store.get(path)
        except InputError as error:
            self._damaged[path] = str(error)
            return
        told = (run.instance["name"], run.label, run.seed, run.status, run.objective, run.elapsed or 0.0)
        self.runs[path] = Brief(*told, run.wall_elapsed, run.stale, run.foreign, version[1] if version else 0)


def census(folder: Path) -> Census:
    """Count the runs of the store in `folder`; InputError where it is none."""
    return Counting(folder).census()
