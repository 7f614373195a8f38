"""Forward labels over states: (V, last task) as in `labelling`, with the least cost of getting to each state of it.

For one set V and last task j the label keeps f(b), the least cost of a chain of states that ends in state b of j:

    f_{V∪j}(b) = min_{a} f_V(a) + c[(i, a), (j, b)]

A state is dropped where reduced cost plus completion bound reaches the threshold, a label where all its states are.
Completion bounds, fixing and cuts know the tasks only, and legs at their least over states: a bound of what they are
(`completion`), so that all tours are found whose cost over chains of states is low enough.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.completion import bins_left
from formulations.routing.columns.cuts import half_held, paid_for
from formulations.routing.columns.label_search import Found, Orders, Subproblem, limit
from formulations.routing.columns.labelling import memory_of
from formulations.routing.columns.word_sets import clear, has, hashed, same
from formulations.routing.state_dp import StateLegs, state_legs
from instances import Instance
from instances.arrays import Floats, Ints
from instances.kernels import njit

_MOST_ENTRIES = 40_000_000
"""States of labels, twelve bytes each."""


class StateStore(NamedTuple):
    """Room for labels, as `labelling.Store`: `spent` (room, H) [s] in each state of the last task, `came` from labels.

    A chain that ends in state b of label l ends at l·H + b.
    """

    visited: NDArray[np.uint64]
    last: NDArray[np.int16]
    gain: Floats
    bound: Floats
    spent: Floats
    came: NDArray[np.int32]
    slots: NDArray[np.int32]


@dataclass(frozen=True)
class StateLabels:
    """Labels of instances with states; the methods are those of `label_search.Labels`.

    legs : of each UAV; store : their room; uav : whose labels these are.
    """

    legs: tuple[StateLegs, ...]
    store: StateStore
    uav: int = 0

    @classmethod
    def of(cls, instance: Instance, room: int) -> StateLabels:
        """Make room for `room` labels, or as many as their states leave."""
        legs = tuple(state_legs(instance, k) for k in range(instance.n_depots))
        widest = int(np.diff(legs[0].first).max())
        room = min(room, max(1000, _MOST_ENTRIES // widest))
        slots = np.full(1 << int(2 * room - 1).bit_length(), -1, np.int32)
        visited, last = np.zeros((room, (instance.n_tasks + 63) // 64), np.uint64), np.zeros(room, np.int16)
        spent, came = np.empty((room, widest)), np.empty((room, widest), np.int32)
        return cls(legs, StateStore(visited, last, np.zeros(room), np.zeros(room), spent, came, slots))

    @property
    def room(self) -> int:
        """How many labels there may be."""
        return self.store.last.size

    def of_uav(self, k: int) -> StateLabels:
        """Return the room for labels of UAV k."""
        return replace(self, uav=k)

    def depart(self, problem: Subproblem, threshold: float, free: int) -> int:
        """Make the labels of one task, from label `free` on, and return the next free one."""
        return int(_depart(problem, self.legs[self.uav], self.store, threshold, free))

    def expand(
        self, problem: Subproblem, threshold: float, low: int, high: int, free: int, room: int
    ) -> tuple[bool, int]:
        """Extend labels low..high−1 by every task; return whether `room` labels are too few, and the next free one."""
        full, free = _expand(problem, self.legs[self.uav], self.store, threshold, low, high, free, room)
        return full, free

    def keep_best(self, beam: int, begin: int, end: int) -> tuple[int, float]:
        """Keep the `beam` labels of smallest bound of a layer, in order; return its new end, the others' bound."""
        s = self.store
        most = limit(s.bound, beam, begin, end)
        kept = begin + np.flatnonzero(s.bound[begin:end] <= most)[:beam]
        for array in (s.visited, s.last, s.gain, s.bound, s.spent, s.came):
            array[begin : begin + kept.size] = array[kept]
        return begin + kept.size, most

    def tours(self, problem: Subproblem, threshold: float, begin: int, end: int) -> tuple[Ints, Floats, Floats]:
        """Return where tours below the threshold end in a layer, their reduced costs and costs [s]."""
        s, legs = self.store, self.legs[self.uav]
        first, last = legs.first, s.last[begin:end].astype(np.int64)
        home = np.full((len(first) - 1, s.spent.shape[1]), np.inf)
        for j in np.flatnonzero(problem.legs.home <= problem.cap):
            home[j, : first[j + 1] - first[j]] = legs.ends[0, first[j] : first[j + 1]]
        whole = home[last]
        np.add(s.spent[begin:end], whole, out=whole, where=whole < np.inf)  # where there is no state none was written
        state = whole.argmin(axis=1)
        cost = whole[np.arange(len(state)), state]
        found = np.flatnonzero(cost <= problem.cap)
        value = problem.sigma * cost[found] - s.gain[begin + found]
        found, value = found[value < threshold], value[value < threshold]
        return (begin + found) * s.spent.shape[1] + state[found], value, cost[found]

    def clear(self, begin: int, end: int) -> None:
        """Take the labels begin..end−1, which are all that is in it, out of the hash table."""
        clear(self.store.visited, self.store.last, self.store.slots, begin, end)

    def sets(self, ends: Ints) -> NDArray[np.uint64]:
        """Return the tasks visited by tours that end there, (p, words)."""
        return self.store.visited[ends // self.store.spent.shape[1]]

    def orders(self, found: Found) -> tuple[Orders, Ints]:
        """Return the flying orders of what was found, and where in them its tours end: chains that are used alone."""
        at = np.unique(found.ends)
        known, before = [at], []
        while at.size:
            before.append(_before(self.legs[self.uav], self.store, at))
            at = np.unique(before[-1][before[-1] >= 0])
            known.append(at)
        chains, first = np.unique(np.concatenate(known), return_index=True)
        parents = np.concatenate([*before, np.zeros(0, np.int64)])[first]
        parent = np.where(parents >= 0, np.searchsorted(chains, parents), -1).astype(np.int32)
        last = self.store.last[chains // self.store.spent.shape[1]]
        return Orders(last, parent), np.searchsorted(chains, found.ends)


@njit(cache=True, nogil=True)
def _before(states: StateLegs, store: StateStore, chains: Ints) -> Ints:
    """Return the chain before each, −1 for none: of the label before, the state that it cost least to come from."""
    before, width, first = np.full(chains.size, -1), store.spent.shape[1], states.first
    for t in range(chains.size):
        label, b = chains[t] // width, chains[t] % width
        parent = store.came[label, b]
        if parent < 0:
            continue
        i, j, least = store.last[parent], store.last[label], np.inf
        for a in range(first[i + 1] - first[i]):
            spent = store.spent[parent, a] + states.between[first[i] + a, first[j] + b]
            if spent < least:
                before[t], least = parent * width + a, spent
    return before


@njit(cache=True, nogil=True)
def _depart(problem: Subproblem, states: StateLegs, store: StateStore, threshold: float, free: int) -> int:
    """Make the labels of one task, from label `free` on, and return the next free one."""
    nothing = np.zeros(store.visited.shape[1], np.uint64)
    first = states.first
    for j in range(problem.price.size):
        if not problem.legs.out[j] <= problem.cap or free == store.last.size:
            continue
        at = memory_of(problem.memory.near, problem.watch.members, nothing, j)
        lowest = np.inf
        for b in range(first[j + 1] - first[j]):
            spent = states.starts[0, first[j] + b]
            least = np.inf
            if spent <= problem.cap:
                left = bins_left(problem.cap - spent, problem.bins)
                least = problem.sigma * spent - problem.price[j] + problem.best[j, left, at]
            store.spent[free, b] = spent if least < threshold else np.inf
            store.came[free, b] = -1
            lowest = min(lowest, least)
        if lowest < threshold:
            for w in range(store.visited.shape[1]):
                store.visited[free, w] = np.uint64(0)
            store.visited[free, j >> 6] = np.uint64(1) << np.uint64(j & 63)
            store.last[free], store.gain[free], store.bound[free] = j, problem.price[j], lowest
            free += 1
    return free


@njit(cache=True, nogil=True)
def _expand(
    problem: Subproblem,
    states: StateLegs,
    store: StateStore,
    threshold: float,
    low: int,
    high: int,
    free: int,
    room: int,
) -> tuple[bool, int]:
    """Extend the labels low..high−1 by every task; return whether `room` labels are too few, and the next free one."""
    least_legs, order, degree, cap = problem.legs.between, problem.bins.order, problem.bins.degree, problem.cap
    price, sigma, best, bins = problem.price, problem.sigma, problem.best, problem.bins
    bits, prices, near, members = problem.cuts.bits, problem.cuts.prices, problem.memory.near, problem.watch.members
    half = np.empty(bits.shape[1], np.uint64)
    first, between = states.first, states.between
    mask = store.slots.size - 1
    there = np.empty(store.spent.shape[1])
    for label in range(low, high):
        here, seen = store.last[label], store.visited[label]
        width = first[here + 1] - first[here]
        before = store.spent[label, :width]
        nearest = before.min()
        fresh = seen.copy()
        half_held(seen, bits, half)
        for a in range(degree[here]):
            j = order[here, a]
            at_least = nearest + least_legs[here, j]
            if has(seen, j) or not at_least <= cap:
                continue
            earned = store.gain[label] + price[j]
            earned -= paid_for(half, bits[j], prices)
            state = memory_of(near, members, seen, j)
            if sigma * at_least - earned + best[j, bins_left(cap - at_least, bins), state] >= threshold:
                continue
            _chain(before, between[first[here] : first[here + 1], first[j] : first[j + 1]], there)
            lowest = np.inf
            for b in range(first[j + 1] - first[j]):
                spent = there[b]
                least = np.inf
                if spent <= cap:
                    least = sigma * spent - earned + best[j, bins_left(cap - spent, bins), state]
                if least >= threshold:
                    there[b] = np.inf
                lowest = min(lowest, least)
            if lowest >= threshold:
                continue
            bit = np.uint64(1) << np.uint64(j & 63)
            fresh[j >> 6] |= bit
            slot = hashed(fresh, j, mask)
            at = store.slots[slot]
            while at >= 0 and not (store.last[at] == j and same(store.visited[at], fresh)):
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
                store.spent[at] = np.inf
                store.bound[at] = np.inf
                store.gain[at] = earned
            fresh[j >> 6] ^= bit
            for b in range(first[j + 1] - first[j]):
                if there[b] < store.spent[at, b]:
                    store.spent[at, b], store.came[at, b] = there[b], label
            store.bound[at] = min(store.bound[at], lowest)
    return False, free


@njit(cache=True, nogil=True)
def _chain(before: Floats, legs: Floats, there: Floats) -> None:
    """Write to `there` the least cost of each state after `legs`, with `before` for each before them."""
    width = legs.shape[1]
    there[:] = np.inf
    for a in range(before.size):
        spent = before[a]
        if spent < np.inf:
            row = legs[a]
            for b in range(width):
                total = spent + row[b]
                there[b] = total if total < there[b] else there[b]
