"""Virtual best: for each instance and seed the run of the best method, as if it had been known beforehand.

Best means: proved sooner, else the lower cost, else the shorter time. What a method contributes is how much worse the
virtual best is without it (the idea of the SAT competitions' VBS and of marginal contributions).
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from reports.metrics.gaps import with_gaps
from reports.metrics.targets import proved
from reports.stores import RELATIVE_ROUNDING


def virtual_best(runs: pd.DataFrame) -> pd.DataFrame:
    """Return the best run for each instance and seed, its method renamed "virtual best" and kept in `winner`."""
    known = with_gaps(runs)
    keys = known.assign(_open=~proved(known), _value=known["value"].fillna(np.inf))
    best = keys.sort_values(["_open", "_value", "elapsed"], kind="stable").drop_duplicates(["digest", "seed"])
    best = best.assign(winner=best["method"], method="virtual best").drop(columns=["_open", "_value"])
    return best.sort_values(["instance", "seed"], ignore_index=True)


def contributions(runs: pd.DataFrame) -> pd.DataFrame:
    """Return what each method adds, a row a method: instances on which its best routes are the best found (`best`),
    on which they are better than every other method's (`alone`), and on which only it has a proof (`proof_alone`).
    """
    values = runs.pivot_table(index="digest", columns="method", values="value", aggfunc="min", dropna=False)
    values = values.fillna(np.inf)
    least = values.min(axis=1)
    is_best = values.le(least * (1 + RELATIVE_ROUNDING), axis=0) & np.isfinite(values)
    proofs = proved(runs).groupby([runs["digest"], runs["method"]]).any().unstack(fill_value=False)
    rows = {
        "best": is_best.sum(),
        "alone": is_best[is_best.sum(axis=1) == 1].sum(),
        "proof_alone": proofs[proofs.sum(axis=1) == 1].sum(),
    }
    return pd.DataFrame(rows).astype(int).rename_axis("method")
