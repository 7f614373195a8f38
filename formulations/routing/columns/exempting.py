"""Exempting a UAV: its cost is not counted where one whole tour of it makes the relaxation as long as it is.

A UAV that has to fly far often does. Then σ_k = 1, and at prices of zero for what the others do no cut and no branch on
them raises the relaxation, and none of their legs is fixed away: whether the others can share their tasks in tours of
cost ≤ cap remains to be found by going through the tree. So z need not reach the cost of k any more, whose tours still
cost no more than the cap: the relaxation is then the least longest tour of the others. Any σ ≥ 0 with Σσ ≤ 1 gives a
Lagrangian bound (`pricing.py`), that with σ_k = 0 as well. At first it is lower than what is known, which stays the
node's bound; but cuts and branches raise it, up to the cap where there are no routes. Of the others one may then set
the relaxation alone again, and is exempted in turn, until one is left.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.columns.master import Master
from formulations.routing.columns.pricing import Duals
from instances.arrays import Floats

_WHOLE = 1e-6
"""How far a share may be from a whole number."""


def sole_bottleneck(master: Master, duals: Duals, weight: Floats) -> int | None:
    """Return the UAV that sets the relaxation alone, by one whole tour, where others are counted; else None."""
    k = duals.bottleneck
    if k is None or len(master.exempt) + 1 >= master.m:
        return None
    share = shares(master, weight)[k]
    return k if np.abs(share - share.round()).max() < _WHOLE else None


def shares(master: Master, weight: Floats) -> Floats:
    """Return y_ki, how much of task i UAV k takes, shape (m, n)."""
    share = np.zeros((master.m, master.n))
    for p in np.flatnonzero(weight > 1e-9):
        column = master.columns[p]
        share[column.uav, list(column.tasks)] += weight[p]
    return share
