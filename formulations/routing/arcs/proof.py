"""What a proof over arcs rests on, as it is made: the cases of the tree, and the prices at which each ended.

`instances.certificate` says what it means and checks it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from formulations.routing.arcs.case import Case, Give, Split
from formulations.routing.arcs.joint import Blossom, Joint
from formulations.routing.arcs.lagrangian import ArcPrices
from instances.arrays import Floats
from instances.certificate import ArcPrices as StoredPrices
from instances.certificate import Blossom as StoredBlossom
from instances.certificate import Crowd as StoredCrowd
from instances.certificate import Cut, Node, Step

_DIGITS = 9
"""Of a second, in what is kept: any prices prove something, and these nearly as much."""


class ArcProof:
    """Keeps nothing but the number of cases: most proofs are not asked for their certificate."""

    def __init__(self) -> None:
        self.cases = 1

    def split(self, parent: Case, split: Split, after: Case) -> int:
        """Note the case `after` one on one side of a split; return its number."""
        self.cases += 1
        return self.cases - 1

    def raise_bound(self, case: Case, prices: ArcPrices) -> None:
        """Note the prices at which the bound of a case is what it is."""

    def leave(self, case: Case) -> None:
        """Note that the case is a leaf, at the last prices noted of it or of the nearest case above it."""


class KeptArcProof(ArcProof):
    """Keeps all of it: `nodes`, `steps` and `cuts` of a certificate.

    bound : the least of a leaf, in units of `unit` [s].
    """

    def __init__(self, n_uavs: int, n_tasks: int, unit: float) -> None:
        super().__init__()
        self.unit, self.bound, self.nodes, self.steps = unit, np.inf, [Node()], list[Step]()
        none = np.zeros(n_uavs)
        nothing = StoredPrices(_rounded(none), (_rounded(np.zeros(n_tasks + 1)),) * n_uavs, _rounded(none))
        self._last = {0: nothing}
        self._known: dict[Cut, int] = {}
        self._joint: dict[StoredBlossom | StoredCrowd, int] = {}

    @property
    def cuts(self) -> tuple[Cut, ...]:
        """The cuts that prices name, by their numbers."""
        return tuple(self._known)

    @property
    def joint(self) -> tuple[StoredBlossom | StoredCrowd, ...]:
        """The cuts of all UAVs that prices name, by their numbers."""
        return tuple(self._joint)

    def split(self, parent: Case, split: Split, after: Case) -> int:
        """Note a case."""
        number, more = super().split(parent, split, after), len(after.needed) - len(parent.needed)
        if isinstance(split, Give):
            new = after.forbidden[:, split.task] & ~parent.forbidden[:, split.task]
            self.nodes.append(Node(parent.number, split.task, tuple(np.flatnonzero(new).tolist())))
        else:
            self.nodes.append(Node(parent.number, arcs=split.arcs, flown=more > 0))
        last = self._last[parent.number]
        self._last[number] = replace(last, rho=last.rho + (0.0,) * more)
        return number

    def raise_bound(self, case: Case, prices: ArcPrices) -> None:
        """Note prices."""
        paid = [
            self._known.setdefault(Cut(int(k), int(v), tuple(np.flatnonzero(held).tolist())), len(self._known))
            for k, held, v in zip(*prices.cuts, strict=True)
        ]
        uav, unit = tuple(float(x) for x in prices.sigma + prices.endurance), self.unit
        potential = tuple(_rounded(unit * row) for row in prices.potential)
        joint = tuple(self._joint.setdefault(self._stored(cut), len(self._joint)) for cut in prices.joint)
        use, mu, rho, nu = (_rounded(unit * part) for part in (prices.use, prices.mu, prices.rho, prices.nu))
        self._last[case.number] = StoredPrices(uav, potential, use, tuple(paid), mu, rho, joint, nu)

    def _stored(self, cut: Joint) -> StoredBlossom | StoredCrowd:
        if isinstance(cut, Blossom):
            return StoredBlossom(cut.handle, cut.teeth)
        return StoredCrowd(cut.tasks, _rounded(self.unit * np.array(cut.potential)))

    def leave(self, case: Case) -> None:
        """Note a leaf and its bound."""
        self.bound = min(self.bound, case.bound)
        self.steps.append(Step(case.number, self._last[case.number], closes=True))


def _rounded(values: Floats) -> tuple[float, ...]:
    return tuple(round(float(x), _DIGITS) for x in values)
