"""A peer: another process that works beside this one, with a link between the two."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

_ENDING = 0.2  # seconds a peer is given to end by itself


class Peer:
    """A process that does `work`, given its end of the link and `about`; `end` it.

    link : this end; process : its own, which begins at once and ends with this one.
    """

    def __init__(self, work: Callable[..., None], *about: object) -> None:
        methods = multiprocessing.get_all_start_methods()
        context: Any = multiprocessing.get_context("fork" if "fork" in methods else "spawn")
        self.link, there = context.Pipe()
        self.process = context.Process(target=_begin, args=(work, self.link, there, *about), daemon=True)
        self.process.start()
        there.close()

    def end(self) -> None:
        """Close the link, and end the process where it does not end of itself then."""
        self.link.close()
        self.process.join(_ENDING)
        if self.process.is_alive():
            self.process.terminate()
            self.process.join()


def _begin(work: Callable[..., None], others: Connection, link: Connection, *about: object) -> None:
    others.close()
    work(link, *about)
