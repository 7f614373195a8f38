"""Pairs of methods: Wilcoxon's signed-rank test with Holm's correction, and whether the pairs suffice to conclude.

Wilcoxon: F. Wilcoxon, Biometrics Bull. 1 (1945) 80–83, ties split evenly as in Demšar (2006), section 3.1.3. Holm: S.
Holm, A simple sequentially rejective multiple test procedure, Scand. J. Stat. 6 (1979) 65–70. With N instances on
which two methods differ no two-sided p-value can be below 2^(1−N); where even that, corrected for the number of pairs,
is not below α, the verdict is that there are too few instances, whatever the figures.
"""

from __future__ import annotations

import warnings
from itertools import combinations
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.stats import wilcoxon

from instances.arrays import Floats
from reports.statistics.bootstrap import bootstrap_interval

ALPHA = 0.05
"""Level of significance."""

COLUMNS = ["first", "second", "instances", "wins", "ties", "losses", "mean", "low", "high", "p", "p_holm", "verdict"]


def pairwise(table: pd.DataFrame, alpha: float = ALPHA) -> pd.DataFrame:
    """Compare every two methods (columns) of `table` over the instances (rows) both ran on; less is better.

    Columns: first, second; instances; wins, ties, losses of the first; mean difference first − second over instances
    both solved with its bootstrap interval `low` … `high`; p, p_holm; verdict, a few words.
    """
    rows = [(a, b, *_compared(table[a].to_numpy(float), table[b].to_numpy(float))) for a, b in combinations(table, 2)]
    found = pd.DataFrame(rows, columns=COLUMNS[:-2])
    found["p_holm"] = holm(found["p"].to_numpy(float))
    found["verdict"] = [verdict(row, len(found), alpha) for row in found.itertuples()]
    return found[COLUMNS]


def _compared(a: Floats, b: Floats) -> tuple[int, int, int, int, float, float, float, float]:
    both = ~(np.isnan(a) | np.isnan(b))
    a, b = a[both], b[both]
    finite = np.isfinite(a) & np.isfinite(b)
    difference = a[finite] - b[finite]
    mean = float(difference.mean()) if difference.size else float("nan")
    counts = int((a < b).sum()), int((a == b).sum()), int((a > b).sum())
    return (int(both.sum()), *counts, mean, *bootstrap_interval(difference), signed_rank(differences(a, b))[1])


def differences(a: Floats, b: Floats) -> Floats:
    """Return a − b with infinities (a method found nothing) as the largest difference of all; two of them tie."""
    finite = np.isfinite(a) & np.isfinite(b)
    found = np.subtract(a, b, out=np.zeros_like(a), where=finite)
    worst = 2 * np.abs(found).max(initial=1.0)
    return np.where(finite | (a == b), found, np.where(np.isinf(a), worst, -worst))


def signed_rank(difference: ArrayLike) -> tuple[float, float]:
    """Return Wilcoxon's T = min(R⁺, R⁻) and the two-sided p of `difference`; p is 1 where all are zero.

    Ranks of zeros are split between both sums. p is exact for up to 50 differences without zeros or ties, else normal.
    """
    d: Floats = np.asarray(difference, dtype=np.float64)
    if not d.any():
        return len(d) * (len(d) + 1) / 4, 1.0
    plain = len(d) <= 50 and d.all() and len(np.unique(np.abs(d))) == len(d)
    method: Literal["exact", "approx"] = "exact" if plain else "approx"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # small samples: the verdict says so
        found = wilcoxon(d, zero_method="zsplit", method=method)
    return float(found.statistic), float(found.pvalue)


def holm(p: ArrayLike) -> Floats:
    """Return Holm's adjusted p-values, in the order given."""
    raw = np.asarray(p, dtype=float)
    order = np.argsort(raw, kind="stable")
    adjusted = np.empty_like(raw)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(raw[order] * (len(raw) - np.arange(len(raw)))))
    return adjusted


def enough(differing: int, comparisons: int, alpha: float = ALPHA) -> bool:
    """Return whether `differing` instances could show a difference at all, among `comparisons` tests."""
    return 2.0 ** (1 - differing) * comparisons < alpha


def verdict(row: object, comparisons: int, alpha: float = ALPHA) -> str:
    """Return in a few words what a row of `pairwise` shows."""
    wins, losses, p = (getattr(row, key) for key in ("wins", "losses", "p_holm"))
    first, second = getattr(row, "first"), getattr(row, "second")  # noqa: B009
    if wins + losses == 0:
        return "no difference on any instance"
    if not enough(wins + losses, comparisons, alpha):
        return "too few instances to conclude"
    if p >= alpha:
        return "no difference shown"
    return f"{first if wins > losses else second} is better"
