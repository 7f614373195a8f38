"""Rows: the runs this process has stored, remembered so that they can be stored again where something deletes them."""

from __future__ import annotations

import zlib
from collections.abc import Iterator

REMEMBERED = 1 << 28
"""Bytes kept of rows, compressed; beyond, the oldest are forgotten."""


class Rows:
    """Path (relative to a store) → what is stored there."""

    def __init__(self) -> None:
        self._rows: dict[str, bytes] = {}
        self._size = 0

    def remember(self, path: str, row: bytes) -> None:
        """Take note that `row` is stored at `path`."""
        self._size -= len(self._rows.pop(path, b""))
        self._rows[path] = zlib.compress(row, 1)
        self._size += len(self._rows[path])
        while self._size > REMEMBERED:
            self._size -= len(self._rows.pop(next(iter(self._rows))))

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._rows))

    def __getitem__(self, path: str) -> bytes:
        return zlib.decompress(self._rows[path])
