"""A case of the tree over arcs: what it forbids and asks for, and the two cases that it is split into.

A task is given to a UAV or forbidden to it and to all that are like it (`columns/tree.py` says why that misses no
routes but for their names); one of a few arcs between tasks is flown by some UAV, or none of them is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from instances.arrays import Bools, Ints

Arcs = tuple[tuple[int, int], ...]
"""Arcs between tasks of which routes fly one at most: one alone, or the two between the same tasks."""


@dataclass(frozen=True)
class Case:
    """forbidden (m, n) : which UAV may not take which task; kinds (m,) : UAVs of one number are alike.

    banned : arcs that nobody flies; needed : arcs of which somebody flies one; bound : a lower bound known of it;
    number : its place in the proof that is kept.
    """

    forbidden: Bools
    kinds: Ints
    banned: Arcs = ()
    needed: tuple[Arcs, ...] = ()
    bound: float = 0.0
    number: int = 0

    @classmethod
    def root(cls, kinds: Ints, n_tasks: int) -> Case:
        """Return the case of all routes."""
        return cls(np.zeros((kinds.size, n_tasks), np.bool_), kinds)

    @property
    def all_alike(self) -> bool:
        """Whether nothing tells any UAV apart, and there are several."""
        return self.kinds.size > 1 and bool((self.kinds == self.kinds[0]).all())

    @property
    def lost(self) -> bool:
        """Whether some task is forbidden to all UAVs."""
        return bool(self.forbidden.all(axis=0).any())

    def lost_arcs(self) -> Bools:
        """Return the arcs that the case rules out, (m, n + 1, n + 1), the depot last."""
        m, n = self.forbidden.shape
        off = np.zeros((m, n + 1), np.bool_)
        off[:, :n] = self.forbidden
        arcs = off[:, :, None] | off[:, None, :]
        for i, j in self.banned:
            arcs[:, i, j] = True
        return arcs


@dataclass(frozen=True)
class Give:
    """Split by task: given to UAV k, or forbidden to UAV k and to those like it."""

    uav: int
    task: int

    def without(self, case: Case) -> Case:
        """Return the case in which those UAVs may not take it."""
        forbidden = case.forbidden.copy()
        forbidden[case.kinds == case.kinds[self.uav], self.task] = True
        return replace(case, forbidden=forbidden)

    def within(self, case: Case) -> Case:
        """Return the case in which UAV k takes it, and is like no other from then on."""
        forbidden, kinds = case.forbidden.copy(), case.kinds.copy()
        forbidden[np.arange(kinds.size) != self.uav, self.task] = True
        kinds[self.uav] = kinds.max() + 1
        return replace(case, forbidden=forbidden, kinds=kinds)


@dataclass(frozen=True)
class Fly:
    """Split by arcs: one of them is flown, or none."""

    arcs: Arcs

    def without(self, case: Case) -> Case:
        """Return the case in which nobody flies any."""
        return replace(case, banned=(*case.banned, *self.arcs))

    def within(self, case: Case) -> Case:
        """Return the case in which somebody flies one."""
        return replace(case, needed=(*case.needed, self.arcs))


Split = Give | Fly
