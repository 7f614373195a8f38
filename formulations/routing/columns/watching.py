"""Subset-row cuts in the completion bounds: each task watches a few of them.

Labels pay for cuts exactly (see `cuts`), but completion bounds that know nothing of cuts fall far behind once prices
have risen against them. So B gets more state: beside the tasks remembered, a bit for each of the q cuts watched at a
task, set where the path holds one of the three tasks, and has not paid yet. Arriving at a member pays ρ_S and clears a
set bit, and sets a clear one; at a task that does not watch S the bit is forgotten. That is the limited memory of
Pecin, Pessoa, Poggi, Uchoa ("Improved branch-cut-and-price for capacitated vehicle routing", Math. Program. Comput. 9,
2017), and forgetting only ever lowers what is paid: B stays a lower bound.

For a label the bit of S is set exactly where one task of S is visited, so all that B can still charge is due.
A clear bit is never charged more than a set one, hence state 0 remains the least restricted of all.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.cuts import Cut
from instances.arrays import Floats, Ints
from instances.kernels import njit

_PASSING = 0.25
"""Weight of a cut, for each of its tasks that is near, at a task that is none of them."""


class Watch(NamedTuple):
    """Which cuts are watched where.

    members : the tasks of the r-th cut watched at task i, shape (n, q, 3), −1 where there is none.
    turn : turn[i, j, c], the bits at j after i was left with bits c, shape (n, n, 2^q).
    charge : what arriving at j then costs [s], shape (n, n, 2^q).
    """

    members: Ints
    turn: NDArray[np.int16]
    charge: Floats

    @classmethod
    def of(cls, near: Ints, cuts: Sequence[Cut], rho: Floats, most: int) -> Watch:
        """Watch at each task up to `most` cuts: dear ones that hold it, or some of the tasks `near` it, (n, g)."""
        n = near.shape[0]
        priced = np.flatnonzero(rho > 0)
        q = min(most, priced.size)
        if q == 0:
            return cls(np.zeros((n, 0, 3), np.int64), np.zeros((n, n, 1), np.int16), np.zeros((n, n, 1)))
        sets = np.array(cuts, np.int64)[priced]
        holds = np.zeros((n, n), np.bool_)
        np.put_along_axis(holds, near, True, axis=1)
        worth = _PASSING * holds[:, sets].sum(axis=2)
        worth[sets, np.arange(priced.size)[:, None]] = 1.0
        worth = worth * rho[priced]
        chosen = np.argsort(-worth, axis=1, kind="stable")[:, :q]
        watched = np.where(np.take_along_axis(worth, chosen, axis=1) > 0, chosen, -1)
        members = np.where(watched[:, :, None] >= 0, sets[watched], -1)
        return cls(members, *_turns(watched, sets, rho[priced]))


@njit(cache=True)
def _turns(watched: Ints, sets: Ints, rho: Floats) -> tuple[NDArray[np.int16], Floats]:
    """Return `turn` and `charge` of a Watch from the cuts `watched` at each task, (n, q), their tasks and prices."""
    n, q = watched.shape
    turn, charge = np.zeros((n, n, 1 << q), np.int16), np.zeros((n, n, 1 << q))
    for i in range(n):
        for j in range(n):
            for bits in range(1 << q):
                for r in range(q):
                    s = watched[i, r]
                    if bits >> r & 1 and s >= 0 and _holds(sets, s, j):
                        charge[i, j, bits] += rho[s]
                for r in range(q):
                    s = watched[j, r]
                    if s < 0:
                        continue
                    before = False
                    for t in range(q):
                        before = before or (watched[i, t] == s and bits >> t & 1 != 0)
                    if before != _holds(sets, s, j):
                        turn[i, j, bits] |= 1 << r
    return turn, charge


@njit(cache=True)
def _holds(sets: Ints, s: int, task: int) -> bool:
    return sets[s, 0] == task or sets[s, 1] == task or sets[s, 2] == task
