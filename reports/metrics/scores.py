"""Scores: one row a method over all runs, or over the runs of each family, size or asymmetry; one row an instance."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from reports.metrics.gaps import with_gaps
from reports.metrics.integrals import with_integrals
from reports.metrics.means import penalised, shifted_geometric_mean
from reports.metrics.targets import time_to_proof, time_to_target
from reports.order import naturally
from reports.proofs import believed_bounds
from reports.tolerances import RELATIVE_ROUNDING

CERTIFIED = 0.01
"""Routes count as certified where the best bound of any run proves them within this share of the optimum."""

GROUPINGS = {"family": "Family", "n_tasks": "Tasks n", "n_depots": "UAVs m", "asymmetry": "Cost asymmetry"}
"""What scores are split by → its heading."""

MOST_SIZES = 10
"""Up to so many values of n are shown one by one."""

_TASK_BANDS = [0, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000]
_ASYMMETRY_BANDS = [0.0, 0.02, 0.05, 0.10, 0.20]


def summary(runs: pd.DataFrame) -> pd.DataFrame:
    """Return one row a method (index), best mean gap first.

    runs, instances, seeds: how many; solved, proved: shares of runs; failed: runs KILLED or in ERROR; certified: share
    of runs whose routes any run's bound proves within `CERTIFIED`, certified_by: by whose bounds; gap_known, gap_found,
    gap_bound: means over solved runs; time: shifted geometric mean [s] of the solve, proof_time: until the proof,
    target_time: until within 1 % of the best, each with a penalty for runs that failed; primal_integral,
    primal_dual_integral: mean shares of the limit, 0 to 1, the latter where there are bounds; memory: greatest [bytes].
    """
    return scores(runs, [])


def scores(runs: pd.DataFrame, by: list[str]) -> pd.DataFrame:
    """Return the rows of `summary` for each group of the columns `by` and each method (index: by, then method)."""
    known = _measured(runs)
    keys = [*by, "method"]
    rows = [
        dict(zip(keys, of, strict=True)) | _score(group)
        for of, group in known.groupby(keys, observed=True, sort=True)
        if isinstance(of, tuple)
    ]
    table = pd.DataFrame(rows)
    for key in by:  # bands keep their order
        table[key] = table[key].astype(known[key].dtype)
    return table.sort_values([*by, "gap_found", "time"], kind="stable").set_index(keys if by else "method")


def banded(runs: pd.DataFrame) -> pd.DataFrame:
    """Return `runs` with the asymmetry and, where it has many values, n as bands ("11-20", "5-10 %"), for `scores`."""
    n = runs["n_tasks"]
    if n.nunique() > MOST_SIZES:
        bands = [*(f"{a + 1}-{b}" for a, b in pairwise(_TASK_BANDS)), f"over {_TASK_BANDS[-1]}"]
        n = pd.cut(n.astype(float), [*_TASK_BANDS, np.inf], labels=bands)
    edges = [-np.inf, *_ASYMMETRY_BANDS, np.inf]
    labels = ["0 (symmetric)", *[f"{100 * a:g}-{100 * b:g} %" for a, b in pairwise(_ASYMMETRY_BANDS)]]
    labels.append(f"over {100 * _ASYMMETRY_BANDS[-1]:g} %")
    return runs.assign(
        n_tasks=n, asymmetry=pd.cut(runs["asymmetry"].where(runs["asymmetry"] > 1e-9, 0.0), edges, labels=labels)
    )


def instance_table(runs: pd.DataFrame) -> pd.DataFrame:
    """Return one row an instance (index: digest): what it is, best known, found and bound [s], the gap left, whether
    it is proved, and the method that found the best routes first.
    """
    known = with_gaps(runs)
    about = ["instance", "family", "n_tasks", "n_depots", "asymmetry", "best_known", "best_found", "best_bound"]
    groups = known.groupby("digest")
    table = groups[about].first()
    table["bound_by"] = groups["bound_by"].first()
    table["gap"] = groups["gap_bound"].min()
    table["proved"] = groups["proved"].any()
    right = known[known["value"] <= known["best_found"] * (1 + RELATIVE_ROUNDING)]
    first = right.sort_values("elapsed").drop_duplicates("digest").set_index("digest")
    table["best_method"] = first["method"]
    table["runs"] = groups.size()
    return table.sort_values(["family", "n_tasks", "n_depots", "instance"], kind="stable", key=naturally)


def _measured(runs: pd.DataFrame) -> pd.DataFrame:
    known = with_integrals(with_gaps(runs))
    solved = known["value"].notna()
    limits = known["time_limit"]
    return known.assign(
        _solved=solved,
        _proved=known["proved"],
        _failed=known["status"].isin(["KILLED", "ERROR"]),
        _certified=known["gap_bound"] <= CERTIFIED,
        _certified_by=_certifiers(known),
        _time=penalised(known["elapsed"].where(solved), limits),
        _proof=penalised(time_to_proof(known), limits),
        _target=penalised(time_to_target(known, [0.01])[0.01], limits),
        _primal=known["primal_integral"] / limits,
        _dual=known["primal_dual_integral"] / limits,
    )


def _certifiers(known: pd.DataFrame) -> pd.Series:
    """Return by whose bound each run's routes are certified: "own bound", a method's name, or nothing."""
    own = known["value"] - believed_bounds(known) <= CERTIFIED * known["value"]
    whose = known["bound_by"].mask(own | (known["bound_by"] == known["method"]), "own bound")
    return whose.where(known["gap_bound"] <= CERTIFIED)


def _score(group: pd.DataFrame) -> dict[str, Any]:
    return {
        "runs": len(group),
        "instances": group["digest"].nunique(),
        "seeds": group["seed"].nunique(),
        "solved": group["_solved"].mean(),
        "proved": group["_proved"].mean(),
        "failed": int(group["_failed"].sum()),
        "certified": group["_certified"].mean(),
        "certified_by": ", ".join(sorted(group["_certified_by"].dropna().unique())) or None,
        "gap_known": group["gap_known"].mean(),
        "gap_found": group["gap_found"].mean(),
        "gap_bound": group["gap_bound"].mean(),
        "time": shifted_geometric_mean(group["_time"]),
        "proof_time": shifted_geometric_mean(group["_proof"]) if group["proves"].any() else np.nan,
        "target_time": shifted_geometric_mean(group["_target"]),
        "primal_integral": group["_primal"].mean(),
        "primal_dual_integral": group["_dual"].mean() if group["bound"].notna().any() else np.nan,
        "memory": group["peak_memory"].max(),
    }
