"""Census: how far a study has got, counted from the folder without loading a run into objects."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from formulations.routing.solver import Status
from reports.placement_store import PROBLEM_FILE
from workbench.store import Store


@dataclass(frozen=True)
class Census:
    """Counts of a store.

    planned : runs asked for; missing : of these not stored; by_solver : label → status → stored runs;
    damaged : files that are no runs, by path.
    """

    planned: int
    missing: int
    by_solver: dict[str, Counter[str]]
    damaged: tuple[str, ...]

    @property
    def stored(self) -> int:
        """Number of stored runs."""
        return sum(sum(counts.values()) for counts in self.by_solver.values())


def census(folder: Path) -> Census:
    """Count the runs of the store in `folder`; InputError where it is none."""
    store = Store(folder)
    paths = [*store.paths(), *_placements(folder)]
    planned = store.planned()
    by_solver: dict[str, Counter[str]] = {}
    damaged = []
    for path in paths:
        try:
            run = json.loads((folder / path).read_bytes())
            counts = by_solver.setdefault(run["label"], Counter())
            counts[run["status"] if run.get("problem") == "placement" else Status(run["status"])] += 1
        except (OSError, ValueError, KeyError, TypeError):
            damaged.append(path)
    return Census(len(planned), len(set(planned).difference(paths)), by_solver, tuple(damaged))


def _placements(folder: Path) -> list[str]:
    """Return the path (relative) of every placement run's file."""
    places = sorted(path.parent for path in folder.glob(f"*/{PROBLEM_FILE}"))
    files = [path for place in places for path in sorted(place.glob("[!.]*.json")) if path.name != PROBLEM_FILE]
    return [str(path.relative_to(folder)) for path in files]
