"""Helpers: processes of their own that work on cases of the tree, a turn at a time.

The tree keeps all cases, and lends a helper some: at the end of a turn it has back what is open of them. So it may deal
them out anew, and a helper that ends, whatever of, loses no case.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections import Counter
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, NamedTuple

from formulations.limits import Limits
from formulations.routing.arcs.case import Case
from formulations.routing.peer import Peer
from formulations.routing.recorder import Recorder
from formulations.routing.solver import ignore
from instances import Instance, Routes

if TYPE_CHECKING:
    from formulations.routing.arcs.tree import CaseTree

TURN = 5
"""Cases of a turn, at most."""

MakeTree = Callable[[Callable[[], float]], "CaseTree"]


class Found(NamedTuple):
    """What a turn came to: cases still open, the least bound of those left aside, in units of U, routes, counts."""

    cases: list[Case]
    stuck: float
    routes: Routes | None
    counts: Counter[str]


class Helper:
    """A helper of an instance's tree, which it makes for itself; end its `peer` in the end.

    cases : lent to it, the newest last; busy : whether it works on them.
    """

    def __init__(self, instance: Instance, make: MakeTree) -> None:
        self.cases: list[Case] = []
        self.busy = False
        self.peer = Peer(_serve, instance, make)

    @property
    def bound(self) -> float:
        """The least bound of the cases lent, in units of U."""
        return min((case.bound for case in self.cases), default=math.inf)

    def begin(self, cap: float, time: float) -> None:
        """Begin a turn: for routes of cost below `cap` [s], of `time` [s] at most."""
        self.busy = True
        with contextlib.suppress(OSError):  # its end is seen when the turn is
            self.peer.link.send((self.cases, cap, time))

    def end(self, wait: float) -> Found | None:
        """Return what the turn came to, if that is known within `wait` [s]; where the helper has ended: nothing."""
        try:
            if not self.peer.link.poll(wait):
                return None
            found: Found = self.peer.link.recv()
        except (EOFError, OSError):
            found = Found(self.cases, math.inf, None, Counter())
        self.cases, self.busy = found.cases, False
        return found

    @property
    def alive(self) -> bool:
        """Whether it may be lent cases."""
        return bool(self.peer.process.is_alive())


def _serve(link: Connection, instance: Instance, make: MakeTree) -> None:
    """Work on cases in this process for as long as some are lent."""
    until = 0.0
    tree = make(lambda: max(0.0, until - time.perf_counter()))
    with contextlib.suppress(KeyboardInterrupt, EOFError, OSError):
        while True:
            cases, cap, left = link.recv()
            until = time.perf_counter() + left
            recorder = Recorder(instance, Limits(time=left), ignore)
            link.send(tree.turn(cases, recorder, cap))
