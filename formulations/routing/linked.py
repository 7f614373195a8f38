"""Linked recorders: two processes on one instance that share incumbent and bound as they find them."""

from __future__ import annotations

from multiprocessing.connection import Connection

from formulations.limits import Limits
from formulations.routing.recorder import Recorder
from formulations.routing.solver import Observer
from instances import Instance, Routes


class LinkedRecorder(Recorder):
    """A recorder that tells a peer what it learns, and learns from it whenever it is asked for the time left.

    Methods ask for `remaining` often, so that is where messages are read. Once bound and incumbent meet, or the peer is
    gone with a proof, no time remains.
    """

    def __init__(
        self,
        instance: Instance,
        limits: Limits,
        observe: Observer,
        start: Routes | None,
        link: Connection | None = None,
    ) -> None:
        self.link: Connection | None = None
        self.tolerance = 0.0
        self.met_by_peer = False
        super().__init__(instance, limits, observe, start)
        self.link = link

    @property
    def remaining(self) -> float:
        """Wall clock left [s]; 0 once bound and incumbent meet."""
        self.listen()
        return 0.0 if self.met_by_peer else super().remaining

    def incumbent(self, routes: Routes) -> bool:
        """Keep better routes and pass them on."""
        better = super().incumbent(routes)
        if better:
            self._tell(("routes", self.routes))
        return better

    def raise_bound(self, bound: float) -> bool:
        """Keep a higher bound and pass it on."""
        better = super().raise_bound(bound)
        if better:
            self._tell(("bound", bound))
        return better

    def listen(self) -> None:
        """Take in what the peer has sent."""
        link, self.link = self.link, None  # what came from the peer is not sent back
        try:
            while link is not None and link.poll():
                kind, value = link.recv()
                if kind == "routes":
                    super().incumbent(value)
                elif kind == "bound":
                    super().raise_bound(value)
                elif kind == "proof":
                    self.tolerance, self.met_by_peer = value, True
        except (EOFError, OSError):  # the peer has ended; what it said stays
            link = None
        self.link = link

    def _tell(self, message: tuple[str, object]) -> None:
        if self.link is not None:
            try:
                self.link.send(message)
            except (BrokenPipeError, OSError):
                self.link = None

    def tell_proof(self, tolerance: float) -> None:
        """Say that routes and bound now meet within `tolerance` [s]."""
        self._tell(("proof", tolerance))
