"""Pricing: the best tours of each group at given duals, by label search over legs or by a scan of a list.

The labels, completion bounds and cuts are those of the min-max problem (`routing/columns`) with σ = 0, a cap of each
group's own and prices v: a tour's cost only has to fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from formulations.routing.columns.completion import Bins, Memory
from formulations.routing.columns.cuts import TaskCuts, Watch
from formulations.routing.columns.label_search import Clock, Found, Orders, Subproblem, path, search
from formulations.routing.columns.labelling import Store, least_of_all
from formulations.routing.columns.pricing import Effort
from formulations.selection.duals import Column, DualBound, Duals
from formulations.selection.fleet import Group
from formulations.selection.worth import Worth
from instances.arrays import Bools, Floats, Ints
from instances.kernels import njit

_MOST_ENDS = 50_000
_WANTED = 60
"""Columns of a group worth adding at once."""


@dataclass(frozen=True)
class Priced:
    """What pricing found: a lower bound on reduced costs, the best columns, whether these are all."""

    least: float
    columns: list[Column]
    complete: bool


class Prices(Protocol):
    """Anything that can price."""

    def price(self, g: int, duals: Duals, threshold: float) -> Priced:
        """Return group g's best columns of reduced cost below `threshold` ≤ 0, and a bound on all of them."""
        ...


class Pricer:
    """Prices the tours over the legs of each group, with one effort, by label search."""

    def __init__(self, groups: Sequence[Group], effort: Effort, store: Store, time_left: Clock) -> None:
        self.groups, self.effort, self.store, self.time_left = groups, effort, store, time_left
        between = np.minimum.reduce([group.legs.between for group in groups])
        self.memory = Memory.nearest(between, effort.near)
        self._bins = [Bins.of(group.legs, group.cap, effort.bins) for group in groups]

    def subproblem(self, g: int, duals: Duals) -> Subproblem:
        """Return the pricing problem of group g, completion bounds included."""
        legs, cap = self.groups[g].legs, self.groups[g].cap
        watch = Watch.of(self.memory.near, duals.cuts, duals.rho, self.effort.watch)
        return Subproblem.bounded(legs, cap, self._bins[g], self.memory, watch, duals.price, 0.0, duals.by_task)

    def price(self, g: int, duals: Duals, threshold: float) -> Priced:
        """Return group g's best columns of reduced cost below `threshold` ≤ 0, and a bound on all of them."""
        problem = self.subproblem(g, duals)
        least = least_of_all(problem)
        if least >= threshold:
            return Priced(least, [], True)
        found = search(problem, self.store, threshold, self.time_left, beam=self.effort.beam, tours=_MOST_ENDS)
        least = max(least, float(found.values.min(initial=min(threshold, found.floor))))
        chosen = np.argsort(found.values, kind="stable")[:_WANTED]
        columns = [Column(g, path(self.store, int(found.ends[t]))) for t in chosen]
        return Priced(least, columns, found.complete)

    def listing(self, at: DualBound, wanted: float, worth: Worth, labels: int, tours: int) -> Pool | None:
        """Return all tours that can be in a selection worth `wanted`; None where they are too many.

        `at` must be a bound of label pricing, which knows no row by tour.
        """
        lists, allowed = [], at.allowed(wanted)
        for g in range(len(self.groups)):
            problem, threshold = self.subproblem(g, at.duals), float(np.nextafter(allowed[g], np.inf))
            found: Found = search(problem, self.store, threshold, self.time_left, labels=labels, tours=tours)
            if not found.complete or self.time_left() <= 0:
                return None
            s, ends = self.store, found.ends
            bits = np.unpackbits(s.visited[ends].view(np.uint8), axis=1, bitorder="little", count=at.duals.price.size)
            orders = Orders(s.last[: found.labels].copy(), s.parent[: found.labels].copy())
            holds = bits.astype(np.bool_)
            told = worth.of_sets(holds) + worth.rounding if worth.subadditive else np.zeros(len(holds))
            lists.append(Listed(holds, ends.copy(), orders, told))
        return Pool(tuple(lists))


@dataclass(frozen=True)
class Listed:
    """The tours of one group: `holds` (p, n), the labels they end in, the orders of labels, and what each is `worth`.

    The worth (p,) is 0 where the row by tour is not used.
    """

    holds: Bools
    label: Ints
    orders: Orders
    worth: Floats

    def only(self, keep: Bools) -> Listed:
        """Return those chosen."""
        return self if keep.all() else Listed(self.holds[keep], self.label[keep], self.orders, self.worth[keep])

    def reduced(self, duals: Duals) -> Floats:
        """Return the reduced costs (p,)."""
        return np.asarray(_reduced(self.holds, duals.price, duals.by_task) - duals.beta * self.worth)


@dataclass(frozen=True)
class Pool:
    """All tours that matter of every group; pricing is a scan of it, always complete."""

    lists: tuple[Listed, ...]

    @property
    def size(self) -> int:
        """Number of tours."""
        return sum(len(part.label) for part in self.lists)

    def price(self, g: int, duals: Duals, threshold: float) -> Priced:
        """Return group g's best columns of reduced cost below `threshold` ≤ 0, and the least of all."""
        part = self.lists[g]
        values = part.reduced(duals)
        best = np.argsort(values, kind="stable")[:_WANTED]
        columns = [Column(g, path(part.orders, int(part.label[p]))) for p in best if values[p] < threshold]
        return Priced(float(values.min(initial=0.0)), columns, True)

    def needed(self, at: DualBound, wanted: float) -> Pool:
        """Drop the tours that cannot be in a selection worth `wanted`."""
        allowed = np.nextafter(at.allowed(wanted), np.inf)
        pairs = zip(self.lists, allowed, strict=True)
        return Pool(tuple(part.only(part.reduced(at.duals) <= most) for part, most in pairs))

    def without(self, task: int, groups: Sequence[int]) -> Pool:
        """Drop the tours in which one of `groups` visits `task`."""
        parts = enumerate(self.lists)
        return Pool(tuple(part.only(~part.holds[:, task]) if g in groups else part for g, part in parts))

    def paired(self, i: int, j: int, together: bool) -> Pool:
        """Drop the tours that hold both of two tasks, or, `together`, just one of them."""
        parts = []
        for part in self.lists:
            one, other = part.holds[:, i], part.holds[:, j]
            parts.append(part.only(one == other if together else ~(one & other)))
        return Pool(tuple(parts))


@njit(cache=True)
def _reduced(holds: Bools, price: Floats, cuts: TaskCuts) -> Floats:
    """Return −Σ v_i + Σ ρ_S over the cuts of which a tour holds two tasks or more, (p,)."""
    partners, rho = cuts.partners, cuts.rho
    values = np.empty(holds.shape[0])
    for p in range(holds.shape[0]):
        row, total = holds[p], 0.0
        for i in range(price.size):
            if not row[i]:
                continue
            total -= price[i]
            for q in range(rho.shape[1]):
                if rho[i, q] <= 0:  # the cuts of a task come first, then room
                    break
                j, k = partners[i, q, 0], partners[i, q, 1]
                # the first two members of a cut that a tour holds pay for it, once
                if (j < i and row[j]) != (k < i and row[k]):
                    total += rho[i, q]
        values[p] = total
    return values
