"""BLAS on one thread: on matrices this small a second one only spins, and it rounds otherwise, which turns ties."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController


@cache
def _controller() -> ThreadpoolController:
    """Return the handle on the libraries loaded by now (finding them takes milliseconds)."""
    return ThreadpoolController()


@contextmanager
def one_thread() -> Iterator[None]:
    """Let BLAS start no second thread meanwhile; also a decorator."""
    with _controller().limit(limits=1, user_api="blas"):
        yield
