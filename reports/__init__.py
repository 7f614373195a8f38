"""Frames in, pages out: metrics, figures, tables and one self-contained page.

In a notebook::

    from reports import load

    runs = load("runs/demo")
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["load"]


def load(*folders: Path | str) -> pd.DataFrame:
    """Return the runs of one store, or of several merged, as a tidy frame with a row a run.

    Columns: see `reports.stores.COLUMNS`. What could not be read is left out and named, a sentence each, in
    ``frame.attrs["warnings"]``. InputError where a folder does not exist.
    """
    from reports.stores import read_stores  # here, not above: `import reports` stays cheap

    return read_stores(*folders).runs
