"""How many UAVs a set of tasks needs: sets that fewer cannot fly within the cap, where x enters them too little.

If q UAVs fly all tasks of S, their tours cost at least a bound L_q(S). Where that is above q·U, the set needs more than
q UAVs, and Σ_{i,j∈S} x_ij ≤ |S| − q − 1 (Laporte, Nobert & Desrochers, "Optimal routing under capacity and distance
restrictions", Oper. Res. 33, 1985). Tours may hold other tasks too: they are no shorter for it where legs cost what
the cheapest way over tasks does.

L_q(S) is the Lagrangian of a programme over arcs (``arc_programme.py``), restricted to S. At its duals

    L_q(S) = Σ_{i∈S} (π_i + π'_i) + Σ_C π_C a_C + q·(the least dual of a UAV) + Σ_ij min(0, reduced cost),

where a_C, the arcs that tours over S have within a cut C, are at most |C| − r(C) where C ⊆ S, else |S ∩ C| − 1 or none.
Times (``timed_arcs.py``) add nothing but to reduced costs. Where that is not quite enough, the bound of S alone is
computed. Candidates are grown from each task by the task that x ties most to the set.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from formulations.routing.arc_programme import ArcProgramme
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit

_LEAST = 0.02
"""How far below q + 1 the entries of a set must be."""
_NEAR = 0.9
"""Share of q·U above which the total bound of a set alone is worth a try."""
_TRIALS = 8
"""Of these in a round."""
_AT_ONCE = 30
"""Sets added in a round."""
_PASSES = 4
"""Of growing: all but the first with ties weighed at random, by a half at most."""


class Candidates(NamedTuple):
    """Sets (c, n), how often x enters them (c,), how many UAVs that is, whole (c,), L_q(S) ÷ q·U (c,)."""

    sets: Bools
    entered: Floats
    uavs: Ints
    load: Floats


class Priced(NamedTuple):
    """The duals of a programme: `price` (n,) of tasks, `charge` (c,) of `cuts` (c, n) of `size` tasks and their `need`.

    of_uav [s] : what each UAV adds, ≤ 0; fixed [s] : what any tours cost besides, ≤ 0; fleet : the UAVs there are.
    """

    price: Floats
    charge: Floats
    cuts: Bools
    size: Ints
    need: Ints
    of_uav: float
    fixed: float
    fleet: int

    @classmethod
    def at(cls, of: ArcProgramme) -> Priced:
        """Return the last duals of a programme, without the cuts that nothing pays for."""
        paid = of.charge < 0
        cuts = of.cuts[: paid.size][paid]
        size, need, fixed = cuts.sum(axis=1), of.need[: paid.size][paid], of.below - of.margin
        return cls(of.entering + of.leaving, of.charge[paid], cuts, size, need, of.of_uav, fixed, of.fleet)


class Needs:
    """Finds sets that need more UAVs than enter them.

    programmes : solved, over costs that get no less by flying on past tasks; their duals bound tours over few tasks.
    alone : returns the programme of some tasks (n,) and q UAVs; cap [s] : of the tours, times their greatest weight.
    """

    def __init__(
        self, programmes: Sequence[ArcProgramme], alone: Callable[[Bools, int], ArcProgramme], cap: float
    ) -> None:
        self.programmes, self.alone, self.cap = programmes, alone, cap
        self._proved: dict[tuple[bytes, int], bool] = {}
        self._random = np.random.default_rng(0)

    def find(self, flow: Floats, end: float) -> tuple[Bools, Ints]:
        """Return sets (c, n), each entered less often than it needs UAVs, and these needs (c,); none after `end`."""
        n = len(flow) - 1
        for attempt in range(_PASSES):
            weight = np.ones((n, n)) if attempt == 0 else self._random.uniform(0.5, 1.0, (n, n))
            found = self._grown(flow, weight)
            certain = self._certain(found, end)
            if certain.size:
                chosen = certain[np.argsort((found.entered - found.uavs)[certain], kind="stable")[:_AT_ONCE]]
                return found.sets[chosen], found.uavs[chosen] + 1
        return np.zeros((0, n), np.bool_), np.zeros(0, np.int64)

    def _grown(self, flow: Floats, weight: Floats) -> Candidates:
        """Return the candidates, each once, with the highest load any programme shows."""
        grown = [_grow(flow, weight, Priced.at(of), self.cap, _NEAR, _LEAST) for of in self.programmes]
        sets, entered, uavs, load = (np.concatenate(parts) for parts in zip(*grown, strict=True))
        order = np.argsort(-load, kind="stable")
        _, first = np.unique(np.column_stack([sets, uavs])[order], axis=0, return_index=True)
        chosen = order[first]
        return Candidates(sets[chosen], entered[chosen], uavs[chosen], load[chosen])

    def _certain(self, found: Candidates, end: float) -> Ints:
        """Return the candidates that need more UAVs than enter them, for certain."""
        known = [self._proved.get((s.tobytes(), q)) for s, q in zip(found.sets, found.uavs.tolist(), strict=True)]
        certain = [c for c, proved in enumerate(known) if proved or found.load[c] > 1]
        unknown = [c for c in np.argsort(-found.load, kind="stable").tolist() if known[c] is None and c not in certain]
        for c in unknown[:_TRIALS] if len(certain) < _AT_ONCE else ():
            if time.perf_counter() > end:
                break
            q = int(found.uavs[c])
            alone = self.alone(found.sets[c], q)
            alone.solve_all(end, enough=q * self.cap)
            proved = self._proved[found.sets[c].tobytes(), q] = alone.sum > q * self.cap
            certain += [c] if proved else []
        return np.array(certain, dtype=np.int64)


@njit(cache=True)
def _grow(
    flow: Floats, weight: Floats, at_duals: Priced, cap: float, near: float, least: float
) -> tuple[Bools, Floats, Ints, Floats]:
    """Return sets, entries, whole UAVs, loads: per first task and q the set most wanting and that of the highest load.

    flow (n + 1, n + 1) : x, all depots last; weight (n, n) : of ties.
    """
    price, charge, cuts, size, need, of_uav, fixed, fleet = at_duals
    n, most = price.size, 2 * fleet
    sets, entered = np.zeros((n * most, n), np.bool_), np.zeros(n * most)
    uavs, load = np.zeros(n * most, np.int64), np.zeros(n * most)
    for first in range(n):
        base = first * most
        inside, ties, weighed = np.zeros(n, np.bool_), np.zeros(n), np.zeros(n)
        members, value, entries, v = np.zeros(charge.size, np.int64), 0.0, 0.0, first
        for _ in range(n):
            entries += 1.0 - ties[v]
            inside[v] = True
            value += price[v]
            for c in range(charge.size):
                if cuts[c, v]:
                    if members[c] > 0:
                        value += charge[c]
                    members[c] += 1
                    if members[c] == size[c]:
                        value -= charge[c] * (need[c] - 1)
            q = int(np.floor(entries + 1e-3))
            if 1 <= q < fleet and entries < q + 1 - least:
                share = (value + q * of_uav + fixed) / (q * cap)
                at = base + 2 * (q - 1) + (0 if share > 1 else 1)
                better = entries < entered[at] if share > 1 else share > load[at]
                if share > near and (uavs[at] == 0 or better):
                    sets[at], entered[at], uavs[at], load[at] = inside, entries, q, share
            for j in range(n):
                tie = flow[v, j] + flow[j, v]
                ties[j] += tie
                weighed[j] += tie * weight[v, j]
            v, strongest = -1, 1e-9
            for j in range(n):
                if not inside[j] and weighed[j] > strongest:
                    v, strongest = j, weighed[j]
            if v < 0:
                break
    kept = uavs > 0
    return sets[kept], entered[kept], uavs[kept], load[kept]
