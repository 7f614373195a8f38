"""Messages: what a child says to its parent, one JSON object a line, checked by one schema before anything believes it.

    started, compiling (or not), prepared, event …, result        or, at the places of the schema, declined or error

Numbers are finite, texts can be encoded, tables are not nested deeper than `Figure` allows and not larger than stated
here; the product is decoded by the type its problem names. Whatever is wrong is an UnreadableError.
"""

from __future__ import annotations

import math
import reprlib
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Raw, Struct

from instances.declared.prepared import prepared
from instances.errors import one_line

LONGEST_TEXT = 2000
"""Characters of a text that are kept: a sentence, not a book."""
LARGEST_STATISTICS = 1 << 18
"""Bytes of a method's own figures."""
DEEPEST = 3
"""Tables in one another that a figure may be."""

Leaf = None | bool | Annotated[int, Meta(ge=-(2**63), le=2**63 - 1)] | float | str
Row = list[Leaf] | dict[str, Leaf]
Table = list[Leaf | Row] | dict[str, Leaf | Row]
Figure = Leaf | list[Leaf | Table] | dict[str, Leaf | Table]
"""A figure of a method's own: a value, or tables of them at most DEEPEST deep."""


class UnreadableError(ValueError):
    """What came through the pipe is no message, or not one that may come now; the message says why."""


class Claimed(Struct, forbid_unknown_fields=True):
    """What a method says it found; see `workbench.jobs.problem.Claim`."""

    product: Raw = Raw(b"null")
    objective: float | None = None
    bound: float | None = None


class Ended(Claimed, forbid_unknown_fields=True, kw_only=True):
    """What it says at the end."""

    status: str
    stopped_by: str
    message: str
    tolerance: Annotated[float, Meta(ge=0)]
    statistics: dict[str, Figure]


class Started(Struct, tag="started", tag_field="kind", forbid_unknown_fields=True):
    """The method exists. proves : whether it can end with a proof."""

    proves: bool


class Declined(Struct, tag="declined", tag_field="kind", forbid_unknown_fields=True):
    """The method does not take the item."""

    reason: str


class Compiling(Struct, tag="compiling", tag_field="kind", forbid_unknown_fields=True):
    """Preparing is going to take a while: kernels are compiled."""


class Prepared(Struct, tag="prepared", tag_field="kind", forbid_unknown_fields=True):
    """The solve begins."""


class Event(Struct, tag="event", tag_field="kind", forbid_unknown_fields=True):
    """Something was found on the way."""

    claim: Claimed


class Result(Struct, tag="result", tag_field="kind", forbid_unknown_fields=True):
    """The solve has ended."""

    claim: Ended


class Failed(Struct, tag="error", tag_field="kind", forbid_unknown_fields=True):
    """Something was raised."""

    message: str


Message = Started | Compiling | Declined | Prepared | Event | Result | Failed
FOLLOWS: dict[type[Any] | None, tuple[type[Any], ...]] = {
    None: (Started, Failed),
    Started: (Compiling, Declined, Prepared, Failed),
    Compiling: (Declined, Prepared, Failed),
    Prepared: (Event, Result, Failed),
    Event: (Event, Result, Failed),
}
"""What may come after a message of a kind; nothing is heard after the others."""
_decoder = msgspec.json.Decoder(prepared(Message))


def read_message(line: bytes) -> Message:
    """Return the message in `line`; UnreadableError where it is none."""
    try:
        message: Message = _decoder.decode(line)
        if isinstance(message, Result):
            _check_size(message.claim.statistics)
    except (ValueError, RecursionError, OverflowError) as error:
        start = line[:40].decode("utf-8", errors="replace")
        raise UnreadableError(f"{start!r} ({one_line(str(error), 200)})") from None
    return message


def read_product(raw: Raw, kind: Any) -> Any:
    """Return the product in `raw` as type `kind`, or None; UnreadableError where it is neither."""
    try:
        return msgspec.json.decode(raw, type=prepared(kind | None))
    except (ValueError, RecursionError, OverflowError) as error:
        raise UnreadableError(one_line(str(error), 200)) from None


def written(message: Message) -> bytes:
    """Return the line that says `message`."""
    return msgspec.json.encode(message) + b"\n"


def encoded(product: Any) -> Raw:
    """Return a product (JSON values, numpy's numbers and arrays among them) as it stands in a message."""
    return Raw(msgspec.json.encode(product, enc_hook=_plain))


def finite(name: str, value: Any) -> float:
    """Return `value` as a number; ValueError names the figure where it is infinite or none."""
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"claimed a {name} of {number!r}, which is not a finite number")
    return number


def text(value: Any) -> str:
    """Return `value` as a text that can be written into any file, cut where it is very long."""
    return str(value)[:LONGEST_TEXT].encode("utf-8", "backslashreplace").decode("utf-8")


def figure(value: Any, deep: int = DEEPEST) -> Any:
    """Return a method's own figure as it is stored: what the schema does not have (infinities, objects) spelled out."""
    value = value.tolist() if hasattr(value, "tolist") else value  # numpy's
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if value is None or isinstance(value, (bool, int, float)):
        return value
    if isinstance(value, dict) and deep:
        return {text(key): figure(each, deep - 1) for key, each in value.items()}
    if isinstance(value, (list, tuple)) and deep:
        return [figure(each, deep - 1) for each in value]
    return text(value if isinstance(value, str) else reprlib.repr(value))


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"a product cannot hold {type(value).__name__}")


def _check_size(statistics: dict[str, Any]) -> None:
    size = len(msgspec.json.encode(statistics))
    if size > LARGEST_STATISTICS:
        raise ValueError(f"statistics of {size} bytes, more than {LARGEST_STATISTICS}")
