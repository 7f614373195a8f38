"""What the trees over tours and over arcs mean by a proof: how near it comes, why a tree ends, and the result."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Any

from formulations.routing.recorder import Recorder
from formulations.routing.solver import Result

TOLERANCE = 1e-7
"""Of the longest tour: routes better by less are neither looked for nor excluded."""


class StoppedBy(StrEnum):
    """Why a tree stopped growing, in the words of `Result.stopped_by`."""

    PROOF = "proof"
    """No routes of cost ≤ cap are left."""
    TIME = "time"
    ITERATIONS = "iterations"
    MEMORY = "memory"
    """Nodes were left aside whose tours are too many for the label store, whatever else ended it."""
    STUCK = "stuck"
    """Cases were left aside whose linear programme could not be solved, or whose routes UAVs cannot quite fly."""


def left_open(recorder: Recorder) -> float:
    """Return what a proof leaves open [s]."""
    return 0.0 if recorder.routes is None else 2 * TOLERANCE * recorder.objective


def result_of(recorder: Recorder, ended: str, counts: Mapping[str, Any]) -> Result:
    """Write the result of a tree that ended so; a proof without routes is one that there are none."""
    proved = ended == StoppedBy.PROOF
    if proved and recorder.routes is None:
        return recorder.infeasible(**counts)
    return recorder.result(ended, proved=proved, tolerance=left_open(recorder), **counts)
