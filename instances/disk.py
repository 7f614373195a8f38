"""Whole files in and out: the one way to read a file, and the one way to write one.

What is read is a regular file, or a link to one, of at most 2 GB (the environment variable WORKBENCH_LARGEST_FILE
sets another number of bytes): devices, pipes, sockets and folders are refused before a byte is read. What is
written is there whole or not at all. Whatever fails is one sentence that begins with the file's name.
"""

from __future__ import annotations

import os
import secrets
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from instances.documents import decompressed, json_of, text_of, toml_of
from instances.errors import InputError, naming, shown

LARGEST = 2_000_000_000
"""Bytes of the largest file that is read, unless the environment says otherwise."""
LARGEST_VARIABLE = "WORKBENCH_LARGEST_FILE"

_NO_FILE = {
    stat.S_IFDIR: "it is a folder",
    stat.S_IFIFO: "it is a pipe, not a file",
    stat.S_IFSOCK: "it is a socket, not a file",
    stat.S_IFCHR: "it is a device, not a file",
    stat.S_IFBLK: "it is a device, not a file",
}


def read_bytes(path: Path | str) -> bytes:
    """Return the content of the file; InputError names it where it cannot be read."""
    with _opened(path) as (descriptor, size), os.fdopen(descriptor, "rb", closefd=False) as file:
        return file.read(size)


def check_file(path: Path | str) -> int:
    """Return the size [bytes] of a file that a library is to open by its name; InputError where we would not."""
    with _opened(path) as (_, size):
        return size


def read_text(path: Path | str) -> str:
    """Return the content of the UTF-8 text file; InputError names it where it is none."""
    content = read_bytes(path)
    with naming(path):
        return text_of(content)


def read_unpacked(path: Path | str) -> bytes | bytearray:
    """Return the content of the file, decompressed where its name ends in ``.gz``."""
    content = read_bytes(path)
    if not str(path).lower().endswith(".gz"):
        return content
    with naming(path):
        return decompressed(content)


def read_json(path: Path | str) -> Any:
    """Return the value in the JSON file (`documents.json_of`), decompressed where its name ends in ``.gz``."""
    content = read_unpacked(path)
    with naming(path):
        return json_of(text_of(content))


def read_toml(path: Path | str) -> dict[str, Any]:
    """Return the table of the TOML file; InputError names it where it is none."""
    text = read_text(path)
    with naming(path):
        return toml_of(text)


def write_aside(path: Path | str, content: bytes | str) -> None:
    """Write `content` beside `path`, then rename it: a reader sees the old file or the whole new one.

    What is there and no regular file (a device, a pipe, this process's own output) is written to as it is. Raises
    InputError where the folder is missing or not writable, or the disk is full; `path` is then as it was.
    """
    try:
        data = content.encode("utf-8") if isinstance(content, str) else content
        through = _stream(path)
        if through is not None:
            with os.fdopen(through, "wb") as stream:
                stream.write(data)
            return
        target = Path(os.path.realpath(path))  # a link keeps pointing where it points
        aside = _aside(target)
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


def check_target(path: Path | str) -> None:
    """Raise InputError where `path` cannot be written by `write_aside`, as far as that is known before the work."""
    try:
        target = Path(os.path.realpath(path))
        if target.is_dir():
            raise IsADirectoryError(21, _NO_FILE[stat.S_IFDIR])
        if target.exists() and not target.is_file():
            return  # a device or pipe
        if not target.parent.is_dir():
            raise FileNotFoundError(2, f"there is no folder {target.parent}")
        with suppress(FileNotFoundError):
            os.stat(_aside(target))  # too long a name
        if not os.access(target.parent, os.W_OK):
            raise PermissionError(13, "its folder cannot be written to")
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written ({_reason(error)})") from None


def _aside(target: Path) -> Path:
    return target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")


@contextmanager
def _opened(path: Path | str) -> Iterator[tuple[int, int]]:
    """Give a descriptor of the regular file `path` and its size [bytes]."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)  # a pipe would block
        try:
            found, largest = os.fstat(descriptor), _largest()
            if not stat.S_ISREG(found.st_mode):
                raise OSError(_NO_FILE.get(stat.S_IFMT(found.st_mode), "it is no regular file"))
            if found.st_size > largest:
                raise OSError(f"it holds {found.st_size:,} bytes, more than the {largest:,} of {LARGEST_VARIABLE}")
            yield descriptor, found.st_size
        finally:
            os.close(descriptor)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read ({_reason(error)})") from None


def _largest() -> int:
    asked = os.environ.get(LARGEST_VARIABLE, str(LARGEST))
    if not (asked.isascii() and asked.isdigit() and len(asked) < 19):
        raise InputError(f"{LARGEST_VARIABLE}: must be a whole number of bytes, got {shown(asked)}")
    return int(asked)


def _stream(path: Path | str) -> int | None:
    """Return a descriptor to write `path` through, None where it is a regular file or not there yet."""
    try:
        found = os.stat(path)
    except FileNotFoundError:
        return None
    for own in (sys.stdout, sys.stderr):  # /dev/stdout, also where it leads to a file that others write to as well
        with suppress(OSError, ValueError, AttributeError):
            if os.path.samestat(found, os.fstat(own.fileno())):
                own.flush()
                return os.dup(own.fileno())
    if stat.S_ISREG(found.st_mode):
        return None
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(21, _NO_FILE[stat.S_IFDIR])
    # without blocking: a pipe that nobody reads is an error, not a wait
    descriptor = os.open(path, os.O_WRONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)
    os.set_blocking(descriptor, True)
    return descriptor


def _reason(error: OSError | ValueError) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
