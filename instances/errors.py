"""What is wrong with something a person gave us, in one sentence."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches


class InputError(ValueError):
    """A file, field or value given by the user cannot be used; the message is one sentence naming it.

    The command line prints the message and exits with code 2.
    """


def suggestion(wrong: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the near miss of `wrong` among `known`, or ``""``."""
    near = get_close_matches(wrong, list(known), n=1)
    return f"; did you mean '{near[0]}'?" if near else ""


@contextmanager
def naming(path: object) -> Iterator[None]:
    """Put the file's name in front of an InputError raised inside that does not begin with it."""
    try:
        yield
    except InputError as error:
        raise InputError(str(error) if str(error).startswith(f"{path}: ") else f"{path}: {error}") from None
