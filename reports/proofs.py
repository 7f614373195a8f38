"""Proofs: which claims of optimality hold, as far as the stored figures can tell.

A bound is the claim of the method that states it: only its own argument shows it, which nobody here repeats. It is
not believed where any run has routes below it, neither if it was only streamed on the way; nor where it is bit for bit
the cost of the run's own routes although the run does not say OPTIMAL: it may be a false bound that was cut off there,
as files made before bounds above the routes were refused hold them.

A run has proved its routes optimal where it ended OPTIMAL with routes whose cost is right, with a bound that leaves no
gap beyond its stated tolerance, that tolerance being no excuse, and with a bound that no routes of any run refute.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from instances.arrays import Floats
from reports.tolerances import RELATIVE_ROUNDING, WIDEST_TOLERANCE


def holds(runs: pd.DataFrame) -> pd.Series:
    """Return which of `runs` have a proof that holds."""
    believed = believed_bounds(runs).notna()
    return (runs["status"] == "OPTIMAL") & runs["value"].notna() & believed & ~gap_left(runs, runs["value"])


def believed_bounds(runs: pd.DataFrame) -> pd.Series:
    """Return the bound of each run [s], nothing where it is refuted or may be cut off."""
    return runs["bound"].where(~refuted_bounds(runs) & ~cut_off(runs))


def refuted_bounds(runs: pd.DataFrame) -> pd.Series:
    """Return which of `runs` have stated a bound, at the end or on the way, above the routes of any run."""
    best = runs["recomputed"].fillna(runs["value"]).groupby(runs["digest"]).transform("min")
    limit = best * (1 + RELATIVE_ROUNDING)
    rounded = runs["tolerance"].fillna(0.0).clip(lower=0.0, upper=WIDEST_TOLERANCE * best)
    return (runs["bound"] > limit) | (streamed_bounds(runs) > limit + rounded)


def streamed_bounds(runs: pd.DataFrame) -> pd.Series:
    """Return the greatest bound [s] in the trace of each run, nothing where there is none."""
    return pd.Series([_greatest(trace[:, 2]) for trace in runs["trace"]], index=runs.index, dtype=float)


def cut_off(runs: pd.DataFrame) -> pd.Series:
    """Return which of `runs` may hold a bound that was cut off at their own routes' cost."""
    return (runs["bound"] == runs["objective"]) & (runs["objective"] > 0) & (runs["status"] != "OPTIMAL")


def _greatest(values: Floats) -> float:
    return float(np.fmax.reduce(values, initial=np.nan))


def gap_left(runs: pd.DataFrame, cost: pd.Series) -> pd.Series:
    """Return where `cost` [s] and the bound are further apart than the tolerance allows, or there is no bound."""
    allowed = runs["tolerance"].fillna(0.0).clip(lower=0.0, upper=WIDEST_TOLERANCE * cost)
    return runs["bound"].isna() | (cost - runs["bound"] > allowed + RELATIVE_ROUNDING * cost.abs())
