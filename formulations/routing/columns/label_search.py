"""The search for tours: from layer to layer of labels, whatever a label is, and what is found.

Layer ℓ holds paths of ℓ tasks. With a finite `beam` only the most promising labels of a layer are kept: then the tours
found are real, and those that are not have at least the least bound of a label left aside, the `floor`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.completion import Bins, Memory, completion
from formulations.routing.columns.cuts import TaskCuts, Watch
from formulations.routing.columns.legs import UavLegs
from formulations.routing.columns.word_sets import hashed, same
from instances.arrays import Floats, Ints
from instances.kernels import njit

Clock = Callable[[], float]
"""Says how many seconds are left: at 0 and below, time is up."""


def no_limit() -> float:
    """Set no limit of time."""
    return np.inf


_CHUNK = 50_000
_EARLY = 50  # part of the room: of fewer labels nothing is projected
_LESS = 2.0  # how much less than there will be is projected, for tours of ten tasks and more
_LESS_HALF_WAY = 0.5  # the same where labels end half-way


class Subproblem(NamedTuple):
    """The pricing problem of one UAV: tours of cost ≤ `cap` [s] over its legs, least in reduced cost.

    price : π_i [s] of the tasks, shape (n,); sigma : σ_k of the UAV; cuts : what each task's cuts charge.
    bins, memory, watch, best : the completion bounds B and the states they are for; least (n, most + 1) : those of the
        least restricted one, close together because labels ask for them most.
    reach [s] : no label is made that costs more.
    """

    legs: UavLegs
    cap: float
    bins: Bins
    memory: Memory
    watch: Watch
    price: Floats
    sigma: float
    cuts: TaskCuts
    best: Floats
    least: Floats
    reach: float

    @classmethod
    def bounded(
        cls,
        legs: UavLegs,
        cap: float,
        bins: Bins,
        memory: Memory,
        watch: Watch,
        price: Floats,
        sigma: float,
        cuts: TaskCuts,
    ) -> Subproblem:
        """Return the problem with its completion bounds, labels up to the cap."""
        best = completion(bins, memory, watch, price, sigma)
        least = np.ascontiguousarray(best[:, :, 0])
        return cls(legs, cap, bins, memory, watch, price, sigma, cuts, best, least, cap)

    def behind(self, bins: Bins, reach: float) -> Subproblem:
        """Return the problem of the same tours flown backwards, of `bins` made so, labels up to `reach` [s]."""
        out, between, home = self.legs
        legs = UavLegs(home, np.ascontiguousarray(between.T), out)
        same = self.memory, self.watch, self.price, self.sigma, self.cuts
        return self.bounded(legs, self.cap, bins, *same)._replace(reach=reach)


_NONE = 0xFFFFFFFF
"""In place of a label before, in a pair, where there is none."""


class Orders(NamedTuple):
    """The flying orders of labels: the `last` task of each, and the label before it, `parent`, < 0 for none."""

    last: NDArray[np.int16]
    parent: NDArray[np.int32]


class Found(NamedTuple):
    """Tours found: where they end, reduced costs and costs [s], sets (p, words), labels used, whether these are all.

    floor [s] : no tour below the threshold that was not found has a reduced cost below it; pairs : of labels, tried.
    """

    ends: Ints
    values: Floats
    costs: Floats
    visited: NDArray[np.uint64]
    labels: int
    complete: bool
    floor: float
    pairs: int = 0

    def best(self, most: int) -> Found:
        """Return the `most` tours of least reduced cost, the least first."""
        chosen = np.argsort(self.values, kind="stable")[:most]
        kept = self.ends[chosen], self.values[chosen], self.costs[chosen], self.visited[chosen]
        return Found(*kept, self.labels, self.complete, self.floor, self.pairs)


class Room(Protocol):
    """Where labels find room."""

    def of_uav(self, k: int) -> Labels:
        """Return the room for labels of UAV k."""


class Labels(Room, Protocol):
    """Labels of one kind and what is done with them in a search, layer by layer: `Store` describes each method."""

    @property
    def room(self) -> int:
        """How many labels there may be."""

    def depart(self, problem: Subproblem, threshold: float, free: int) -> int:
        """Make the labels of one task, from label `free` on, and return the next free one."""

    def expand(
        self, problem: Subproblem, threshold: float, low: int, high: int, free: int, room: int
    ) -> tuple[bool, int]:
        """Extend labels low..high−1 by every task."""

    def keep_best(self, beam: int, begin: int, end: int) -> tuple[int, float]:
        """Keep the `beam` labels of smallest bound of a layer; return its new end, and the bound the others reach."""

    def tours(self, problem: Subproblem, threshold: float, begin: int, end: int) -> tuple[Ints, Floats, Floats]:
        """Return where tours below the threshold end in a layer, their reduced costs and costs [s]."""

    def clear(self, begin: int, end: int) -> None:
        """Empty the hash table."""

    def sets(self, ends: Ints) -> NDArray[np.uint64]:
        """Return the tasks visited by tours that end there."""

    def orders(self, found: Found) -> tuple[Orders, Ints]:
        """Return the flying orders of what was found, and where in them its tours end."""


class Parents(Protocol):
    """Labels that know the one before: `Orders`, or a `Store`."""

    @property
    def last(self) -> NDArray[np.int16]:
        """The last task of each."""

    @property
    def parent(self) -> NDArray[np.int32]:
        """The label before each, < 0 for none."""


def path(labels: Parents, label: int) -> tuple[int, ...]:
    """Return the tasks of a label, or of a pair of them (`pair`), in flying order."""
    ahead, behind = label & _NONE, (label >> 32) - 1
    order = list(_back(labels, -1 if ahead == _NONE else ahead))
    return (*reversed(order), *_back(labels, behind))


def pair(ahead: Ints, behind: Ints) -> Ints:
    """Return one number for two labels: of a path from the depot and, flown backwards, of one home; −1 for none."""
    return (ahead & _NONE) | (behind + 1) << 32


def _back(labels: Parents, label: int) -> Iterator[int]:
    while label >= 0:
        yield int(labels.last[label])
        label = int(labels.parent[label])


class Layers(NamedTuple):
    """What a search from layer to layer came to: its last label + 1, whether no label was lost, and `floor`.

    ends, values, costs : as in `Found`, of all tours met. floor [s] : the least bound of a label lost.
    """

    end: int
    complete: bool
    floor: float
    ends: Ints
    values: Floats
    costs: Floats

    @classmethod
    def lost(cls, end: int) -> Layers:
        """Return what is known of labels that were not made: nothing."""
        return cls(end, False, -np.inf, np.zeros(0, np.int64), np.zeros(0), np.zeros(0))


def search(
    problem: Subproblem,
    store: Labels,
    threshold: float,
    time_left: Clock,
    *,
    beam: int | None = None,
    labels: int | None = None,
    tours: int,
) -> Found:
    """Find the tours of reduced cost below `threshold`, the cheapest for each set of tasks.

    Not all of them where a layer is cut off at `beam` labels, or `labels` in all or `tours` are too few. Where `labels`
    are clearly not going to be enough it ends at once.
    """
    found = layers(problem, store, threshold, time_left, beam=beam, labels=labels, tours=tours)
    visited = store.sets(found.ends)
    chosen = cheapest_of_each_set(found.costs, visited)
    kept = found.ends[chosen], found.values[chosen], found.costs[chosen], visited[chosen]
    return Found(*kept, found.end, found.complete, found.floor)


def layers(
    problem: Subproblem,
    store: Labels,
    threshold: float,
    time_left: Clock,
    *,
    begin: int = 0,
    beam: int | None = None,
    labels: int | None = None,
    tours: int,
) -> Layers:
    """Make all labels, from label `begin` of the store on, and meet tours; the rest as in `search`."""
    room = min(begin + (labels or store.room), store.room)
    few, less = begin + (room - begin) // _EARLY, _LESS if problem.reach >= problem.cap else _LESS_HALF_WAY
    layers_found, listed, complete, floor = [], 0, True, np.inf
    end = store.depart(problem, threshold, begin)
    if end == store.room:  # there may be more
        return Layers.lost(end)
    sizes = [end - begin]
    while end > begin:
        if beam is not None and end - begin > beam:
            end, others = store.keep_best(beam, begin, end)
            complete, floor = False, min(floor, others)
        layers_found.append(store.tours(problem, threshold, begin, end))
        listed += layers_found[-1][0].size
        free, stopped = end, listed > tours
        for low in range(begin, end, _CHUNK):
            if stopped or time_left() <= 0:
                stopped = True
                break
            stopped, free = store.expand(problem, threshold, low, min(low + _CHUNK, end), free, room)
        store.clear(end, free)
        sizes.append(free - end)
        if stopped or (labels is not None and free > few and end + less * _projected(sizes) > room):
            complete, floor = False, -np.inf
            break
        begin, end = end, free
    none = np.zeros(0, np.int64), np.zeros(0), np.zeros(0)
    ends, values, costs = (np.concatenate(parts) for parts in zip(none, *layers_found, strict=True))
    return Layers(end, complete, floor, ends, values, costs)


def _projected(sizes: list[int]) -> float:
    """Return how many labels are still to come: the growth from layer to layer goes on falling as it fell last.

    It falls ever less, so that this is too low rather than too high.
    """
    if len(sizes) < 3:
        return 0.0
    before, growth = sizes[-2] / sizes[-3], sizes[-1] / sizes[-2]
    fall, size, total = min(0.9, growth / before), float(sizes[-1]), 0.0
    while size >= 1.0:
        growth *= fall
        size *= growth
        total += size
    return total


def limit(bound: Floats, beam: int, begin: int, end: int) -> float:
    """Return the bound [s] that the `beam` best labels of a layer do not pass."""
    return float(np.partition(bound[begin:end], beam - 1)[beam - 1])


def cheapest_of_each_set(costs: Floats, visited: NDArray[np.uint64]) -> Ints:
    """Return, in order, which tours are the cheapest of those that visit the same tasks."""
    slots = _cheapest(costs, visited)
    return np.sort(slots[slots >= 0])


@njit(cache=True, nogil=True)
def _cheapest(costs: Floats, visited: NDArray[np.uint64]) -> Ints:
    """Return a table of the tours of least cost of every set visited, and of −1."""
    size = 16
    while size < 2 * costs.size:
        size *= 2
    slots = np.full(size, -1, np.int64)
    for t in range(costs.size):
        words = visited[t]
        slot = hashed(words, 0, size - 1)
        while slots[slot] >= 0 and not same(visited[slots[slot]], words):
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0 or costs[t] < costs[slots[slot]]:
            slots[slot] = t
    return slots
