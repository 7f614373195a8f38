"""Natural order: names in the order of the numbers in them, n5 before n10 before n40."""

from __future__ import annotations

import re

_NUMBER = re.compile(r"(\d+)(\.\d+)?")
WIDEST = 20
"""Digits that a number is filled up to."""


def natural(name: object) -> str:
    """Return what names (of files, instances, methods) are sorted by: their text, numbers in it of one width."""
    return _NUMBER.sub(lambda number: number[1].zfill(WIDEST) + (number[2] or ""), str(name))
