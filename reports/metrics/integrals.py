"""Integrals over the anytime trace: how good, how soon, in one figure.

    primal integral       P = ∫₀ᵀ p(t) dt,  p = 1 before the first routes, then |z(t) − z*| / max(|z(t)|, |z*|)
    primal-dual integral  G = ∫₀ᵀ g(t) dt,  g = 1 before routes and a bound, then (z(t) − b(t)) / max(|z(t)|, |b(t)|)

z(t) [s] is the best routes' cost at time t, b(t) [s] the bound, z* the best known or found, T the time limit; after
the end of the run its last values hold. Both in seconds, from 0 (perfect at once) to T (nothing at all).

Source: T. Berthold, Measuring the impact of primal heuristics, Oper. Res. Lett. 41 (2013) 611–614; the gap function of
the primal-dual integral as in Berthold & Csizmadia, The confined primal integral, Math. Program. 188 (2021).
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from instances.arrays import Floats
from reports.metrics.gaps import with_gaps


def with_integrals(runs: pd.DataFrame) -> pd.DataFrame:
    """Return `runs` with `primal_integral` and `primal_dual_integral` [s], up to each run's time limit."""
    known = with_gaps(runs)
    rows = list(zip(finished_traces(known), known["best"], known["time_limit"], strict=True))
    primal = [primal_integral(*row) for row in rows]
    dual = [primal_dual_integral(trace, limit) for trace, _, limit in rows]
    return known.assign(primal_integral=primal, primal_dual_integral=dual)


def finished_traces(runs: pd.DataFrame) -> list[Floats]:
    """Return each run's trace with its end appended: at `elapsed` its value and bound; wrong claims have no trace."""
    ends = runs[["elapsed", "value", "bound"]].to_numpy(float)
    wrong = runs["recomputed"].notna() & runs["value"].isna() | (runs["fault"] != "")
    finished = []
    for trace, end, refuted in zip(runs["trace"], ends, wrong, strict=True):
        if refuted:
            finished.append(np.empty((0, 3)))
        elif np.isnan(end[1:]).all() or np.isnan(end[0]):
            finished.append(trace)
        else:
            finished.append(np.vstack([trace, end]))
    return finished


def primal_integral(trace: Floats, best: float, horizon: float) -> float:
    """Return P [s] of `trace` (k, 3) against `best` [s] up to `horizon` [s]."""
    if np.isnan(best):
        return float(horizon)
    z = _running_best(trace[:, 1])
    return _integral(trace[:, 0], np.abs(_gap(z, np.full_like(z, best))), horizon)


def primal_dual_integral(trace: Floats, horizon: float) -> float:
    """Return G [s] of `trace` (k, 3) up to `horizon` [s]."""
    z, b = _running_best(trace[:, 1]), -_running_best(-trace[:, 2])
    return _integral(trace[:, 0], _gap(z, b), horizon)


def _gap(z: Floats, b: Floats) -> Floats:
    """Return (z − b) / max(|z|, |b|), 1 where one is unknown and 0 where both are 0."""
    known = np.isfinite(z) & np.isfinite(b)
    scale = np.maximum(np.abs(z), np.abs(b), where=known, out=np.ones_like(z))
    difference = np.subtract(z, b, where=known, out=np.ones_like(z))
    return np.divide(difference, scale, where=scale > 0, out=np.zeros_like(z))


def _running_best(values: Floats) -> Floats:
    """Return the least value so far, infinite before the first."""
    return np.minimum.accumulate(np.where(np.isnan(values), np.inf, values))


def _integral(times: Floats, gaps: Floats, horizon: float) -> float:
    """Integrate the step function that is 1 before times[0] and gaps[i], 0 to 1, from times[i], over [0, horizon]."""
    edges = np.clip(np.concatenate([[0.0], times, [horizon]]), 0.0, horizon)
    return float(np.diff(edges) @ np.concatenate([[1.0], np.clip(gaps, 0.0, 1.0)]))
