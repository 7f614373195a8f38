"""Threads that look for tours of several UAVs at once, each with room for labels of its own.

Subproblems of different UAVs have nothing in common but the duals, and kernels let go of the interpreter's lock. What
is found is put together in the order of the UAVs, so that it does not depend on which thread is first.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol, TypeVar

from formulations.routing.columns.label_search import Labels

Given = TypeVar("Given")
Made = TypeVar("Made")


class Each(Protocol):
    """Does the same for all of something given, in its order."""

    def __call__(self, work: Callable[[Given], Made], given: Iterable[Given]) -> list[Made]:
        """Return what `work` makes of everything given."""


def one_by_one(work: Callable[[Given], Made], given: Iterable[Given]) -> list[Made]:
    """Return what `work` makes of everything given."""
    return [work(one) for one in given]


class Team:
    """So many `threads`; `room` makes room for the labels of one of them, the first time it asks.

    over : whether what is under way is to be left: one piece of work has failed, or was interrupted.
    """

    def __init__(self, room: Callable[[], Labels], threads: int = 1) -> None:
        self.size, self.over, self._room, self._own = threads, False, room, threading.local()
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def of_uav(self, k: int) -> Labels:
        """Return the room for labels of UAV k in the thread that asks."""
        if not hasattr(self._own, "labels"):
            self._own.labels = self._room()
        labels: Labels = self._own.labels
        return labels.of_uav(k)

    def each(self, work: Callable[[Given], Made], given: Iterable[Given]) -> list[Made]:
        """Return what `work` makes of everything given, in its order."""
        if self._pool is None:
            return one_by_one(work, given)
        try:
            return list(self._pool.map(work, given))
        except BaseException:
            self.over = True
            raise
