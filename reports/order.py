"""Order: rows of a frame sorted as people count, n5 before n10."""

from __future__ import annotations

import pandas as pd

from instances.natural import natural


def naturally(column: pd.Series) -> pd.Series:
    """Return what a column is sorted by (``sort_values(key=…)``): texts by the numbers in them, numbers as they are."""
    return column if pd.api.types.is_numeric_dtype(column) else column.map(natural)
