"""Writing TOML, by tomli-w: the standard library only reads it. Floats keep every digit, a list stands on one line."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from instances.errors import InputError, shown


def toml_text(table: Mapping[str, Any]) -> str:
    """Return `table` as TOML, without what is None; InputError where it holds something TOML has no place for."""
    import tomli_w  # here: few commands write TOML

    text = tomli_w.dumps(_plain(table))
    # tomli-w breaks the line after each entry of a list, and breaks none anywhere else: texts have \n for it
    return re.sub(r",\n *", ", ", re.sub(r"(?<=\[)\n *|,\n *(?=\])", "", text))


def toml_value(value: Any) -> str:
    """Return `value` as it stands behind a key, on one line, tables too."""
    return toml_text({"x": [[value]]}).removeprefix("x = [[").removesuffix("]]\n")  # tables in lists are inline


def _plain(value: Any) -> Any:
    """Return `value` of what tomli-w takes: NumPy's numbers and arrays as Python's, paths as texts."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items() if each is not None}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, (str, Path)):
        return str(value)
    if isinstance(value, (int, float)):
        return value
    raise InputError(f"{shown(value)} cannot be written as TOML")
