"""Stored placement runs, and what contradicts itself among them.

Nothing is computed here: whether points are inside and worth what is claimed is for `workbench check` to say.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from reports.stores import read_runs
from reports.tolerances import RELATIVE_ROUNDING


def read_placements(*folders: Path | str) -> tuple[list[dict[str, Any]], list[str]]:
    """Return the JSON values of every placement run below `folders`, its file as ``path``, and what was left alone."""
    runs, warnings = read_runs(*folders, problem="placement")
    return [{**run.flat(), "path": str(path)} for path, run in runs.items()], warnings


def worth_of(run: dict[str, Any]) -> float | None:
    """Return what a run's points are worth [nats] under the criterion that its study maximises; None without points."""
    if run["mutual_information"] is None or run["objective"] is None:
        return None
    return -float(run["objective"])


def placement_contradictions(runs: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    """Return (path, sentence) for each run worth more than a certificate that any run states for the same problem."""
    lowest: dict[str, dict[str, Any]] = {}
    for run in sorted(runs, key=lambda run: float(run["certificate"])):
        lowest.setdefault(run["instance"]["digest"], run)
    found = []
    for run in runs:
        value, least = worth_of(run), lowest[run["instance"]["digest"]]
        if value is not None and value > least["certificate"] + RELATIVE_ROUNDING * abs(least["certificate"]):
            own = run["certificate"] == least["certificate"]
            whose = "its own certificate" if own else f"the certificate stated by {least['label']}"
            sentence = (
                f"{run['label']} seed {run['seed']} on {run['instance']['name']} is worth {value!r} nats, above "
                f"{whose}, {least['certificate']!r}: one of the two is wrong"
            )
            found.append((run["path"], sentence))
    return found
