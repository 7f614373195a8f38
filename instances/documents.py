"""What the content of a file says, as text, gzip, JSON or TOML: in time and memory that the file's size explains.

Every function takes what was read and raises InputError with a sentence that does not name the file;
`instances.disk` reads the file and puts its name in front.
"""

from __future__ import annotations

import gzip
import io
import json
import re
import tomllib
import zlib
from collections.abc import Iterable
from typing import Any, NoReturn

from instances.errors import InputError, shown

DEEPEST = 100
"""Lists and tables inside each other that a document may hold; whoever walks it by recursion relies on it."""
OPENS_TO = 64
"""Times its own size that a compressed file may open to."""
OPENS_AT_LEAST = 64_000_000
"""Bytes that every compressed file may open to: the costs of 1,000 nodes at 64 characters a number."""
CHUNK = 1 << 20
"""Bytes decompressed at a time."""

_LONG_KEY = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]+[ \t]*\.[ \t]*){{{DEEPEST}}}""")
"""A dotted key of too many parts: tomllib takes the square of their number."""
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")


def text_of(content: bytes | bytearray) -> str:
    """Return `content` as the UTF-8 text it is."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text (byte {error.start})") from None
    if "\0" in text:
        raise InputError(f"is not text but binary (byte {text.index(chr(0))} is zero)")
    return text


def most_opened(size: int) -> int:
    """Return how many bytes a compressed file of `size` bytes may open to."""
    return max(OPENS_AT_LEAST, OPENS_TO * size)


def decompressed(content: bytes) -> bytearray:
    """Return what gzip packed into `content`; no more than `most_opened` of it is ever held."""
    opened, most = bytearray(), most_opened(len(content))
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(content)) as file:
            while piece := file.read(CHUNK):
                opened += piece
                if len(opened) > most:
                    raise InputError(f"cannot be decompressed (it opens to more than {most:,} bytes; unpack it first)")
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"cannot be decompressed ({error})") from None
    return opened


def json_of(text: str) -> Any:
    """Return the JSON value in `text`: no key twice, no NaN or Infinity, nested at most DEEPEST deep, text Unicode."""
    try:
        value = json.loads(text, object_pairs_hook=_without_duplicates, parse_constant=_refuse_constant)
        if _SURROGATE.search(text):
            json.dumps(value, ensure_ascii=False).encode()
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not valid JSON ({_reason(error)})") from None
    return _not_too_deep(value, "JSON")


def toml_of(text: str) -> dict[str, Any]:
    """Return the TOML table in `text`, nested at most DEEPEST deep."""
    if _LONG_KEY.search(text):
        raise InputError(f"is not valid TOML (a key of more than {DEEPEST} parts)")
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not valid TOML ({_reason(error)})") from None
    _not_too_deep(table, "TOML")
    return table


def _reason(error: ValueError | RecursionError) -> str:
    """Return what a parser complains of, without Python's own affairs."""
    if isinstance(error, RecursionError):
        return "it is nested too deeply"
    if isinstance(error, UnicodeEncodeError):
        return "it holds half a character, a lone surrogate"
    return "a whole number of too many digits" if "integer string conversion" in str(error) else str(error)


def _not_too_deep(value: Any, kind: str) -> Any:
    within: list[Any] = [value]
    for _ in range(DEEPEST):
        within = [
            part
            for whole in within
            if isinstance(whole, (list, dict))
            for part in (whole.values() if isinstance(whole, dict) else whole)
            if isinstance(part, (list, dict))
        ]
        if not within:
            return value
    raise InputError(f"is not valid {kind} (it is nested more than {DEEPEST} deep)")


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON number")


def _without_duplicates(pairs: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise InputError(f"the key {shown(key)} is given twice")
        found[key] = value
    return found
