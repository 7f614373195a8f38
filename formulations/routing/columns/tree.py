"""The tree: best bound first, of equal ones the newest first, branching on which UAV takes which task.

A child either gives task i to UAV k (forbids it to the others) or forbids it to UAV k: together they miss no routes.
The tree's bound is the least bound of its open nodes, cut off at the cap. Bounds are often equal, because one UAV far
out sets them all: going down where it was last then ends in routes, going through them level by level does not.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from formulations.routing.columns.legs import Legs
from formulations.routing.columns.node import Node, Workspace, tighten
from formulations.routing.columns.pool import Pool
from formulations.routing.columns.pricing import Column
from instances import Routes

_EQUAL = 1e-4
"""Bounds count as equal within this share."""


@dataclass(frozen=True)
class Incumbent:
    """The best routes, kept elsewhere: the `cap` better ones must meet, how to `offer` some and `report` bounds."""

    cap: Callable[[], float]
    offer: Callable[[Routes], object]
    report: Callable[[float], object]


class Tree:
    """Best-first branch and price below an incumbent; `bound` [s] is what is known before."""

    def __init__(self, legs: Legs, columns: Sequence[Column], work: Workspace, bound: float = 0.0) -> None:
        self.work = work
        self.m, self.n = legs.n_uavs, legs.n_tasks
        self._open: list[tuple[float, int, Node]] = []
        """A heap by (class of equal bounds, newest first)."""
        self._count = 0
        self._stuck = math.inf
        self.push(Node(legs, bound, list(columns), Pool.empty(self.m, self.n)))

    def push(self, node: Node) -> None:
        """Add an open node."""
        self._count += 1
        of_equals = math.floor(math.log(node.bound) / _EQUAL) if node.bound > 0 else -math.inf
        heapq.heappush(self._open, (of_equals, -self._count, node))

    def pop(self) -> Node:
        """Take the node to work on next: of the least bounds the newest."""
        return heapq.heappop(self._open)[-1]

    def bound(self, cap: float) -> float:
        """Return a lower bound on all routes, no higher than `cap` [s]."""
        return min(cap, self._stuck, *(node.bound for _, _, node in self._open))

    @property
    def stuck(self) -> bool:
        """Whether nodes were left whose tasks are all decided, but whose tours are too many for the label store."""
        return self._stuck < math.inf

    def grow(self, incumbent: Incumbent, nodes: float = math.inf) -> bool:
        """Work until no routes of cost ≤ cap are left (True), or time is up, `nodes` are done or some stuck (False)."""
        while self._open and self.bound(math.inf) <= incumbent.cap() > 0:
            if nodes <= 0 or self.work.out_of_time():
                return False
            node, cap = self.pop(), incumbent.cap()
            if node.bound > cap:
                continue
            if tighten(node, cap, self.work):
                self.work.count("nodes")
                nodes -= 1
            if node.routes is not None:
                incumbent.offer(tuple(node.routes[k].tasks if k in node.routes else () for k in range(self.m)))
            if node.ready and node.branch is None:
                self._stuck = min(self._stuck, node.bound)
            elif node.ready and node.branch is not None:
                k, i = node.branch
                self.push(_child(node, i, [k]))
                self.push(_child(node, i, [other for other in range(self.m) if other != k]))
            elif node.bound <= cap:
                self.push(node)
            incumbent.report(self.bound(incumbent.cap()))
        return self._stuck > incumbent.cap() or incumbent.cap() <= 0


def _child(node: Node, task: int, uavs: list[int]) -> Node:
    """Return the node with `task` forbidden to `uavs`."""
    columns = [c for c in node.columns if c.uav not in uavs or task not in c.tasks]
    legs = node.legs.without(task, uavs)
    pool = node.pool.without(task, uavs)
    return replace(node, legs=legs, columns=columns, pool=pool, ready=False, branch=None, routes=None)
