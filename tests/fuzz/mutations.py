"""Mutations: bytes in, other bytes out. Each is drawn from a `Random`, so a case is its seed, target and number."""

from __future__ import annotations

import contextlib
import gzip
import json
import re
import zlib
from collections.abc import Callable, Iterator
from pathlib import PurePath
from random import Random
from typing import Any

from tests.fuzz import nasty

Mutation = Callable[[Random, bytes], bytes]
LARGEST = 1 << 20
"""Bytes beyond which a mutation does not make a file larger."""
TOKEN = re.compile(rb"[-+]?\.?\d[\w.+]*|\"[^\"\n]*\"|'[^'\n]*'|\b[A-Za-z_]+\b")
"""A number, a quoted text or a bare word."""


def flipped(rng: Random, data: bytes) -> bytes:
    """Change a few bytes."""
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 8, 64))):
        if changed:
            changed[rng.randrange(len(changed))] = rng.randrange(256)
    return bytes(changed)


def cut(rng: Random, data: bytes) -> bytes:
    """Leave out the end, the beginning or the middle."""
    first, last = sorted(rng.randint(0, len(data)) for _ in range(2))
    return rng.choice((data[:first], data[first:], data[:first] + data[last:]))


def doubled(rng: Random, data: bytes) -> bytes:
    """Repeat a piece, once or many times."""
    first, last = sorted(rng.randint(0, len(data)) for _ in range(2))
    times = rng.choice((2, 2, 10, 1000))
    return data[:first] + data[first:last] * min(times, 1 + LARGEST // max(1, last - first)) + data[last:]


def inserted(rng: Random, data: bytes) -> bytes:
    """Put nasty bytes somewhere."""
    at = rng.randint(0, len(data))
    return data[:at] + rng.choice(nasty.BYTES) + data[at:]


def retyped(rng: Random, data: bytes) -> bytes:
    """Replace one token, a number, a text or a word, by a nasty one."""
    found = list(TOKEN.finditer(data[:LARGEST]))
    if not found:
        return inserted(rng, data)
    token = rng.choice(found)
    words = nasty.TOML if rng.random() < 0.6 else (*nasty.NUMBERS, *nasty.WORDS, *nasty.FILES)
    return data[: token.start()] + rng.choice(words).encode("utf-8", "surrogatepass") + data[token.end() :]


def relined(rng: Random, data: bytes) -> bytes:
    """Delete, repeat, swap or blank lines, or end them otherwise."""
    lines = data.splitlines(keepends=True) or [b""]
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(5):
        case 0:
            del lines[i]
        case 1:
            lines.insert(j, lines[i])
        case 2:
            lines[i], lines[j] = lines[j], lines[i]
        case 3:
            lines[i] = b"\n"
        case _:
            lines = [line.replace(b"\n", rng.choice((b"\r", b"\r\n", b""))) for line in lines]
    return b"".join(lines)


def places(tree: Any) -> Iterator[tuple[Any, Any]]:
    """Yield every (container, key) of a JSON value, outermost first."""
    for key in list(tree) if isinstance(tree, dict) else range(len(tree)):
        yield tree, key
        if isinstance(tree[key], (dict, list)):
            yield from places(tree[key])


def regrown(rng: Random, data: bytes) -> bytes:
    """Replace, delete, rename or double a value of a JSON file; not valid JSON afterwards, if need be."""
    try:
        tree = json.loads(data)
        found = list(places(tree))
    except (ValueError, TypeError, RecursionError):
        return retyped(rng, data)
    if not found:
        return retyped(rng, data)
    named = [place for place in found if isinstance(place[0], dict)]  # not only numbers out of long lists
    holder, key = rng.choice(named if named and rng.random() < 0.6 else found)
    mark = "\x01mark\x01"
    match rng.randrange(8):
        case 0:
            del holder[key]
        case 1 if isinstance(holder, dict):
            holder[rng.choice(nasty.WORDS)] = holder.pop(key)
        case 1:
            holder.insert(key, holder[key])
        case 2:
            other, name = rng.choice(found)
            with contextlib.suppress(KeyError, IndexError):
                holder[key] = json.loads(json.dumps(other[name]))
        case 3:
            holder[key] = rng.choice((*nasty.WORDS, *nasty.FILES))
        case _:
            holder[key] = mark
    return json.dumps(tree).replace(json.dumps(mark), rng.choice(nasty.JSON)).encode()


def squeezed(inner: Mutation) -> Mutation:
    """Return `inner` applied inside gzip."""

    def mutate(rng: Random, data: bytes) -> bytes:
        try:
            content = gzip.decompress(data)
        except (OSError, EOFError, zlib.error):
            return flipped(rng, data)
        return gzip.compress(inner(rng, content), 1, mtime=0)

    return mutate


def bomb(rng: Random, data: bytes) -> bytes:
    """Return gzip that opens to a hundred times its size, of the file's own beginning or of brackets."""
    piece = rng.choice((b"[", b" ", b"1,", b"\n"))
    return gzip.compress(piece * (rng.choice((1, 1, 4)) << 20), 9, mtime=0)


RAW = (flipped, cut, doubled, inserted)
TEXT = (retyped, retyped, retyped, relined, *RAW)
TREE = (regrown, regrown, regrown, regrown, *TEXT)
SQUEEZED = (*(squeezed(mutation) for mutation in TREE), *RAW, bomb)
BY_ENDING: dict[str, tuple[Mutation, ...]] = {
    ".json": TREE,
    ".geojson": TREE,
    ".gz": SQUEEZED,
    ".nc": (flipped, flipped, flipped, *RAW),
    ".tif": (flipped, flipped, *RAW),
}


def mutated(rng: Random, name: str, data: bytes) -> bytes:
    """Return the content of the file `name`, changed once or a few times in the ways its format invites."""
    ways = BY_ENDING.get(PurePath(name).suffix, TEXT)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        data = rng.choice(ways)(rng, data)
    return data
