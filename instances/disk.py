"""Whole files in and out: one sentence where that fails, and nothing half-written."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

from instances.errors import InputError


def read_bytes(path: Path | str) -> bytes:
    """Return the content of the file; InputError names it where it cannot be read."""
    try:
        return Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read ({_reason(error)})") from None


def read_text(path: Path | str) -> str:
    """Return the content of the UTF-8 text file; InputError names it where it is none."""
    return as_text(read_bytes(path), path)


def read_toml(path: Path | str) -> dict[str, Any]:
    """Return the table of the TOML file; InputError names it where it is none."""
    text = read_text(path)
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise InputError(f"{path}: is not valid TOML ({error})") from None


def as_text(content: bytes, path: Path | str) -> str:
    """Return `content`, read from `path`, as text; InputError where it is binary."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text (byte {error.start})") from None
    if "\0" in text:
        raise InputError(f"{path}: is not text but binary (byte {text.index(chr(0))} is zero)")
    return text


def write_aside(path: Path | str, content: bytes | str) -> None:
    """Write `content` beside `path`, then rename it: a reader sees the old file or the whole new one.

    Raises InputError where the folder is missing or not writable, or the disk is full; `path` is then as it was.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        target = Path(os.path.realpath(path))  # a link keeps pointing where it points
        if target.is_dir():
            raise IsADirectoryError(21, "it is a folder")
        aside = target.with_name(f".{target.name}.{os.getpid()}.part")
        try:
            with aside.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            aside.replace(target)
        finally:
            aside.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written ({_reason(error)})") from None


def _reason(error: OSError | ValueError) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
