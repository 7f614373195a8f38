"""Strong branching: which UAV and task to branch on.

A branch either gives task i to UAV k or forbids it to it. Candidates are the y_ki = Σ_p a_ip λ_p near ½, far tasks
first: as long as several UAVs share a task far out, none of them pays the way, and once one is given it, that one does.
Just as many are the dearest tasks first: those that make the relaxation what it is, however little of them is shared.
The columns known say how far the master rises on either side, and the largest product of the two wins (Achterberg,
Koch, Martin, "Branching rules revisited", Oper. Res. Lett. 33, 2005). Very few pivots say it roughly for many
candidates, more of them for the best of these and of either kind: one candidate may do more than all others together.
"""

from __future__ import annotations

import numpy as np

from formulations.routing.columns.cuts import incidence
from formulations.routing.columns.exempting import shares, sole_bottleneck
from formulations.routing.columns.label_search import Clock
from formulations.routing.columns.master import Master
from instances.arrays import Bools, Floats, Ints

_GLANCED, _TRIED = 25, 4
"""Candidates of either kind tried roughly and thoroughly; of those tried roughly, as many go on."""
_GLANCE, _TRIAL = 5, 200
"""Pivots of a rough and of a thorough trial."""
_LEAST = 1e-6
"""Share of the master's value below which a rise counts as this much: neither side may count as nothing."""


def choose(master: Master, allowed: Bools, far: Floats, gap: float, time_left: Clock) -> tuple[int, int] | None:
    """Return UAV and task to branch on, None where all are decided.

    allowed (m, n) : who may still take what; far (n,) [s] : the cheapest way to each task and back;
    gap [s] : the rise that closes a branch, so that more counts for nothing.
    """
    undecided = allowed & (allowed.sum(axis=0) > 1)
    if not undecided.any():
        return None
    optimum = master.solve(time_left)
    if optimum is None:  # whatever is next is not looked at any more
        return divmod(int(np.argmax(undecided)), master.n)
    value, duals, weight = optimum
    share = shares(master, weight)
    split = np.where(undecided, np.minimum(share, 1 - share).round(6), 0.0)
    kinds = [_promising(split * far**2), _promising(split * np.maximum(duals.price, 0.0))]
    if kinds[0].size + kinds[1].size == 0:
        return _dearest(undecided, share, duals.price)
    if sole_bottleneck(master, duals, weight) is not None and kinds[0].size > 0:
        # no branch on the others raises the relaxation
        return divmod(int(kinds[0][0]), master.n)
    trials = _Trials(master, value, gap, time_left)
    roughly = trials.best(_each_once(*kinds), _GLANCE, _TRIED)
    thoroughly = _each_once(*(kind[:_TRIED] for kind in kinds), roughly)
    return divmod(int(trials.best(thoroughly, _TRIAL, 1)[0]), master.n)


def _each_once(*candidates: Ints) -> Ints:
    """Return all candidates, the first kind first: of those no better than others the earliest wins."""
    return np.array(list(dict.fromkeys(np.concatenate(candidates).tolist())), np.int64)


class _Trials:
    """How far the master, solved at `value` [s], rises on either side of candidates; what exceeds `gap` is no more."""

    def __init__(self, master: Master, value: float, gap: float, time_left: Clock) -> None:
        self.master, self.value, self.gap, self.time_left = master, value, gap, time_left
        self.uav = np.array([column.uav for column in master.columns])
        self.holds = np.ascontiguousarray(incidence([column.tasks for column in master.columns], master.n).T)

    def best(self, candidates: Ints, pivots: int, most: int) -> Ints:
        """Return the `most` best candidates, best first; those not tried when time is up count for nothing."""
        scores = np.zeros(candidates.size)
        if candidates.size > most:
            for c, candidate in enumerate(candidates):
                if self.time_left() <= 0:
                    break
                scores[c] = self._score(*divmod(int(candidate), self.master.n), pivots)
        return candidates[np.argsort(-scores, kind="stable")[:most]]

    def _score(self, k: int, i: int, pivots: int) -> float:
        """Return the product of the rises [s²] where task i is given to UAV k, and where it is forbidden to it."""
        least, score = _LEAST * self.value, 1.0
        for dropped in (self.holds[i] & (self.uav != k), self.holds[i] & (self.uav == k)):
            rise = self.master.without(dropped, pivots) - self.value
            score *= min(self.gap, max(rise, least))
        return score


def _dearest(undecided: Bools, share: Floats, price: Floats) -> tuple[int, int]:
    """Return the dearest undecided task and, of the UAVs that may take it, the one that takes most of it.

    Where nothing is shared the columns known do not make routes: tasks are left out, which makes them dear.
    """
    i = int(np.argmax(np.where(undecided.any(axis=0), price, -np.inf)))
    return int(np.argmax(np.where(undecided[:, i], share[:, i], -1.0))), i


def _promising(promise: Floats) -> Ints:
    """Return the few places, in the flat array, of greatest promise > 0."""
    best = np.argsort(-promise.ravel(), kind="stable")[:_GLANCED]
    return best[promise.ravel()[best] > 0.0]
