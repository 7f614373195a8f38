"""Watching: what a study is doing, seen from its folder alone, beside whoever runs it; nothing is locked or written."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from workbench.jobs.census import Brief, Census, Counting
from workbench.jobs.claims import Claims
from workbench.jobs.progress import STARTING, duration

LATEST = 12
"""Runs named, the last ones stored."""
_NAMED = re.compile(r"(.*)-s\d+(-t([0-9.e+-]+)[^/]*)\.json")
"""The name of a run's file (`Job.path`): what runs, its seed, its limit [s]."""


@dataclass(frozen=True)
class Look:
    """One look at a study: its counts, the paths at work on, the time left [s] if any is, the last runs stored."""

    census: Census
    running: tuple[str, ...]
    left: float | None
    latest: tuple[Brief, ...]

    @property
    def complete(self) -> bool:
        """Whether all that was asked for is stored, and nothing is run again."""
        return self.census.planned > 0 and not self.census.missing and not self.running

    @property
    def sentence(self) -> str:
        """How far it has got, for people."""
        counts = self.census
        parts = [f"{counts.planned - counts.missing} of {counts.planned} runs done", f"{len(self.running)} running"]
        parts += [f"{counts.failed} failed"] if counts.failed else []
        parts += [f"{len(counts.damaged)} damaged"] if counts.damaged else []
        parts += [f"about {duration(self.left)} left"] if self.left is not None else []
        parts += ["complete"] if self.complete else [] if self.running else ["nobody is at work"]
        return ", ".join(parts)


class Watch:
    """Looks at the store in `folder`, again and again."""

    def __init__(self, folder: Path) -> None:
        self._counting = Counting(folder)
        self._claims = Claims()

    def look(self) -> Look:
        """Return what is seen now; InputError where `folder` is no store."""
        counts = self._counting.census()
        planned, runs = self._counting.planned, self._counting.runs
        folders = sorted({path.rpartition("/")[0] for path in planned})
        held = {
            f"{folder}/{name}" for folder in folders for name in self._claims.held(self._counting.store.root / folder)
        }
        running = tuple(path for path in planned if path in held)
        left = self._left([path for path in planned if path not in runs or path in held], len(running))
        latest = sorted(runs.values(), key=lambda run: run.changed, reverse=True)
        return Look(counts, running, left, tuple(latest[:LATEST]))

    def _left(self, todo: list[str], parallel: int) -> float | None:
        """Return the time left [s] for `todo`, `parallel` at once: of each what its like took on average, or its limit.

        None where nothing runs.
        """
        took = defaultdict(list)
        for path, run in self._counting.runs.items():
            if run.wall is not None:
                took[_kind(path)[0]].append(run.wall)
        expected = 0.0
        for path in todo:
            kind, limit = _kind(path)
            expected += sum(took[kind]) / len(took[kind]) if took[kind] else limit + STARTING
        return expected / parallel if parallel else None


def _kind(path: str) -> tuple[str, float]:
    """Return what the run at `path` is like whatever its item and seed, and its limit [s] (0 where it states none)."""
    named = _NAMED.fullmatch(path.rpartition("/")[2])
    try:
        return (named[1] + named[2], float(named[3])) if named else (path, 0.0)
    except ValueError:
        return path, 0.0
