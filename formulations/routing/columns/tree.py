"""The tree: best bound first, of equal ones the newest first, branching on which UAV takes which task.

A child either gives task i to UAV k (forbids it to the others) or forbids it to UAV k and to all that are like it: of
UAVs that nothing has told apart yet, routes that give the task to another are those that give it to k, renamed. So the
children together miss no routes, but for their names. A UAV is like others until a task is given to it.
The tree's bound is the least bound of its open nodes, cut off at the cap. Bounds are often equal, because one UAV far
out sets them all: going down where it was last then ends in routes, going through them level by level does not.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence

import numpy as np

from formulations.routing.columns.legs import Legs
from formulations.routing.columns.node import Node, Workspace
from formulations.routing.columns.pricing import Column
from formulations.routing.columns.tightening import (
    Branch,
    Dear,
    Improved,
    Interrupted,
    Overtaken,
    Pruned,
    Stuck,
    tighten,
)
from formulations.routing.proved import StoppedBy
from formulations.routing.recorder import Recorder
from instances.arrays import Ints

_EQUAL = 1e-4
"""Bounds count as equal within this share."""


class Tree:
    """Best-first branch and price.

    kinds (m,) : UAVs of one number are alike (`Legs.kinds`); None: no two are.
    bound [s] : what is known before; most [s] : a cost that the best routes, if there are any, do not pass: the cap
        while none are known.
    """

    def __init__(
        self,
        legs: Legs,
        columns: Sequence[Column],
        work: Workspace,
        bound: float = 0.0,
        most: float = math.inf,
        kinds: Ints | None = None,
    ) -> None:
        self.work, self.m, self.most = work, legs.n_uavs, most
        self._open: list[tuple[float, int, Node]] = []
        """A heap by (class of equal bounds, newest first)."""
        self._count = 0
        self.kinds = np.arange(self.m) if kinds is None else kinds
        self._at: Node | None = None
        """The node that is worked on."""
        self._last = Node.root(legs, bound, list(columns), self.kinds)
        """The node that was worked on last, at first the root."""
        self._stuck = math.inf
        """The least bound of the nodes left aside."""
        self.push(self._last)

    def push(self, node: Node) -> None:
        """Add an open node."""
        self._count += 1
        of_equals = math.floor(math.log(node.bound) / _EQUAL) if node.bound > 0 else -math.inf
        heapq.heappush(self._open, (of_equals, -self._count, node))

    def pop(self) -> Node:
        """Take the node to work on next: of the least bounds the newest."""
        return heapq.heappop(self._open)[-1]

    @property
    def columns(self) -> list[Column]:
        """The columns of the open node that has most of them."""
        return max((node.columns for _, _, node in self._open), key=len, default=[])

    def bound(self, cap: float) -> float:
        """Return a lower bound on all routes, no higher than `cap` [s]."""
        at = math.inf if self._at is None else self._at.bound
        return min(cap, self._stuck, at, *(node.bound for _, _, node in self._open))

    def close(self) -> None:
        """Note the bounds of the nodes left open in the proof that is kept."""
        for _, _, node in self._open:
            self.work.log.close(node.number, node.proof)

    def grow(self, recorder: Recorder, tolerance: float, nodes: float) -> StoppedBy:
        """Improve the recorder's routes and bound until they meet, time is up, `nodes` are done or one is dear.

        A proof without routes is one that there are none.

        tolerance : share by which routes must be better to count: the cap, ever lower, on the tours to come.
        """

        def cap() -> float:
            return min(recorder.objective * (1 - tolerance), self.most)

        while self._open and self.bound(math.inf) <= cap() > 0:
            if nodes <= 0 or self.work.time_left() <= 0:
                limit = StoppedBy.TIME if self.work.time_left() <= 0 else StoppedBy.ITERATIONS
                return StoppedBy.MEMORY if self._stuck < math.inf else limit
            node = self.pop()
            if node.bound > cap():
                self.work.log.close(node.number, node.proof)
                continue
            self._at = self._last = node
            outcome = tighten(node, cap(), self.work)
            self._at = None
            if not isinstance(outcome, Overtaken):
                self.work.counts["nodes"] += 1
                nodes -= 1
            if isinstance(outcome, Improved | Branch | Stuck) and outcome.routes is not None:
                recorder.incumbent(outcome.routes)
            match outcome:
                case Pruned():
                    self.work.log.close(node.number, node.proof)
                case Branch(uav=k, task=i):
                    forbidden, others = node.alike(k), [other for other in range(self.m) if other != k]
                    self.push(node.child(i, forbidden, self.work.log.split(node.number, i, forbidden)))
                    self.push(node.giving(i, k, self.work.log.split(node.number, i, others)))
                case Stuck():
                    self._stuck = min(self._stuck, node.bound)
                    self.work.log.close(node.number, node.proof)
                case Improved() | Interrupted() | Overtaken() | Dear():
                    self.push(node)
            recorder.raise_bound(self.bound(cap()))
            if isinstance(outcome, Dear):
                return StoppedBy.ITERATIONS
        return StoppedBy.PROOF if self._stuck > cap() or cap() <= 0 else StoppedBy.MEMORY
