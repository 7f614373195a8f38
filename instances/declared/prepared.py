"""Types looked into by msgspec before threads read by them.

msgspec looks into a declaration when it first reads by it, and keeps what it found with the class before that is
complete. A thread that reads by the class, or by one that holds it, at that moment follows a null pointer: the process
ends by a segmentation fault (msgspec 0.22; seen once, as threads stored the first runs of a study).
"""

from __future__ import annotations

import threading
from typing import Any, TypeVar

import msgspec

T = TypeVar("T")

_known: set[Any] = set()
_lock = threading.RLock()


def prepared(kind: T) -> T:
    """Return `kind`, a type or a union of types, known to msgspec with all that it holds."""
    if kind not in _known:
        with _lock:
            msgspec.json.Decoder(kind)
            _known.add(kind)
    return kind
