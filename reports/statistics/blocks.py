"""Blocks: one figure for each instance and method, the median over seeds, which every test here works on."""

from __future__ import annotations

import numpy as np
import pandas as pd

DIGITS = 9
"""Figures that agree to this many decimals tie."""


def blocks(runs: pd.DataFrame, measure: str) -> pd.DataFrame:
    """Return `measure` of `runs` as instances (index: digest) × methods, the median over seeds; less is better.

    A run without a figure counts as infinite (the worst); where a method did not run at all there is a NaN.
    """
    worst = runs[measure].fillna(np.inf)
    table = worst.groupby([runs["digest"], runs["method"]]).median().unstack()
    return table.round(DIGITS)
