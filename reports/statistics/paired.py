"""Paired comparison of few draws: the interval of a mean difference, by Student's t.

Where both of a pair were measured under the same conditions (one field, one noise seed), what the conditions do to both
cancels in the difference d_i, and  d̄ ± t_{n−1} s / √n  holds its mean with the confidence stated where the differences
are about normal (Student, "The probable error of a mean", Biometrika 6, 1908). Of eight normal differences the
bootstrap's interval of 95 % holds the mean in 87 % of cases only, so it is not used for so few.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import t


@dataclass(frozen=True)
class Paired:
    """Mean difference over `pairs` pairs with its interval, NaN for fewer than two; in how many it is negative."""

    mean: float
    low: float
    high: float
    pairs: int
    negative: int

    @property
    def sign(self) -> int:
        """−1 or 1 where the whole interval lies on that side of 0, else 0: no difference shown."""
        return int(self.low > 0) - int(self.high < 0)


def paired(difference: ArrayLike, confidence: float = 0.95) -> Paired:
    """Return the mean of `difference` (n ≥ 1,) with its interval."""
    d = np.asarray(difference, dtype=float)
    n, mean = len(d), float(np.mean(d))
    reach = float("nan")
    if n > 1:
        reach = float(t.ppf(0.5 + confidence / 2, n - 1) * d.std(ddof=1) / np.sqrt(n))
    return Paired(mean, mean - reach, mean + reach, n, int((d < 0).sum()))
