"""Compilation told: kernels are compiled when they are first used, for seconds in which nothing else happens.

Whoever is first to wait for it says so on stderr: a spinner that goes away on a terminal, one line a process elsewhere.
A process that has a better place for it (a run's, a study's) takes it over with `told_to`.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

WORDS = "compiling kernels, once"
Teller = Callable[[bool], None]
"""Told True when a compilation begins and False when it has ended; those inside it are not told."""


class OnStderr:
    """The usual teller."""

    def __init__(self) -> None:
        self._said = False
        self._spinner: Any = None

    def __call__(self, begins: bool) -> None:
        """Say it, or let the spinner go away."""
        if self._spinner is not None:
            self._spinner.stop()
            self._spinner = None
        if begins and sys.stderr.isatty():
            from rich.console import Console  # here: most processes compile nothing

            self._spinner = Console(stderr=True).status(WORDS)
            self._spinner.start()
        elif begins and not self._said:
            print(WORDS, file=sys.stderr, flush=True)
        self._said = True


_lock = threading.RLock()
_tellers: list[Teller] = [OnStderr()]
_under_way = 0


def _tell(change: int) -> None:
    global _under_way
    with _lock:
        before, _under_way = _under_way, _under_way + change
        if not before or not _under_way:
            _tellers[-1](change > 0)


def begun() -> None:
    """Take note that a compilation has begun, here or in a process started from here."""
    _tell(1)


def ended() -> None:
    """Take note that one of those begun has ended."""
    _tell(-1)


@contextmanager
def told_to(teller: Teller) -> Iterator[None]:
    """Let `teller` be told instead of who was until then."""
    _tellers.append(teller)
    try:
        yield
    finally:
        _tellers.remove(teller)
