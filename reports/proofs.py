"""Proofs: which claims of optimality hold, as far as the stored figures can tell.

A run has proved its routes optimal where it ended OPTIMAL with routes whose cost is right, with a bound that leaves no
gap beyond its stated tolerance, that tolerance being no excuse, and with a bound that no routes of any run refute.
"""

from __future__ import annotations

import pandas as pd

RELATIVE_ROUNDING = 1e-9
"""Two costs that differ by less than this share differ by floating-point rounding only."""
WIDEST_TOLERANCE = 1e-3
"""A proof within more than this share of the cost is not called one."""


def holds(runs: pd.DataFrame) -> pd.Series:
    """Return which of `runs` have a proof that holds."""
    costs = runs["recomputed"].fillna(runs["value"])
    best = costs.groupby(runs["digest"]).transform("min")
    unrefuted = runs["bound"] <= best * (1 + RELATIVE_ROUNDING)
    return (runs["status"] == "OPTIMAL") & runs["value"].notna() & unrefuted & ~gap_left(runs, runs["value"])


def gap_left(runs: pd.DataFrame, cost: pd.Series) -> pd.Series:
    """Return where `cost` [s] and the bound are further apart than the tolerance allows, or there is no bound."""
    allowed = runs["tolerance"].fillna(0.0).clip(lower=0.0, upper=WIDEST_TOLERANCE * cost)
    return runs["bound"].isna() | (cost - runs["bound"] > allowed + RELATIVE_ROUNDING * cost.abs())
