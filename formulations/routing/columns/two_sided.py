"""Tours from both sides: labels from the depot and, flown backwards, from home, up to half the cap, and their pairs.

Labels grow with every task, and most of them are near the end of tours. Those of either side end half-way; the tours
that neither side meets by itself have exactly one leg that begins by then and ends after it (Righini & Salani,
"Symmetry helps: bounded bi-directional dynamic programming for the elementary shortest path problem with resource
constraints", Discrete Optim. 3, 2006). `joining` finds the pairs.
Where one side alone has few labels it is quicker: it is tried first.

For costs that do not change with time: else it is not known when a way home begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.completion import Bins
from formulations.routing.columns.joining import PARTS, Pairs, WaysHome, halves, join
from formulations.routing.columns.label_search import (
    Clock,
    Found,
    Labels,
    Layers,
    Subproblem,
    cheapest_of_each_set,
    layers,
    pair,
    search,
)
from formulations.routing.columns.labelling import Store
from formulations.routing.columns.word_sets import clear

_BEYOND = 1 + 1e-12
"""More than rounding takes from what is left behind half-way."""
_FEW, _ALONE = 60_000, 4
"""Labels of one side alone that are tried first, and, to list tours, as which part of the labels."""
_FEWER, _PAIRS = 5, 2
"""Part of the labels that each side has to list tours, and pairs for each of these labels and tours."""
_AT_LEAST, _AHEAD = 100_000, 10
"""Pairs that are never too many, and parts of the labels by which pairs may run ahead of their limit."""
_MANY = 10**15


class Attempt(NamedTuple):
    """To list the tours of reduced cost below `threshold` [s]: how many `labels` and `tours` there may be."""

    threshold: float
    labels: int
    tours: int


class Sides(NamedTuple):
    """How a problem is searched: by `label_search.search`, or, where that has many labels, from both sides.

    backwards : bins of the tours flown backwards; None: one side alone is searched.
    """

    problem: Subproblem
    backwards: Bins | None

    def search(self, store: Labels, threshold: float, time_left: Clock, *, beam: int, tours: int) -> Found:
        """Find tours as `label_search.search` does."""
        if self.backwards is None or not isinstance(store, Store):
            return search(self.problem, store, threshold, time_left, beam=beam, tours=tours)
        found = search(self.problem, store, threshold, time_left, beam=beam, labels=_FEW, tours=tours)
        if found.complete:
            return found
        return _Halves.of(self.problem, self.backwards, store, threshold, time_left, beam=beam).found(threshold, tours)

    def all_tours(self, store: Labels, attempts: Sequence[Attempt], time_left: Clock) -> list[Found]:
        """Find all tours below some threshold: return what each attempt found, up to the first that found all.

        Thresholds only fall. Where the labels of the first are too many the next is the last.
        """
        first, *others = attempts
        if self.backwards is None or not isinstance(store, Store):
            tried: list[Found] = []
            for threshold, labels, tours in [first, *others[-1:]]:
                tried.append(search(self.problem, store, threshold, time_left, labels=labels, tours=tours))
                if tried[-1].complete:
                    break
            return tried
        few = first.labels // _ALONE
        alone = search(self.problem, store, first.threshold, time_left, labels=few, tours=first.tours)
        if alone.complete:
            return [alone]
        both = _Halves.listing(self.problem, self.backwards, store, first, time_left)
        tried = [both.listed(first)]
        for attempt in others if both.complete else others[-1:]:
            if tried[-1].complete:
                break
            if not both.complete:
                both = _Halves.listing(self.problem, self.backwards, store, attempt, time_left)
            tried.append(both.listed(attempt))
        return tried


@dataclass(frozen=True)
class _Halves:
    """The labels of both sides: `one` of ways from the depot, `other` of ways home; put in order when first paired."""

    problem: Subproblem
    store: Store
    one: Layers
    other: Layers
    time_left: Clock

    @classmethod
    def of(
        cls,
        whole: Subproblem,
        backwards: Bins,
        store: Store,
        threshold: float,
        time_left: Clock,
        *,
        beam: int | None = None,
        labels: int | None = None,
        tours: int = _MANY,
    ) -> _Halves:
        """Make the labels of tours below a threshold, on either side as many as said."""
        middle = whole.cap / 2
        ahead, behind = whole._replace(reach=middle), whole.behind(backwards, (whole.cap - middle) * _BEYOND)
        one = layers(ahead, store, threshold, time_left, beam=beam, labels=labels, tours=tours)
        if one.floor == -np.inf:  # then pairs would say nothing
            return cls(ahead, store, one, Layers.lost(one.end), time_left)
        other = layers(behind, store, threshold, time_left, begin=one.end, beam=beam, labels=labels, tours=tours)
        return cls(ahead, store, one, other, time_left)

    @classmethod
    def listing(cls, whole: Subproblem, backwards: Bins, store: Store, attempt: Attempt, time_left: Clock) -> _Halves:
        """Make the labels of an attempt to list all tours."""
        threshold, labels, tours = attempt
        return cls.of(whole, backwards, store, threshold, time_left, labels=labels // _FEWER, tours=tours)

    @cached_property
    def home(self) -> WaysHome:
        """The ways home in order."""
        return WaysHome.of(self.problem, self.store, self.one.end, self.other.end)

    @cached_property
    def half(self) -> NDArray[np.uint64]:
        """The numbers of the cuts of which each way from the depot holds one task, (l, words)."""
        return halves(self.store.visited[: self.one.end], self.problem.cuts.bits)

    @property
    def complete(self) -> bool:
        """Whether no label was lost."""
        return self.one.complete and self.other.complete

    def listed(self, attempt: Attempt) -> Found:
        """Return the tours of an attempt to list all, whose threshold is not above that of the labels."""
        return self.found(attempt.threshold, attempt.tours, _PAIRS * min(attempt.labels, attempt.tours))

    def found(self, threshold: float, most: int, most_pairs: int = _MANY) -> Found:
        """Return the tours below a threshold, which is not above that of the labels."""
        one, other, store = self.one, self.other, self.store
        floor, whole, tried, pairs = min(one.floor, other.floor), True, 0, Pairs.room_for(0, store.visited.shape[1])
        if floor > -np.inf:
            whole, pairs, tried = self._join(threshold, most, most_pairs)
        none = np.full(1, -1)
        ends = [pair(one.ends, none), pair(none, other.ends), pair(pairs.ahead, pairs.behind)]
        values, costs = [one.values, other.values, pairs.value], [one.costs, other.costs, pairs.cost]
        sets = [store.sets(one.ends), store.sets(other.ends), pairs.visited]
        end, value, cost, visited = (np.concatenate(parts) for parts in (ends, values, costs, sets))
        chosen = cheapest_of_each_set(cost, visited)
        chosen = chosen[value[chosen] < threshold]
        kept = end[chosen], value[chosen], cost[chosen], visited[chosen]
        return Found(*kept, other.end, self.complete and whole, floor if whole else -np.inf, tried)

    def _join(self, threshold: float, most: int, most_pairs: int) -> tuple[bool, Pairs, int]:
        """Return whether there was room for all pairs, these, and how many there are, the same tours counted again.

        It ends where part of the labels say that there are more than `most_pairs`.
        """
        pairs, found, tried = Pairs.room_for(most, self.store.visited.shape[1]), 0, 0
        given, middle = (self.problem, self.store, self.half, self.home, threshold), self.one.end
        for part in range(PARTS):
            left = max(most_pairs, _AT_LEAST) * min(PARTS, part + _AHEAD) // PARTS - tried
            whole, found, now = join(*given, part, middle, pairs, found, left)
            tried += now
            if self.time_left() <= 0:
                whole = False
            if not whole:
                break
        pairs = pairs.only(found)
        clear(pairs.visited, np.zeros(found, np.int16), self.store.slots, 0, found)
        return whole, pairs, tried
