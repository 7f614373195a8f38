"""Friedman's test of average ranks, and the critical difference between two of them (Nemenyi).

With R_j the average rank of method j of k over N instances (rank 1 is best, ties share ranks):

    χ²_F = 12 N / (k (k+1)) · (Σ_j R_j² − k (k+1)² / 4)
    F_F  = (N−1) χ²_F / (N (k−1) − χ²_F),  F-distributed with k−1 and (k−1)(N−1) degrees of freedom (Iman & Davenport)
    CD   = q_α √(k (k+1) / (6 N)),  q_α the studentised range quantile over √2

Source: J. Demšar, Statistical comparisons of classifiers over multiple data sets, J. Mach. Learn. Res. 7 (2006) 1–30,
whose worked example the tests repeat.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import f, rankdata, studentized_range


@dataclass(frozen=True)
class Friedman:
    """Outcome of the test: average `ranks` by method (best first), N instances, χ²_F, F_F, p of F_F and the CD."""

    ranks: pd.Series
    instances: int
    chi_square: float
    f_statistic: float
    p: float
    critical_difference: float


def friedman(table: pd.DataFrame, alpha: float = 0.05) -> Friedman | None:
    """Test whether the methods (columns) of `table` differ over its complete instances (rows); less is better.

    None where there are fewer than three methods or two complete instances: then there is nothing to rank.
    """
    complete = table.dropna()
    n, k = complete.shape
    if k < 3 or n < 2:
        return None
    ranks = rankdata(complete.to_numpy(float), axis=1)
    average = ranks.mean(axis=0)
    chi_square = 12 * n / (k * (k + 1)) * (float(np.square(average).sum()) - k * (k + 1) ** 2 / 4)
    rest = n * (k - 1) - chi_square
    statistic = (n - 1) * chi_square / rest if rest > 1e-12 else np.inf
    p = float(f.sf(statistic, k - 1, (k - 1) * (n - 1)))
    ordered = pd.Series(average, index=complete.columns).sort_values(kind="stable")
    return Friedman(ordered, n, chi_square, float(statistic), p, critical_difference(k, n, alpha))


def critical_difference(k: int, n: int, alpha: float = 0.05) -> float:
    """Return the least difference of average ranks of k methods over n instances that is significant (Nemenyi)."""
    return float(studentized_range.ppf(1 - alpha, k, np.inf) / np.sqrt(2) * np.sqrt(k * (k + 1) / (6 * n)))


def cliques(ranks: pd.Series, difference: float) -> list[tuple[int, int]]:
    """Return the longest stretches (first, last) of the sorted `ranks` whose ends differ by less than `difference`."""
    r = ranks.to_numpy(float)
    ends = [int(np.flatnonzero(r - r[i] < difference).max()) for i in range(len(r))]
    return [(i, end) for i, end in enumerate(ends) if end > i and (i == 0 or ends[i - 1] < end)]
