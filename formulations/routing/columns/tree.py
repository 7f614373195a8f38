"""The tree: best bound first, branching on which UAV takes which task.

A child either gives task i to UAV k (forbids it to the others) or forbids it to UAV k: together they miss no routes.
The tree's bound is the least bound of its open nodes, cut off at the cap.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.legs import Legs
from formulations.routing.columns.node import Node, Workspace, relax, tighten
from formulations.routing.columns.pricing import Column
from instances import Routes


@dataclass(frozen=True)
class Incumbent:
    """The best routes, kept elsewhere: the `cap` better ones must meet, how to `offer` some and `report` bounds."""

    cap: Callable[[], float]
    offer: Callable[[Routes], object]
    report: Callable[[float], object]


class Tree:
    """Best-first branch and price below an incumbent."""

    def __init__(self, legs: Legs, columns: Sequence[Column], work: Workspace) -> None:
        self.work = work
        self.m, self.n = legs.n_uavs, legs.n_tasks
        self._open: list[tuple[float, int, Node]] = []
        self._count = 0
        self.stuck = False
        """Whether a node was left whose tasks are all decided but whose tours are too many for the label store."""
        self._push(Node(legs, 0.0, list(columns)))

    def _push(self, node: Node) -> None:
        self._count += 1
        heapq.heappush(self._open, (node.bound, self._count, node))

    def bound(self, cap: float) -> float:
        """Return a lower bound on all routes, no higher than `cap` [s]."""
        return min(cap, self._open[0][0]) if self._open else cap

    def relax(self, incumbent: Incumbent) -> None:
        """Solve the relaxation of the root once, before any work that depends on how good the incumbent is."""
        _, _, root = heapq.heappop(self._open)
        relax(root, incumbent.cap(), self.work)
        self._push(root)
        incumbent.report(self.bound(incumbent.cap()))

    def grow(self, incumbent: Incumbent, nodes: float = math.inf) -> bool:
        """Work until no routes of cost ≤ cap are left (True), or time is up or `nodes` are done (False)."""
        while self._open and self._open[0][0] <= incumbent.cap():
            if nodes <= 0 or self.work.out_of_time():
                return False
            nodes -= 1
            node = heapq.heappop(self._open)[-1]
            cap = incumbent.cap()
            tighten(node, cap, self.work)
            self.work.count("nodes")
            if node.routes is not None:
                incumbent.offer(tuple(node.routes[k].tasks if k in node.routes else () for k in range(self.m)))
            if node.share is not None:
                children = self._children(node, node.share)
                for child in children:
                    self._push(child)
                if not children:
                    self._push(node)
                    self.stuck = True
                    return False
            elif node.bound <= cap:
                self._push(node)
            incumbent.report(self.bound(incumbent.cap()))
        return True

    def _children(self, node: Node, share: NDArray[np.float64]) -> list[Node]:
        """Branch on the most shared task, else on any undecided one; none where all are decided."""
        allowed = node.may_visit()
        undecided = allowed & (allowed.sum(axis=0) > 1)
        if not undecided.any():
            return []
        fractional = np.where(undecided, np.minimum(share, 1 - share).round(6), -1.0)
        k, i = np.unravel_index(int(np.argmax(fractional)), share.shape)
        others = [o for o in range(self.m) if o != k]
        return [_child(node, int(i), others), _child(node, int(i), [int(k)])]


def _child(node: Node, task: int, uavs: list[int]) -> Node:
    """Return the node with `task` forbidden to `uavs`."""
    columns = [c for c in node.columns if c.uav not in uavs or task not in c.tasks]
    pool = None if node.pool is None else node.pool.without(task, uavs)
    return Node(node.legs.without(task, uavs), node.bound, columns, node.cuts, node.centre, pool, node.room)
