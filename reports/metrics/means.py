"""Means of times: the shifted geometric mean, and what a run that failed counts for.

    shifted geometric mean of t₁ … t_N with shift s:  (∏ (t_i + s))^(1/N) − s

It weighs ratios, not differences, and the shift keeps runs of milliseconds from ruling it. Source: T. Achterberg,
Constraint Integer Programming, thesis, TU Berlin 2007, appendix A.3; the shift is 1 s here because our limits are short
(Mittelmann's benchmarks use 10 s). A failed run counts as `PENALTY` times its limit, as in the SAT competitions' PAR-2.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

SHIFT = 1.0
"""Shift s [s]."""
PENALTY = 2.0
"""A failed run counts as this many times its limit."""


def shifted_geometric_mean(times: ArrayLike, shift: float = SHIFT) -> float:
    """Return the shifted geometric mean of `times` [s]; not a number for none, infinite where one is."""
    t = np.asarray(times, dtype=float)
    return float(np.exp(np.log(t + shift).mean()) - shift) if t.size else float("nan")


def penalised(times: pd.Series, limits: pd.Series, penalty: float = PENALTY) -> pd.Series:
    """Return `times` [s] with penalty × limit where a time is missing or infinite (the run failed)."""
    return times.where(np.isfinite(times.astype(float)), penalty * limits)
