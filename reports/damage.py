"""Damage: whatever a damaged file does to the code that reads it becomes one sentence that names the file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from instances.errors import InputError, naming, shown


@contextmanager
def reading(path: Path, what: str) -> Iterator[None]:
    """Turn errors of a reader that trusts its file into an InputError: `path` is no such thing as `what`."""
    with naming(path):
        try:
            yield
        except InputError:
            raise
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, RecursionError) as error:
            raise InputError(
                f"{path}: does not describe {what} ({type(error).__name__}: {shown(str(error))})"
            ) from None
