"""The search for tours: from layer to layer of labels, whatever a label is, and what is found.

Layer ℓ holds paths of ℓ tasks. With a finite `beam` only the most promising labels of a layer are kept: then the tours
found are real, and those that are not have at least the least bound of a label left aside, the `floor`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.completion import Bins, Memory, completion
from formulations.routing.columns.cuts import TaskCuts, Watch
from formulations.routing.columns.legs import UavLegs
from formulations.routing.columns.word_sets import hashed, same
from instances.arrays import Floats, Ints
from instances.kernels import njit

Clock = Callable[[], bool]
"""Says whether time is up."""


def never() -> bool:
    """Set no limit of time."""
    return False


_CHUNK = 50_000
_EARLY = 50  # part of the room: of fewer labels nothing is projected
_LESS = 2.0  # how much less than there will be is projected, for tours of ten tasks and more


class Subproblem(NamedTuple):
    """The pricing problem of one UAV: tours of cost ≤ `cap` [s] over its legs, least in reduced cost.

    price : π_i [s] of the tasks, shape (n,); sigma : σ_k of the UAV; cuts : what each task's cuts charge.
    bins, memory, watch, best : the completion bounds B and the states they are for; least (n, most + 1) : those of the
        least restricted one, close together because labels ask for them most.
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
        """Return the problem with its completion bounds."""
        best = completion(bins, memory, watch, price, sigma)
        return cls(legs, cap, bins, memory, watch, price, sigma, cuts, best, np.ascontiguousarray(best[:, :, 0]))


class Orders(NamedTuple):
    """The flying orders of labels: the `last` task of each, and the label before it, `parent`, < 0 for none."""

    last: NDArray[np.int16]
    parent: NDArray[np.int32]


class Found(NamedTuple):
    """Tours found: where they end, reduced costs and costs [s], sets (p, words), labels used, whether these are all.

    floor [s] : no tour below the threshold that was not found has a reduced cost below it.
    """

    ends: Ints
    values: Floats
    costs: Floats
    visited: NDArray[np.uint64]
    labels: int
    complete: bool
    floor: float

    def best(self, most: int) -> Found:
        """Return the `most` tours of least reduced cost, the least first."""
        chosen = np.argsort(self.values, kind="stable")[:most]
        kept = self.ends[chosen], self.values[chosen], self.costs[chosen], self.visited[chosen]
        return Found(*kept, self.labels, self.complete, self.floor)


class Room(Protocol):
    """Where labels find room."""

    def of_uav(self, k: int) -> Labels:
        """Return the room for labels of UAV k."""


class Labels(Room, Protocol):
    """Labels of one kind and what is done with them in a search, layer by layer: `Store` describes each method."""

    @property
    def room(self) -> int:
        """How many labels there may be."""

    def depart(self, problem: Subproblem, threshold: float) -> int:
        """Make the labels of one task and return how many there are."""

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
    """Return the tasks of a label in flying order."""
    order = []
    while label >= 0:
        order.append(int(labels.last[label]))
        label = int(labels.parent[label])
    return tuple(reversed(order))


def search(
    problem: Subproblem,
    store: Labels,
    threshold: float,
    out_of_time: Clock,
    *,
    beam: int | None = None,
    labels: int | None = None,
    tours: int,
) -> Found:
    """Find the tours of reduced cost below `threshold`, the cheapest for each set of tasks.

    Not all of them where a layer is cut off at `beam` labels, or `labels` in all or `tours` are too few. Where `labels`
    are clearly not going to be enough it ends at once.
    """
    room = min(labels or store.room, store.room)
    layers_found, listed, complete, floor = [], 0, True, np.inf
    begin, end = 0, store.depart(problem, threshold)
    layers = [end]
    while end > begin:
        if beam is not None and end - begin > beam:
            end, others = store.keep_best(beam, begin, end)
            complete, floor = False, min(floor, others)
        layers_found.append(store.tours(problem, threshold, begin, end))
        listed += layers_found[-1][0].size
        free, stopped = end, listed > tours
        for low in range(begin, end, _CHUNK):
            if stopped or out_of_time():
                stopped = True
                break
            stopped, free = store.expand(problem, threshold, low, min(low + _CHUNK, end), free, room)
        store.clear(end, free)
        layers.append(free - end)
        if stopped or (labels is not None and free > room // _EARLY and end + _LESS * _projected(layers) > room):
            complete, floor = False, -np.inf
            break
        begin, end = end, free
    none = np.zeros(0, np.int64), np.zeros(0), np.zeros(0)
    at, value, cost = (np.concatenate(parts) for parts in zip(none, *layers_found, strict=True))
    visited = store.sets(at)
    slots = _cheapest_of_each_set(cost, visited)
    chosen = np.sort(slots[slots >= 0])
    return Found(at[chosen], value[chosen], cost[chosen], visited[chosen], end, complete, floor)


def _projected(layers: list[int]) -> float:
    """Return how many labels are still to come: the growth from layer to layer goes on falling as it fell last.

    It falls ever less, so that this is too low rather than too high.
    """
    if len(layers) < 3:
        return 0.0
    before, growth = layers[-2] / layers[-3], layers[-1] / layers[-2]
    fall, size, total = min(0.9, growth / before), float(layers[-1]), 0.0
    while size >= 1.0:
        growth *= fall
        size *= growth
        total += size
    return total


def limit(bound: Floats, beam: int, begin: int, end: int) -> float:
    """Return the bound [s] that the `beam` best labels of a layer do not pass."""
    return float(np.partition(bound[begin:end], beam - 1)[beam - 1])


@njit(cache=True, nogil=True)
def _cheapest_of_each_set(costs: Floats, visited: NDArray[np.uint64]) -> Ints:
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
