"""Settings typed on the command line: ``key=value``, lists ``a,b``, shards ``2/5``, files to write."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from instances import disk
from instances.errors import InputError, shown

LARGEST_MEMORY = 2**62
"""Bytes; no machine has more."""


def key_values(given: Iterable[str], flag: str) -> dict[str, Any]:
    """Return ``key=value`` pairs as a dict; a value is JSON (number, true, false ...) where it reads so, else text."""
    settings: dict[str, Any] = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise InputError(f"{flag}: must be key=value, got {shown(text)}")
        try:
            settings[key.strip()] = json.loads(value)
        except (ValueError, RecursionError):
            settings[key.strip()] = value.strip()
    return settings


def names(text: str, flag: str) -> list[str]:
    """Return the parts of a comma-separated list; InputError where there is none."""
    parts = [part.strip() for part in text.split(",") if part.strip()]
    if not parts:
        raise InputError(f"{flag}: must be a comma-separated list, got {shown(text)}")
    return parts


def shard(text: str) -> tuple[int, int]:
    """Return (i, n) of ``i/n`` with 1 ≤ i ≤ n."""
    number, _, count = text.partition("/")
    if not (re.fullmatch(r"\d{1,9}/\d{1,9}", text) and 1 <= int(number) <= int(count)):
        raise InputError(f"--shard: must be i/n with 1 ≤ i ≤ n, got {shown(text)}")
    return int(number), int(count)


MEMORY = re.compile(r"(\d{1,18}(?:\.\d{1,9})?)\s*([kKMGT]?)B?")


def memory(text: str, flag: str) -> int:
    """Return the bytes of a size such as ``2GB``, ``500M`` or ``1500000000``; kB, MB, GB are powers of 1000."""
    found = MEMORY.fullmatch(text.strip())
    size = int(float(found[1]) * 1000 ** "_KMGT".index(found[2].upper() or "_")) if found else 0
    if not 1 <= size <= LARGEST_MEMORY:
        raise InputError(f"{flag}: must be a size such as 2GB, 500MB or a number of bytes, got {shown(text)}")
    return size


def make_folder(folder: Path, what: str = "a folder") -> Path:
    """Make `folder`, where there is none yet, and return it; InputError where it cannot be `what`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made {what} ({error.strerror or error})") from None
    return folder


def check_target(path: Path | None, endings: tuple[str, ...] = ("",)) -> None:
    """Refuse before the work what could not be written after it, or has none of the `endings`; None is fine."""
    if path is None:
        return
    if not path.name.endswith(endings):
        raise InputError(f"{path}: must end in {' or '.join(endings)}")
    disk.check_target(path)
