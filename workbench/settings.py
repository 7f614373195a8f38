"""Settings typed on the command line: ``key=value``, lists ``a,b``, shards ``2/5``, files to write."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from instances.errors import InputError


def key_values(given: Iterable[str], flag: str) -> dict[str, Any]:
    """Return ``key=value`` pairs as a dict; a value is JSON (number, true, false ...) where it reads so, else text."""
    settings: dict[str, Any] = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise InputError(f"{flag}: must be key=value, got '{text}'")
        try:
            settings[key.strip()] = json.loads(value)
        except ValueError:
            settings[key.strip()] = value.strip()
    return settings


def names(text: str, flag: str) -> list[str]:
    """Return the parts of a comma-separated list; InputError where there is none."""
    parts = [part.strip() for part in text.split(",") if part.strip()]
    if not parts:
        raise InputError(f"{flag}: must be a comma-separated list, got '{text}'")
    return parts


def shard(text: str) -> tuple[int, int]:
    """Return (i, n) of ``i/n`` with 1 ≤ i ≤ n."""
    number, _, count = text.partition("/")
    if not (number.isdigit() and count.isdigit() and 1 <= int(number) <= int(count)):
        raise InputError(f"--shard: must be i/n with 1 ≤ i ≤ n, got '{text}'")
    return int(number), int(count)


def make_folder(folder: Path, what: str = "a folder") -> Path:
    """Make `folder`, where there is none yet, and return it; InputError where it cannot be `what`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made {what} ({error.strerror or error})") from None
    return folder


def check_target(path: Path | None, endings: tuple[str, ...]) -> None:
    """Refuse before the work what could not be written after it; None is fine."""
    if path is None:
        return
    if not path.name.endswith(endings):
        raise InputError(f"{path}: must end in {' or '.join(endings)}")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}")
