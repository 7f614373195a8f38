"""`subset-dp`: the best set of all sets that fit, by Held–Karp. Exact for any worth, n ≤ 18; the oracle of the others.

    t_k(S)                                     cheapest tour of UAV k over S, +∞ beyond L_k (routing/subset_dp.py)
    F_0(S) = [S = ∅],   F_k(S) = ∨_{R ⊆ S} F_{k−1}(S∖R) ∧ [t_k(R) < ∞]      UAVs 1..k can fly S
    max {f(S): F_m(S)}

Each F_k takes 3ⁿ steps at worst, few where an R is found early; F_m is only asked for sets in falling order of worth,
up to the first that fits. Nothing is assumed of f, nor that a part of what fits fits: costs need no triangle
inequality.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.limits import Limits
from formulations.routing.subset_dp import cheapest_order, tour_table
from formulations.selection.fleet import groups_of
from formulations.selection.selection import Record, SelectionMethod, SelectionProblem
from formulations.selection.worth import Worth
from instances import Instance, Routes
from instances.arrays import Bools, Ints
from instances.kernels import njit

LARGEST = 18
"""Tasks beyond which the 3ⁿ steps take more than seconds."""
_CHUNK = 1 << 11


@dataclass(frozen=True)
class SubsetDp(SelectionMethod):
    """Dynamic programming over all subsets: exact, n ≤ 18, any worth."""

    def accepts(self, problem: SelectionProblem) -> str | None:
        """Refuse instances whose tables take too long."""
        n = problem.instance.n_tasks
        return None if n <= LARGEST else f"all 2^n sets are looked at: at most {LARGEST} tasks, not {n}"

    def prepare(self, problem: SelectionProblem) -> None:
        """Compile the kernels: once on two tasks and three UAVs."""
        tiny = Instance("warm-up", np.ones((5, 5)) - np.eye(5), 2, 3)
        small = SelectionProblem(tiny, Worth.of_prizes([1.0, 1.0]))
        self.search(small, Record(small, Limits()), 0)

    def search(self, problem: SelectionProblem, record: Record, seed: int) -> str:
        """Find the best set; deterministic, so `seed` is not used."""
        own = _fitting(problem, record)
        together = None if own is None else _prefixes(own, record)
        if own is None or together is None:
            return "time"
        worth = problem.worth.of_all_sets()
        order = np.argsort(-worth, kind="stable")
        last = own[-1]
        for low in range(0, order.size, _CHUNK):
            if record.remaining <= 0:
                record.lower(float(worth[order[low]]) + 2 * problem.worth.rounding)
                return "time"
            best = _first_that_fits(order[low : low + _CHUNK], together[-1], last)
            if best >= 0:
                record.offer(_routes(problem.instance, own, together, best))
                record.lower(float(worth[best]) + 2 * problem.worth.rounding)
                break
        return "finished"


def _fitting(problem: SelectionProblem, record: Record) -> list[Bools] | None:
    """Return which sets each UAV can fly, m × (2ⁿ,); None when the clock runs out."""
    own: dict[int, Bools] = {}
    for group in groups_of(problem.instance):
        tour = tour_table(problem.instance, group.uavs[0])
        if tour is None or record.remaining <= 0:
            return None
        own |= dict.fromkeys(group.uavs, np.isfinite(tour))
    return [own[k] for k in range(len(own))]


def _prefixes(own: list[Bools], record: Record) -> list[Bools] | None:
    """Return F_0..F_{m−1}, which sets the first UAVs can fly together; F_0 only the empty one. None as above."""
    nothing = np.zeros(own[0].size, np.bool_)
    nothing[0] = True
    together = [nothing, own[0]]
    for k in range(1, len(own) - 1):
        joined = together[-1] | own[k]
        for low in range(0, joined.size, _CHUNK):
            if record.remaining <= 0:
                return None
            _join(low, min(low + _CHUNK, joined.size), together[-1], own[k], joined)
        together.append(joined)
    return together[: len(own)]


@njit(cache=True)
def _part(whole: int, first: Bools, second: Bools) -> int:
    """Return an R ⊆ whole with first(whole∖R) and second(R); −1 where there is none."""
    part = whole
    while True:
        if second[part] and first[whole ^ part]:
            return part
        if part == 0:
            return -1
        part = (part - 1) & whole


@njit(cache=True)
def _join(low: int, high: int, first: Bools, second: Bools, out: Bools) -> None:
    for whole in range(low, high):
        out[whole] = out[whole] or _part(whole, first, second) >= 0


@njit(cache=True)
def _first_that_fits(order: Ints, first: Bools, second: Bools) -> int:
    for whole in order:
        if _part(whole, first, second) >= 0:
            return int(whole)
    return -1


def _routes(instance: Instance, own: list[Bools], together: list[Bools], chosen: int) -> Routes:
    """Return routes over the set `chosen`: the part of each UAV, the last first, and its cheapest order."""
    rest, routes = chosen, []
    for k in reversed(range(len(own))):
        part = int(_part(rest, together[k], own[k]))
        routes.append(cheapest_order(instance, k, [i for i in instance.tasks if part >> i & 1]))
        rest ^= part
    return tuple(reversed(routes))
