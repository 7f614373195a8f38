"""CSV that is safe to open: text that a spreadsheet would take for a formula is marked as text.

A cell that begins with = + - @, a tab or a carriage return is run when a spreadsheet opens the file; an apostrophe in
front keeps it text (OWASP, CSV injection). Only texts are touched, never numbers.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
from pandas.api.types import is_numeric_dtype

from instances.disk import write_aside

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def write_csv(frame: pd.DataFrame, path: Path | str, *, raw: bool = False) -> None:
    """Write `frame` as `csv_text` to `path`."""
    write_aside(path, csv_text(frame, raw))


def csv_text(frame: pd.DataFrame, raw: bool = False) -> str:
    """Return `frame` as CSV, a row a row; raw : texts as they are, for programs that read them back."""
    texts = [name for name in frame if not is_numeric_dtype(frame[name])]
    cells = {str(name): pd.Series([_cell(v, raw) for v in frame[name]], frame.index, dtype=object) for name in texts}
    return frame.assign(**cells).to_csv(index=False, lineterminator="\n")


def _cell(value: Any, raw: bool) -> Any:
    if not isinstance(value, str):
        return value
    text = value.replace("\r", "\n")  # a lone carriage return would end the row
    return f"'{text}" if not raw and value.startswith(FORMULA_STARTS) else text
