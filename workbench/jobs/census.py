"""Census: how far a study has got, counted from its folder."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from instances.errors import InputError
from workbench.jobs.store import Store


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


def census(folder: Path) -> Census:
    """Count the runs of the store in `folder`; InputError where it is none."""
    store = Store(folder)
    paths = list(store.paths())
    planned = store.planned()
    by_solver: dict[str, Counter[str]] = {}
    damaged, stale, foreign = [], 0, 0
    for path in paths:
        try:
            run = store.get(path)
        except InputError as error:
            damaged.append(str(error))
            continue
        by_solver.setdefault(run.label, Counter())[run.status] += 1
        stale += run.stale
        foreign += run.foreign
    return Census(len(planned), len(set(planned).difference(paths)), by_solver, stale, foreign, tuple(damaged))
