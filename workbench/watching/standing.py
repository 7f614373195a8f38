"""Standing: what the page about a running study shows, at a cost that leaves the machine to the study."""

from __future__ import annotations

import json
import threading
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from instances.errors import InputError
from reports.record import study_title
from workbench.jobs.progress import duration
from workbench.jobs.watching import Look, Watch
from workbench.watching.terminal import as_dict

if TYPE_CHECKING:
    import pandas as pd

    from reports.pages.watched import Standing

FRESH = 1.0
"""Seconds for which one look serves everybody who asks."""
REST = 19.0
"""The table is made again after so many times as long as it took: it costs a twentieth of a core at most."""


class Observer:
    """Looks at the study in `folder` for all who ask; InputError where it is no store."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._watch = Watch(folder)
        self._lock = threading.Lock()
        self._looked, self._look = 0.0, self._watch.look()
        self._due, self._made_of = 0.0, -1
        self._summary: pd.DataFrame | None = None

    def page(self) -> str:
        """Return the page as HTML."""
        from reports.pages.watched import watched_page

        return watched_page(self._standing()[1])

    def data(self) -> str:
        """Return the counts, and what changes of the page, as one JSON object."""
        from reports.pages.watched import standing_text, version_of

        look, standing = self._standing()
        html = standing_text(standing)
        latest = [asdict(run) for run in look.latest]
        return json.dumps(as_dict(look) | {"latest": latest, "version": version_of(html), "html": html})

    def _standing(self) -> tuple[Look, Standing]:
        import pandas as pd

        from reports.pages.watched import LATEST, Standing

        with self._lock:
            now = time.monotonic()
            if now - self._looked > FRESH:
                self._look, self._looked = self._watch.look(), now
            look, summary = self._look, self._summarised(self._look, now)
        latest = pd.DataFrame([asdict(run) for run in look.latest], columns=[column.key for column in LATEST])
        return look, Standing(
            study_title([self._folder]),
            _facts(look),
            look.sentence.capitalize() + ".",
            {label: dict(counts) for label, counts in look.census.by_solver.items()},
            latest,
            summary,
            look.census.damaged,
        )

    def _summarised(self, look: Look, now: float) -> pd.DataFrame | None:
        """Return the summary of routing runs, made again where runs are new and it has rested long enough."""
        stored = look.census.stored + look.census.foreign
        if stored == self._made_of or now < self._due:
            return self._summary
        from reports.metrics import summary
        from reports.stores import read_stores

        try:
            runs = read_stores(self._folder).runs
            self._summary = summary(runs) if len(runs) else None
        except InputError:
            self._summary = None
        self._made_of, self._due = stored, now + (1 + REST) * (time.monotonic() - now)
        return self._summary


def _facts(look: Look) -> list[tuple[str, str]]:
    counts: dict[str, Any] = {
        "Done": f"{look.census.planned - look.census.missing} of {look.census.planned}",
        "Running": str(len(look.running)),
        "Failed": str(look.census.failed),
        "Time left": "–" if look.left is None else f"about {duration(look.left)}",
    }
    return list(counts.items())
