"""Time to target: how long until a run's routes were within a given share of the best, or proved optimal."""

from __future__ import annotations

import numpy as np
import pandas as pd

from reports.metrics.gaps import with_gaps
from reports.metrics.integrals import finished_traces
from reports.tolerances import RELATIVE_ROUNDING


def time_to_target(runs: pd.DataFrame, targets: list[float]) -> pd.DataFrame:
    """Return when each run first had routes within each target of the best, a row a run, a column a target [s].

    A target is a gap to the lesser of best known and best found (0.01: within 1 %). Infinite where never reached.
    """
    known = with_gaps(runs)
    levels = np.array(targets)
    times = np.full((len(known), len(targets)), np.inf)
    for i, (trace, best) in enumerate(zip(finished_traces(known), known["best"], strict=True)):
        if len(trace) and np.isfinite(best):
            z = np.where(np.isnan(trace[:, 1]), np.inf, trace[:, 1])
            reached = z[:, None] <= best * (1 + levels) * (1 + RELATIVE_ROUNDING)
            times[i] = np.where(reached.any(axis=0), trace[reached.argmax(axis=0), 0], np.inf)
    return pd.DataFrame(times, index=known.index, columns=targets)


def time_to_proof(runs: pd.DataFrame) -> pd.Series:
    """Return how long each run took to prove its routes optimal [s]; infinite where it did not."""
    return runs["elapsed"].where(runs["proved"], np.inf)
