"""Virtual best: for each instance the method that does best there, as if it had been known beforehand.

Best means: proved by more seeds, else the lower cost, else the shorter time, each the median over seeds. What a method
contributes is what the virtual best would lose without it (the VBS and marginal contributions of the SAT competitions).
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from reports.metrics.gaps import with_gaps
from reports.order import naturally
from reports.tolerances import RELATIVE_ROUNDING


def virtual_best(runs: pd.DataFrame) -> pd.DataFrame:
    """Return one row an instance (index: digest): instance, method, value [s], elapsed [s], gap_best, proved (share).

    Medians over the seeds of the winning method; instances nobody solved are left out.
    """
    known = with_gaps(runs)
    known = known.assign(proved=known["proved"].astype(float), value=known["value"].fillna(np.inf))
    how = {"instance": "first", "value": "median", "elapsed": "median", "gap_best": "median", "proved": "mean"}
    each = known.groupby(["digest", "method"]).agg(how)
    solved = each[np.isfinite(each["value"])].reset_index()
    order = solved.sort_values(["proved", "value", "elapsed"], ascending=[False, True, True], kind="stable")
    best: pd.DataFrame = order.drop_duplicates("digest").set_index("digest").sort_values("instance", key=naturally)
    return best


def contributions(runs: pd.DataFrame) -> pd.DataFrame:
    """Return what each method adds, a row a method: instances on which its best routes are the best found (`best`),
    on which they are better than every other method's (`alone`), and on which only it has a proof (`proof_alone`).
    """
    values = runs.pivot_table(index="digest", columns="method", values="value", aggfunc="min", dropna=False)
    values = values.fillna(np.inf)
    least = values.min(axis=1)
    is_best = values.le(least * (1 + RELATIVE_ROUNDING), axis=0) & np.isfinite(values)
    proofs = runs.groupby(["digest", "method"])["proved"].any().unstack(fill_value=False)
    rows = {
        "best": is_best.sum(),
        "alone": is_best[is_best.sum(axis=1) == 1].sum(),
        "proof_alone": proofs[proofs.sum(axis=1) == 1].sum(),
    }
    return pd.DataFrame(rows).astype(int).rename_axis("method")
