"""Gaps: how far a run's routes are from the best known, from the best found and from the best proved bound.

    gap to best known  = (value − best known) / best known      (negative: better than what was known)
    gap to best found  = (value − best found) / best found      (best found: over the runs of the frame)
    gap to best bound  = (value − best bound) / value           (as a solver's own gap; 0 is a proof)

Where the reference is 0 the gap is 0 for a value of 0 and infinite otherwise.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from instances.arrays import Floats
from reports.proofs import believed_bounds


def references(runs: pd.DataFrame) -> pd.DataFrame:
    """Return what runs are measured against, a row an instance (index: digest).

    Columns [s]: best_known; best_found, the least re-computed cost; best_bound, the greatest bound that can be believed
    (`reports.proofs`), and bound_by, the method that claims it; best, the lesser of best_known and best_found.
    """
    groups = runs.groupby("digest")
    found = pd.DataFrame({"best_known": groups["best_known"].min(), "best_found": groups["value"].min()})
    found["best"] = found[["best_known", "best_found"]].min(axis=1)
    bounds = runs[["digest", "method"]].assign(bound=believed_bounds(runs)).dropna(subset=["bound"])
    greatest = bounds.sort_values(["bound", "method"], ascending=[False, True]).drop_duplicates("digest")
    greatest = greatest.set_index("digest")
    return found.assign(best_bound=greatest["bound"], bound_by=greatest["method"])


def with_gaps(runs: pd.DataFrame) -> pd.DataFrame:
    """Return `runs` with the columns of `references` and `gap_known`, `gap_found`, `gap_bound`, `gap_best`.

    `gap_best` is to the lesser of best known and best found. Not a number where a run has no (right) routes. A frame
    that has them is returned as it is, so that a part of one keeps being measured against the best of the whole.
    """
    if "gap_best" in runs:
        return runs
    known = runs.drop(columns=["best_known"]).merge(references(runs), left_on="digest", right_index=True, how="left")
    value = known["value"].to_numpy(float)
    for column, reference in (("gap_known", "best_known"), ("gap_found", "best_found"), ("gap_best", "best")):
        known[column] = relative_gap(value, known[reference].to_numpy(float))
    bound = np.minimum(known["best_bound"].to_numpy(float), value)
    known["gap_bound"] = np.divide(value - bound, value, out=np.where(np.isnan(bound), np.nan, 0.0), where=value > 0)
    known.attrs = runs.attrs
    return known


def relative_gap(value: Floats, reference: Floats) -> Floats:
    """Return (value − reference) / reference; where the reference is 0, 0 for a value of 0, else infinite."""
    difference = value - reference
    at_zero = np.where(difference == 0, 0.0, np.where(np.isnan(difference), np.nan, np.inf))
    return np.divide(difference, reference, out=at_zero, where=reference != 0)
