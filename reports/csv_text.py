"""CSV that is safe to open: text that a spreadsheet would take for a formula is marked as text.

A cell that begins with = + - @, a tab or a carriage return is run when a spreadsheet opens the file; an apostrophe in
front keeps it text (OWASP, CSV injection). Only texts are touched, never numbers.
"""

from __future__ import annotations

from typing import Any

import pandas as pd
from pandas.api.types import is_numeric_dtype

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def csv_text(frame: pd.DataFrame, raw: bool = False) -> str:
    """Return `frame` as CSV, a row a row; raw : texts as they are, for programs that read them back."""
    texts = [] if raw else [name for name in frame if not is_numeric_dtype(frame[name])]
    quoted = {str(name): pd.Series(map(_quoted, frame[name]), frame.index, dtype=object) for name in texts}
    return frame.assign(**quoted).to_csv(index=False, lineterminator="\n")


def _quoted(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA_STARTS) else value
