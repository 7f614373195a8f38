"""What is wrong with something a person gave us, in one sentence."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches

LONGEST_VALUE = 80
"""Characters of a value that a sentence repeats."""
NO_BREAK = "\u00a0"
"""A space, if one that Python does not call printable."""
LONGEST_SENTENCE = 1000
"""Characters of a sentence about an input."""


_LONG_WORD = re.compile(r"\S{256,}")
"""A word longer than any name of a file: a value that was given whole."""


class InputError(ValueError):
    """A file, field or value given by the user cannot be used; the message is one sentence naming it.

    The message is one line of printable characters, cut where it is very long: what it repeats of a file may be
    anything. The command line prints the message and exits with code 2.
    """

    def __init__(self, sentence: str) -> None:
        short = _LONG_WORD.sub(lambda word: f"{word[0][: LONGEST_VALUE - 1]}…", sentence)
        super().__init__(one_line(short, LONGEST_SENTENCE))


def one_line(text: str, longest: int) -> str:
    """Return `text` on one line: unprintable characters escaped, the end cut where it is longer than `longest`."""
    if not text.isprintable():
        plain = (
            c if c.isprintable() or c == NO_BREAK else " " if c in "\n\r\t" else ascii(c)[1:-1] for c in text[:longest]
        )
        text = "".join(plain) + text[longest:]
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def shown(value: object) -> str:
    """Return `value` as a sentence repeats it: as Python writes it, one line of at most LONGEST_VALUE characters."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # a whole number of thousands of digits; something nested without end
        text = f"a {type(value).__name__} too large to be written"
    return one_line(text, LONGEST_VALUE)


def suggestion(wrong: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the near miss of `wrong` among `known`, or ``""``."""
    near = get_close_matches(wrong[:LONGEST_VALUE], list(known), n=1)
    return f"; did you mean '{near[0]}'?" if near else ""


@contextmanager
def naming(path: object) -> Iterator[None]:
    """Put the file's name in front of an InputError raised inside that does not begin with it."""
    try:
        yield
    except InputError as error:
        raise InputError(str(error) if str(error).startswith(f"{path}: ") else f"{path}: {error}") from None
