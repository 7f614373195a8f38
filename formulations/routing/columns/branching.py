"""Strong branching: which UAV and task to branch on.

A branch either gives task i to UAV k or forbids it to it. Candidates are the y_ki = Σ_p a_ip λ_p near ½, far tasks
first: as long as several UAVs share a task far out, none of them pays the way, and once one is given it, that one does.
Just as many are the dearest tasks first: those that make the relaxation what it is, however little of them is shared.
The columns known say how far the master rises on either side, and the largest product of the two wins (Achterberg,
Koch, Martin, "Branching rules revisited", Oper. Res. Lett. 33, 2005).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.master import Master

_CANDIDATES = 8
"""Of either kind."""
_LEAST = 1e-6
"""Share of the master's value below which a rise counts as this much: neither side may count as nothing."""


def shares(master: Master, weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return y_ki, how much of task i UAV k takes, shape (m, n)."""
    share = np.zeros((master.m, master.n))
    for p in np.flatnonzero(weight > 1e-9):
        column = master.columns[p]
        share[column.uav, list(column.tasks)] += weight[p]
    return share


def choose(
    master: Master,
    allowed: NDArray[np.bool_],
    far: NDArray[np.float64],
    gap: float,
    out_of_time: Callable[[], bool],
) -> tuple[int, int] | None:
    """Return UAV and task to branch on, None where all are decided.

    allowed (m, n) : who may still take what; far (n,) [s] : the cheapest way to each task and back;
    gap [s] : the rise that closes a branch, so that more counts for nothing.
    """
    undecided = allowed & (allowed.sum(axis=0) > 1)
    if not undecided.any():
        return None
    value, duals, weight = master.solve()
    share = shares(master, weight)
    split = np.where(undecided, np.minimum(share, 1 - share).round(6), 0.0)
    candidates = np.union1d(_promising(split * far**2), _promising(split * np.maximum(duals.price, 0.0)))
    if candidates.size == 0:
        return _dearest(undecided, share, duals.price)
    if candidates.size == 1:
        return _pair(int(candidates[0]), master.n)
    uav = np.array([c.uav for c in master.columns])
    best, best_score = int(candidates[0]), -np.inf
    for candidate in candidates:
        if out_of_time():
            break
        k, i = _pair(int(candidate), master.n)
        holds = np.array([i in c.tasks for c in master.columns])
        given, forbidden = (
            min(gap, max(master.without(drop) - value, _LEAST * value))
            for drop in (holds & (uav != k), holds & (uav == k))
        )
        if given * forbidden > best_score * (1 + 1e-9):
            best, best_score = int(candidate), given * forbidden
    return _pair(best, master.n)


def _dearest(undecided: NDArray[np.bool_], share: NDArray[np.float64], price: NDArray[np.float64]) -> tuple[int, int]:
    """Return the dearest undecided task and, of the UAVs that may take it, the one that takes most of it.

    Where nothing is shared the columns known do not make routes: tasks are left out, which makes them dear.
    """
    i = int(np.argmax(np.where(undecided.any(axis=0), price, -np.inf)))
    return int(np.argmax(np.where(undecided[:, i], share[:, i], -1.0))), i


def _promising(promise: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the few places, in the flat array, of greatest promise > 0."""
    best = np.argsort(-promise.ravel(), kind="stable")[:_CANDIDATES]
    return best[promise.ravel()[best] > 0.0]


def _pair(flat: int, n: int) -> tuple[int, int]:
    return flat // n, flat % n
