r"""Cuts on what all UAVs fly together, x = Σ_k θ_k: what crosses a set is even, and a tour holds no more than it can.

    x(δ(H) ∖ T) − x(T) ≥ 1 − t    `Blossom`: tasks H, and T of an odd number t of teeth, edges that cross H, each flown
                                  once at most
    x(δ⁻(S)) ≥ 2                  `Crowd`: tasks S of which the shortest tour is too long for any UAV

Closed tours cross H an even number of times: where all teeth are flown, which is an odd number, something else crosses,
and where not all are, x(T) ≤ t − 1 (Edmonds, "Maximum matching and a polyhedron with 0,1-vertices", 1965). Tasks that
one UAV cannot take are entered by two, or by one twice (Laporte, Nobert & Desrochers, "Optimal routing under capacity
and distance restrictions", Oper. Res. 33, 1985).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from instances.arrays import Bools

Entries = NDArray[np.int8]


@dataclass(frozen=True)
class Blossom:
    """A cut of parity of `n_tasks` tasks, the depot's number that too.

    handle : H; teeth : edges (i, j) that cross H: both arcs where i and j are tasks, else that one arc alone.
    """

    n_tasks: int
    handle: tuple[int, ...]
    teeth: tuple[tuple[int, int], ...]

    @property
    def least(self) -> float:
        """What it is to be at least."""
        return 1.0 - len(self.teeth)

    @cached_property
    def entries(self) -> Entries:
        """Its coefficients of x, (n + 1, n + 1)."""
        inside = _inside(self.n_tasks, self.handle)
        entries = (inside[:, None] ^ inside[None]).astype(np.int8)
        for i, j in self.teeth:
            entries[i, j] = -1
            if self.n_tasks not in (i, j):
                entries[j, i] = -1
        return entries


@dataclass(frozen=True)
class Crowd:
    """A cut of tasks S too many for one tour, of `n_tasks`.

    tasks : S; potential (|S| + 1,) : of the depot and of these tasks, in units of U, at which a 1-tree says that the
        shortest tour is too long (`crowds.py`).
    """

    n_tasks: int
    tasks: tuple[int, ...]
    potential: tuple[float, ...]

    @property
    def least(self) -> float:
        """What it is to be at least."""
        return 2.0

    @cached_property
    def entries(self) -> Entries:
        """Its coefficients of x, (n + 1, n + 1)."""
        inside = _inside(self.n_tasks, self.tasks)
        return (~inside[:, None] & inside[None]).astype(np.int8)


Joint = Blossom | Crowd


def _inside(n_tasks: int, tasks: tuple[int, ...]) -> Bools:
    inside = np.zeros(n_tasks + 1, np.bool_)
    inside[list(tasks)] = True
    return inside
