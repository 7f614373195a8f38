"""What a proof relied on, as it is made: the cases of the tree and the prices that put tours aside or closed a case.

`instances.certificate` says what it means and checks it. Nothing else of the tree's work is kept: legs fixed away and
tours dropped by columns follow from the prices.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.columns.pricing import DualBound
from instances.arrays import Bools
from instances.certificate import Node, Prices, Step


class ProofLog:
    """Keeps nothing: most proofs are not asked for their certificate."""

    def split(self, parent: int, task: int, forbidden: list[int]) -> int:
        """Note the case of `parent` in which `task` is forbidden to some UAVs; return its number."""
        return 0

    def put_aside(self, node: int, at: DualBound, listed: Bools) -> None:
        """Note that tours were put aside by their reduced costs, and whose tours were listed then, (m,)."""

    def close(self, node: int, at: DualBound | None) -> None:
        """Note the prices at which the bound of a leaf holds."""


class KeptProof(ProofLog):
    """Keeps all of it. `bound` [s]: the least bound of a leaf."""

    def __init__(self) -> None:
        self.nodes, self.steps, self.bound = [Node()], list[Step](), np.inf

    def split(self, parent: int, task: int, forbidden: list[int]) -> int:
        """Note a case."""
        self.nodes.append(Node(parent, task, tuple(forbidden)))
        return len(self.nodes) - 1

    def put_aside(self, node: int, at: DualBound, listed: Bools) -> None:
        """Note a step that leaves fewer tours."""
        self.steps.append(Step(node, _prices(at), tuple(np.flatnonzero(listed).tolist())))

    def close(self, node: int, at: DualBound | None) -> None:
        """Note a leaf and its bound."""
        self.bound = min(self.bound, -np.inf if at is None else at.value)
        if at is not None:
            self.steps.append(Step(node, _prices(at), closes=True))


def _prices(at: DualBound) -> Prices:
    duals = at.duals.paid()
    task, uav, least = duals.price.tolist(), duals.sigma.tolist(), np.minimum(at.least, 0.0).tolist()
    return Prices(tuple(task), tuple(uav), tuple(least), duals.cuts, tuple(duals.rho.tolist()))
