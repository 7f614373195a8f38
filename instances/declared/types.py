"""What keys of files hold: numbers with their bounds, texts, points; and what a key says about itself."""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
from msgspec import Meta

from instances.extent import LARGEST, LEAST


class Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A table of a file: every key that is not a field of it is refused."""


def about(meaning: str, unit: str = "", *, example: Any = None, words: str = "", given: bool = True) -> Meta:
    """Return what a key says about itself.

    meaning : a line for people. example : a value to show. words : what it takes, where its type does not say it all.
    given : whether a template gives it a value.
    """
    notes = {"unit": unit, "words": words, "template": None if given else "comment"}
    return Meta(
        description=meaning,
        examples=None if example is None else [example],
        extra={key: note for key, note in notes.items() if note},
        extra_json_schema={"unit": unit} if unit else None,
    )


Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Meta(ge=0, le=LARGEST)]
Positive = Annotated[float, Meta(ge=LEAST, le=LARGEST)]
Whole = Annotated[int, Meta(ge=0, le=2**63 - 1)]
Natural = Annotated[int, Meta(ge=1, le=2**63 - 1)]
Text = Annotated[str, Meta(min_length=1)]
FileName = Annotated[str, Meta(min_length=1, extra={"words": "the name of a file"})]
Name = Annotated[
    str, Meta(extra_json_schema={"minLength": 1, "maxLength": 120, "pattern": r"^(?=.*\S)[^./\\][^/\\]*$"})
]
"""A text that can stand in the name of a file: `instances.instance.check_name` says what is wrong with one."""
Pair = tuple[float, float]
"""[x, y]; whoever uses it asks where it lies."""
Vector = tuple[Number, Number]
