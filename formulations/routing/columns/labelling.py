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

import numba
import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.completion import bins_left
from instances.arrays import Floats, Ints

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


class Field(NamedTuple):
    """What a search runs on: legs of one UAV [s], successors, `n_bins` of `width` [s] under the cap [s], prices.

    `near` (n, g) are the tasks remembered, `watched` (n, q, 3) the cuts watched (see `watching`), `partners` and `rho`
    the cuts of each task (see `cuts`), `best` the completion bounds.
    """

    out: Floats
    between: Floats
    home: Floats
    order: Ints
    degree: Ints
    cap: float
    width: float
    n_bins: int
    near: Ints
    watched: Ints
    price: Floats
    sigma: float
    partners: Ints
    rho: Floats
    best: Floats


class Found(NamedTuple):
    """Tours found: the labels they end in and their reduced costs [s], labels used, whether nothing was cut off."""

    ends: Ints
    values: Floats
    labels: int
    complete: bool


def make_store(n_tasks: int, room: int) -> Store:
    """Make room for `room` labels over `n_tasks` tasks."""
    slots = 1 << int(2 * room - 1).bit_length()
    return Store(
        np.zeros((room, (n_tasks + 63) // 64), np.uint64),
        np.zeros(room, np.int16),
        np.zeros(room),
        np.zeros(room),
        np.zeros(room),
        np.zeros(room, np.int32),
        np.full(slots, -1, np.int32),
    )


def path(last: NDArray[np.int16], parent: NDArray[np.int32], label: int) -> tuple[int, ...]:
    """Return the tasks of a label in flying order."""
    order = []
    while label >= 0:
        order.append(int(last[label]))
        label = int(parent[label])
    return tuple(reversed(order))


def search(
    field: Field,
    store: Store,
    threshold: float,
    out_of_time: Callable[[], bool],
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
    begin, end = 0, depart(field, store, threshold)
    layers = [end]
    while end > begin:
        if beam is not None and end - begin > beam:
            complete = False
            end = _keep_best(store, beam, begin, end)
        layer_ends, layer_values = _tours(field, store, threshold, begin, end)
        ends.append(layer_ends)
        values.append(layer_values)
        listed += layer_ends.size
        free, stopped = end, listed > tours
        for low in range(begin, end, _CHUNK):
            if stopped or out_of_time():
                stopped = True
                break
            stopped, free = expand(field, store, threshold, low, min(low + _CHUNK, end), free, room)
        _clear(store, end, free)
        layers.append(free - end)
        if stopped or (labels is not None and end + _LESS * _projected(layers) > room):
            complete = False
            break
        begin, end = end, free
    if not ends:
        return Found(np.zeros(0, np.int64), np.zeros(0), 0, True)
    at, value = np.concatenate(ends), np.concatenate(values)
    chosen = _cheapest_of_each_set(at, value, store.visited)
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


def compile_beam() -> None:
    """Compile what only a search wider than its beam calls, so that no timed search waits for it."""
    _keep_best(make_store(3, 8), 2, 0, 4)


@numba.njit(cache=True)
def has(words, task):  # type: ignore[no-untyped-def]
    """Say whether a set contains a task."""
    return (words[task >> 6] >> np.uint64(task & 63)) & np.uint64(1) != np.uint64(0)


@numba.njit(cache=True)
def alone(field, task):  # type: ignore[no-untyped-def]
    """Return the state of the completion bounds at `task` where nothing else was visited."""
    bits = 0
    for r in range(field.watched.shape[1]):
        for a in range(3):
            if field.watched[task, r, a] == task:
                bits |= 1 << r
    return bits * ((1 << field.near.shape[1]) + 1)


@numba.njit(cache=True, inline="always")
def _state(field, seen, task):  # type: ignore[no-untyped-def]
    """Return the state of the completion bounds at `task` after the tasks `seen`, which are other ones."""
    memory, bits = 0, 0
    for q in range(field.near.shape[1]):
        if has(seen, field.near[task, q]):
            memory |= 1 << q
    for r in range(field.watched.shape[1]):
        if field.watched[task, r, 0] >= 0:
            held = 0
            for a in range(3):
                member = field.watched[task, r, a]
                held += member == task or has(seen, member)
            if held == 1:
                bits |= 1 << r
    return bits * ((1 << field.near.shape[1]) + 1) + memory


@numba.njit(cache=True, inline="always")
def _hash(words, task, mask):  # type: ignore[no-untyped-def]
    h = np.uint64(task + 1) * _GOLDEN
    for w in range(words.size):
        h = (h ^ words[w]) * _GOLDEN
        h ^= h >> np.uint64(29)
    return np.int64(h & np.uint64(mask))


@numba.njit(cache=True, inline="always")
def _same(a, b):  # type: ignore[no-untyped-def]
    equal = True
    for w in range(a.size):
        equal = equal and a[w] == b[w]
    return equal


@numba.njit(cache=True)
def depart(field, store, threshold):  # type: ignore[no-untyped-def]
    """Make the labels of one task and return how many there are."""
    free = 0
    for j in range(field.home.size):
        spent, earned = field.out[j], field.price[j]
        if not spent <= field.cap:
            continue
        left = bins_left(field.cap - spent, field.width, field.n_bins)
        least = field.sigma * spent - earned + field.best[j, left, alone(field, j)]
        if least < threshold and free < store.last.size:
            store.visited[free] = np.uint64(0)
            store.visited[free, j >> 6] = np.uint64(1) << np.uint64(j & 63)
            store.last[free], store.parent[free] = j, -1
            store.cost[free], store.gain[free], store.bound[free] = spent, earned, least
            free += 1
    return free


@numba.njit(cache=True)
def expand(field, store, threshold, low, high, free, room):  # type: ignore[no-untyped-def]
    """Extend the labels low..high−1 by every task; return whether `room` labels are too few, and the next free one."""
    mask = store.slots.size - 1
    for label in range(low, high):
        here, seen = store.last[label], store.visited[label]
        fresh = seen.copy()
        for a in range(field.degree[here]):
            j = field.order[here, a]
            spent = store.cost[label] + field.between[here, j]
            if has(seen, j) or not spent <= field.cap:
                continue
            earned = store.gain[label] + field.price[j]
            for q in range(field.rho.shape[1]):
                if field.rho[j, q] > 0 and has(seen, field.partners[j, q, 0]) != has(seen, field.partners[j, q, 1]):
                    earned -= field.rho[j, q]
            left = bins_left(field.cap - spent, field.width, field.n_bins)
            least = field.sigma * spent - earned + field.best[j, left, _state(field, seen, j)]
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
                store.visited[at] = fresh
                store.cost[at] = np.inf
            fresh[j >> 6] ^= bit
            if spent < store.cost[at]:
                store.cost[at], store.gain[at] = spent, earned
                store.bound[at], store.parent[at] = least, label
    return False, free


@numba.njit(cache=True)
def _clear(store, begin, end):  # type: ignore[no-untyped-def]
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


@numba.njit(cache=True)
def _keep_best(store, beam, begin, end):  # type: ignore[no-untyped-def]
    """Keep the `beam` labels of smallest bound of a layer, in their order, and return the new end."""
    limit = np.partition(store.bound[begin:end], beam - 1)[beam - 1]
    free = begin
    for label in range(begin, end):
        if store.bound[label] <= limit and free < begin + beam:
            store.visited[free], store.last[free] = store.visited[label], store.last[label]
            store.cost[free], store.gain[free] = store.cost[label], store.gain[label]
            store.bound[free], store.parent[free] = store.bound[label], store.parent[label]
            free += 1
    return free


@numba.njit(cache=True)
def _tours(field, store, threshold, begin, end):  # type: ignore[no-untyped-def]
    """Return the labels of a layer that can fly home for less than the threshold, and at what reduced cost."""
    ends, values, found = np.empty(end - begin, np.int64), np.empty(end - begin), 0
    for label in range(begin, end):
        whole = store.cost[label] + field.home[store.last[label]]
        value = field.sigma * whole - store.gain[label]
        if whole <= field.cap and value < threshold:
            ends[found], values[found] = label, value
            found += 1
    return ends[:found].copy(), values[:found].copy()


@numba.njit(cache=True)
def _cheapest_of_each_set(labels, values, visited):  # type: ignore[no-untyped-def]
    """Return the positions in `labels` of the tour of least value of every set visited, in order of discovery."""
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
    return np.sort(slots[slots >= 0])
