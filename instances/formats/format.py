"""What a file format of instances is: a reader, and a writer where it is written too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from instances.instance import Instance


@dataclass(frozen=True)
class Format:
    """One format; `read` raises InputError that names the file, the field and the value."""

    read: Callable[[Path], Instance]
    write: Callable[[Instance, Path], None] | None = None
