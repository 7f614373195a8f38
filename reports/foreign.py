"""Foreign runs: results of others' programs, imported with ``workbench import``, and what must be known to read them.

Their routes were checked and costed like all others; their times, limits and bounds are as others state them. Wherever
a method is named, a foreign one carries MARK.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from instances.errors import one_line
from reports import numbers

MARK = "†"
"""Behind the name of a method that ran elsewhere."""
MOST_NAMES = 200
"""Characters of the methods' names in a sentence."""


def is_mere_claim(row: Mapping[str, Any]) -> bool:
    """Return whether a run (a row of the frame) is foreign and states neither routes nor a bound: nothing to judge."""
    right = row["status"] != "ERROR"
    return bool(row["foreign"] and right and row["routes"] is None and numbers.missing(row["bound"]))


def claim_without_routes(row: Mapping[str, Any]) -> str:
    """Return what such a run claims, in a sentence."""
    return (
        f"{row['method']} on {row['instance']}, seed {row['seed']}: a longest tour of "
        f"{numbers.cost(row['claimed_objective'])} s in {numbers.seconds(row['elapsed'])} s."
    )


def foreign_notes(runs: pd.DataFrame, claims: Sequence[str]) -> list[str]:
    """Return what must be known of the foreign among `runs` and of `claims` without routes, a sentence each."""
    notes = []
    foreign = runs[runs["foreign"].astype(bool)]
    if len(foreign):
        verb = "was" if len(foreign) == 1 else "were"
        names = one_line(", ".join(sorted(foreign["method"].unique())), MOST_NAMES)
        notes.append(
            f"{MARK} {numbers.counted(len(foreign), 'run')} of {names} {verb} made elsewhere and imported: routes were "
            "checked and costed here like all others; times were measured elsewhere, bounds are claims of others."
        )
    if claims:
        notes.append(
            f"{numbers.counted(len(claims), 'imported result')} without routes: what is claimed is kept, but it is no "
            "evidence and is not ranked."
        )
    return notes
