"""Forward labels: elementary paths from a depot, layer by layer, kept where they may still become a good tour.

A label is a set of visited tasks V, the last of them, and the least cost of getting there (for one V and last task the
cheaper path is better in every way, as in Held & Karp). Its reduced cost is σ·cost − gain, with gain = Σ_{i∈V} π_i less
ρ of every cut (see `cuts`) with two tasks in V. A label is dropped as soon as reduced cost plus completion bound (see
`completion`) reaches the threshold: no tour that begins so is wanted. Layer ℓ holds paths of ℓ tasks. With a finite
`beam` only the most promising labels of a layer are kept: then the tours found are real, but absence proves nothing,
and the search says so.

Sets are rows of ⌈n/64⌉ unsigned words, so n has no limit. (V, last) are found again by open addressing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.completion import Bins, Memory, bins_left
from formulations.routing.columns.cuts import TaskCuts, Watch
from formulations.routing.columns.legs import UavLegs
from instances.arrays import Floats, Ints
from instances.kernels import njit

Clock = Callable[[], bool]
"""Says whether time is up."""


def never() -> bool:
    """Set no limit of time."""
    return False


_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_CHUNK = 50_000
_LESS = 2.0  # how much less than there will be is projected, for tours of ten tasks and more


class Store(NamedTuple):
    """Room for labels, used again by every search; `slots` is the hash table."""

    visited: NDArray[np.uint64]
    last: NDArray[np.int16]
    cost: Floats
    gain: Floats
    bound: Floats
    parent: NDArray[np.int32]
    slots: NDArray[np.int32]


class Subproblem(NamedTuple):
    """The pricing problem of one UAV: tours of cost ≤ `cap` [s] over its legs, least in reduced cost.

    price : π_i [s] of the tasks, shape (n,); sigma : σ_k of the UAV; cuts : what each task's cuts charge.
    bins, memory, watch, best : the completion bounds B and the states they are for.
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


class Orders(NamedTuple):
    """The flying orders of labels: the `last` task of each, and the label before it, `parent`, < 0 for none."""

    last: NDArray[np.int16]
    parent: NDArray[np.int32]


class Found(NamedTuple):
    """Tours found: the labels they end in and their reduced costs [s], labels used, whether nothing was cut off."""

    ends: Ints
    values: Floats
    labels: int
    complete: bool


