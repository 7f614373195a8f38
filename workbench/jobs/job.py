"""Job: one method on one item with one seed and one limit, before it is run; and how it is named."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from workbench.jobs.problem import Named

LONGEST_NAME = 80
"""Options longer than this many characters are cut in file names and told apart by a digest."""


@dataclass(frozen=True)
class Job:
    """What to run. `folder` is the item's folder in the store; options are those that differ from the default.

    time_limit [s]; threads of the method; iterations of its own, or None for no limit.
    """

    folder: str
    method: str
    options: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    time_limit: float = 10.0
    threads: int = 1
    iterations: int | None = None

    @property
    def label(self) -> str:
        """Method's name plus options that differ from the default, for tables and legends."""
        return f"{self.method} ({_spelled(self.options)})" if self.options else self.method

    @property
    def path(self) -> str:
        """Where the run is stored, relative to the store: ``folder/method-options-sS-tT.json``."""
        parts = [file_safe(self.method), file_safe(_spelled(self.options, ",")) if self.options else "default"]
        parts += [f"s{self.seed}", f"t{self.time_limit:g}"]
        parts += [f"j{self.threads}"] if self.threads != 1 else []
        parts += [f"i{self.iterations}"] if self.iterations is not None else []
        return f"{self.folder}/{'-'.join(parts)}.json"


def folder_of(item: Named) -> str:
    """Return the name of an item's folder in a store: ``name-digest``."""
    return f"{file_safe(item.name)}-{item.digest}"


def file_safe(text: str) -> str:
    """Return `text` as part of a file name; what had to be changed or cut is told apart by a digest."""
    safe = re.sub(r"[^A-Za-z0-9._=,+-]+", "_", text)
    if safe == text and len(text) <= LONGEST_NAME and not text.startswith("."):
        return text
    return f"{safe[:LONGEST_NAME].lstrip('.')}~{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def _spelled(options: Mapping[str, Any], separator: str = ", ") -> str:
    def spell(value: Any) -> str:
        return value if isinstance(value, str) else json.dumps(value)

    return separator.join(f"{key}={spell(options[key])}" for key in sorted(options))