def make_store(n_tasks: int, room: int) -> Store:
    """Make room for `room` labels over `n_tasks` tasks."""
    slots = 1 << int(2 * room - 1).bit_length()
    visited, last = np.zeros((room, (n_tasks + 63) // 64), np.uint64), np.zeros(room, np.int16)
    cost, gain, bound = np.zeros(room), np.zeros(room), np.zeros(room)
    return Store(visited, last, cost, gain, bound, np.zeros(room, np.int32), np.full(slots, -1, np.int32))


def path(labels: Orders | Store, label: int) -> tuple[int, ...]:
    """Return the tasks of a label in flying order."""
    order = []
    while label >= 0:
        order.append(int(labels.last[label]))
        label = int(labels.parent[label])
    return tuple(reversed(order))


def search(
    problem: Subproblem,
    store: Store,
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
    room = min(labels or store.last.size, store.last.size)
    ends, values, listed, complete = [], [], 0, True
    begin, end = 0, _depart(problem, store, threshold)
    layers = [end]
    while end > begin:
        if beam is not None and end - begin > beam:
            complete = False
            end = keep_best(store, beam, begin, end)
        layer_ends, layer_values = _tours(problem, store, threshold, begin, end)
        ends.append(layer_ends)
        values.append(layer_values)
        listed += layer_ends.size
        free, stopped = end, listed > tours
        for low in range(begin, end, _CHUNK):
            if stopped or out_of_time():
                stopped = True
                break
            stopped, free = _expand(problem, store, threshold, low, min(low + _CHUNK, end), free, room)
        _clear(store, end, free)
        layers.append(free - end)
        if stopped or (labels is not None and end + _LESS * _projected(layers) > room):
            complete = False
            break
        begin, end = end, free
    if not ends:
        return Found(np.zeros(0, np.int64), np.zeros(0), 0, True)
    at, value = np.concatenate(ends), np.concatenate(values)
    slots = _cheapest_of_each_set(at, value, store.visited)
    chosen = np.sort(slots[slots >= 0])
    return Found(at[chosen], value[chosen], end, complete)


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


@njit(cache=True)
def has(words: NDArray[np.uint64], task: int) -> bool:
    """Say whether a set contains a task."""
    return (words[task >> 6] >> np.uint64(task & 63)) & np.uint64(1) != np.uint64(0)


@njit(cache=True)
def least_of_all(problem: Subproblem) -> float:
    """Return a lower bound on the reduced cost [s] of all tours: the best first leg and its completion."""
    least = np.inf
    for j in range(problem.price.size):
        least = min(least, _beginning_with(problem, j))
    return least


@njit(cache=True)
def _beginning_with(problem: Subproblem, task: int) -> float:
    """Return a lower bound on the reduced cost [s] of the tours whose first task is `task`, infinite past the cap."""
    spent = problem.legs.out[task]
    if not spent <= problem.cap:
        return np.inf
    nothing = np.zeros((problem.price.size + 63) // 64, np.uint64)
    state = _state(problem.memory.near, problem.watch.members, nothing, task)
    left = bins_left(problem.cap - spent, problem.bins)
    return problem.sigma * spent - problem.price[task] + problem.best[task, left, state]


@njit(cache=True, inline="always")
def _state(near: Ints, members: Ints, seen: NDArray[np.uint64], task: int) -> int:
    """Return the state of the completion bounds at `task` after the tasks `seen`, which are other ones."""
    memory, bits = 0, 0
    for q in range(near.shape[1]):
        if has(seen, near[task, q]):
            memory |= 1 << q
    for r in range(members.shape[1]):
        if members[task, r, 0] >= 0:
            held = 0
            for a in range(3):
                member = members[task, r, a]
                held += member == task or has(seen, member)
            if held == 1:
                bits |= 1 << r
    return bits * ((1 << near.shape[1]) + 1) + memory


@njit(cache=True, inline="always")
def _hash(words: NDArray[np.uint64], task: int, mask: int) -> np.int64:
    h = np.uint64(task + 1) * _GOLDEN
    for w in range(words.size):
        h = (h ^ words[w]) * _GOLDEN
        h ^= h >> np.uint64(29)
    return np.int64(h & np.uint64(mask))


@njit(cache=True, inline="always")
def _same(a: NDArray[np.uint64], b: NDArray[np.uint64]) -> bool:
    equal = True
    for w in range(a.size):
        equal = equal and a[w] == b[w]
    return equal


@njit(cache=True)
def _depart(problem: Subproblem, store: Store, threshold: float) -> int:
    """Make the labels of one task and return how many there are."""
    free = 0
    for j in range(problem.price.size):
        least = _beginning_with(problem, j)
        if least < threshold and free < store.last.size:
            for w in range(store.visited.shape[1]):
                store.visited[free, w] = np.uint64(0)
            store.visited[free, j >> 6] = np.uint64(1) << np.uint64(j & 63)
            store.last[free], store.parent[free] = j, -1
            store.cost[free], store.gain[free], store.bound[free] = problem.legs.out[j], problem.price[j], least
            free += 1
    return free


@njit(cache=True)
def _expand(
    problem: Subproblem, store: Store, threshold: float, low: int, high: int, free: int, room: int
) -> tuple[bool, int]:
    """Extend the labels low..high−1 by every task; return whether `room` labels are too few, and the next free one."""
    between, order, degree, cap = problem.legs.between, problem.bins.order, problem.bins.degree, problem.cap
    price, sigma, best, bins = problem.price, problem.sigma, problem.best, problem.bins
    partners, rho, near, members = problem.cuts.partners, problem.cuts.rho, problem.memory.near, problem.watch.members
    mask = store.slots.size - 1
    for label in range(low, high):
        here, seen = store.last[label], store.visited[label]
        fresh = seen.copy()
        for a in range(degree[here]):
            j = order[here, a]
            spent = store.cost[label] + between[here, j]
            if has(seen, j) or not spent <= cap:
                continue
            earned = store.gain[label] + price[j]
            for q in range(rho.shape[1]):
                if rho[j, q] > 0 and has(seen, partners[j, q, 0]) != has(seen, partners[j, q, 1]):
                    earned -= rho[j, q]
            left = bins_left(cap - spent, bins)
            least = sigma * spent - earned + best[j, left, _state(near, members, seen, j)]
            if least >= threshold:
                continue
            bit = np.uint64(1) << np.uint64(j & 63)
            fresh[j >> 6] |= bit
            slot = _hash(fresh, j, mask)
            at = store.slots[slot]
            while at >= 0 and not (store.last[at] == j and _same(store.visited[at], fresh)):
                slot = (slot + 1) & mask
                at = store.slots[slot]
            if at < 0:
                if free >= room:
                    return True, free
                at = free
                free += 1
                store.slots[slot] = at
                store.last[at] = j
                for w in range(fresh.size):
                    store.visited[at, w] = fresh[w]
                store.cost[at] = np.inf
            fresh[j >> 6] ^= bit
            if spent < store.cost[at]:
                store.cost[at], store.gain[at] = spent, earned
                store.bound[at], store.parent[at] = least, label
    return False, free


@njit(cache=True)
def _clear(store: Store, begin: int, end: int) -> None:
    """Take the labels begin..end−1, which are all that is in it, out of the hash table."""
    slots = store.slots
    mask = slots.size - 1
    if (end - begin) * 8 > slots.size:
        slots[:] = -1
        return
    for label in range(begin, end):
        slot = _hash(store.visited[label], store.last[label], mask)
        while slots[slot] >= 0:
            slots[slot] = -1
            slot = (slot + 1) & mask


def keep_best(store: Store, beam: int, begin: int, end: int) -> int:
    """Keep the `beam` labels of smallest bound of a layer, in their order, and return the new end."""
    limit = float(np.partition(store.bound[begin:end], beam - 1)[beam - 1])
    return _keep(store, beam, begin, end, limit)


@njit(cache=True)
def _keep(store: Store, beam: int, begin: int, end: int, limit: float) -> int:
    """Keep the first `beam` labels of a layer whose bound is within `limit` [s] and return the new end."""
    free = begin
    for label in range(begin, end):
        if store.bound[label] <= limit and free < begin + beam:
            for w in range(store.visited.shape[1]):
                store.visited[free, w] = store.visited[label, w]
            store.last[free] = store.last[label]
            store.cost[free], store.gain[free] = store.cost[label], store.gain[label]
            store.bound[free], store.parent[free] = store.bound[label], store.parent[label]
            free += 1
    return free


@njit(cache=True)
def _tours(problem: Subproblem, store: Store, threshold: float, begin: int, end: int) -> tuple[Ints, Floats]:
    """Return the labels of a layer that can fly home for less than the threshold, and at what reduced cost."""
    ends, values, found = np.empty(end - begin, np.int64), np.empty(end - begin), 0
    for label in range(begin, end):
        whole = store.cost[label] + problem.legs.home[store.last[label]]
        value = problem.sigma * whole - store.gain[label]
        if whole <= problem.cap and value < threshold:
            ends[found], values[found] = label, value
            found += 1
    return ends[:found].copy(), values[:found].copy()


@njit(cache=True)
def _cheapest_of_each_set(labels: Ints, values: Floats, visited: NDArray[np.uint64]) -> Ints:
    """Return a table of the positions in `labels` of the tour of least value of every set visited, and of −1."""
    size = 16
    while size < 2 * labels.size:
        size *= 2
    slots = np.full(size, -1, np.int64)
    for t in range(labels.size):
        words = visited[labels[t]]
        slot = _hash(words, 0, size - 1)
        while slots[slot] >= 0 and not _same(visited[labels[slots[slot]]], words):
            slot = (slot + 1) & (size - 1)
        if slots[slot] < 0 or values[t] < values[slots[slot]]:
            slots[slot] = t
    return slots
