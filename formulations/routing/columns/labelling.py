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
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from formulations.routing.clocks import knot_at
from formulations.routing.columns.completion import Bins, Memory, bins_left
from formulations.routing.columns.courses import course_at, on_course
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
    """Room for labels, used again by every search; `slots` is the hash table. The methods are those of `Labels`."""

    visited: NDArray[np.uint64]
    last: NDArray[np.int16]
    cost: Floats
    gain: Floats
    bound: Floats
    parent: NDArray[np.int32]
    slots: NDArray[np.int32]

    @property
    def room(self) -> int:
        """How many labels there may be."""
        return self.last.size

    def of_uav(self, k: int) -> Store:
        """Return the room for labels of UAV k."""
        return self

    def depart(self, problem: Subproblem, threshold: float) -> int:
        """Make the labels of one task and return how many there are."""
        return int(_depart(problem, self, threshold))

    def expand(
        self, problem: Subproblem, threshold: float, low: int, high: int, free: int, room: int
    ) -> tuple[bool, int]:
        """Extend labels low..high−1 by every task; return whether `room` labels are too few, and the next free one."""
        full, free = _expand(problem, self, threshold, low, high, free, room)
        return full, free

    def keep_best(self, beam: int, begin: int, end: int) -> int:
        """Keep the `beam` labels of smallest bound of a layer, in their order, and return the new end."""
        return int(_keep(self, beam, begin, end, limit(self.bound, beam, begin, end)))

    def tours(self, problem: Subproblem, threshold: float, begin: int, end: int) -> tuple[Ints, Floats, Floats]:
        """Return where tours below the threshold end in a layer, their reduced costs and costs [s]."""
        ends, values, costs = _tours(problem, self, threshold, begin, end)
        return ends, values, costs

    def clear(self, begin: int, end: int) -> None:
        """Take the labels begin..end−1, which are all that is in it, out of the hash table."""
        clear(self.visited, self.last, self.slots, begin, end)

    def sets(self, ends: Ints) -> NDArray[np.uint64]:
        """Return the tasks visited by tours that end there, (p, words)."""
        return self.visited[ends]

    def orders(self, found: Found) -> tuple[Orders, Ints]:
        """Return the flying orders of what was found, and where in them its tours end."""
        return Orders(self.last[: found.labels], self.parent[: found.labels]), found.ends


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
    """Tours found: where they end, reduced costs and costs [s], sets (p, words), labels used, whether these are all."""

    ends: Ints
    values: Floats
    costs: Floats
    visited: NDArray[np.uint64]
    labels: int
    complete: bool

    def best(self, most: int) -> Found:
        """Return the `most` tours of least reduced cost, the least first."""
        chosen = np.argsort(self.values, kind="stable")[:most]
        kept = self.ends[chosen], self.values[chosen], self.costs[chosen], self.visited[chosen]
        return Found(*kept, self.labels, self.complete)


class Labels(Protocol):
    """Labels of one kind and what is done with them in a search, layer by layer: `Store` describes each method."""

    @property
    def room(self) -> int:
        """How many labels there may be."""

    def of_uav(self, k: int) -> Labels:
        """Return the room for labels of UAV k."""

    def depart(self, problem: Subproblem, threshold: float) -> int:
        """Make the labels of one task and return how many there are."""

    def expand(
        self, problem: Subproblem, threshold: float, low: int, high: int, free: int, room: int
    ) -> tuple[bool, int]:
        """Extend labels low..high−1 by every task."""

    def keep_best(self, beam: int, begin: int, end: int) -> int:
        """Keep the `beam` labels of smallest bound of a layer."""

    def tours(self, problem: Subproblem, threshold: float, begin: int, end: int) -> tuple[Ints, Floats, Floats]:
        """Return where tours below the threshold end in a layer, their reduced costs and costs [s]."""

    def clear(self, begin: int, end: int) -> None:
        """Empty the hash table."""

    def sets(self, ends: Ints) -> NDArray[np.uint64]:
        """Return the tasks visited by tours that end there."""

    def orders(self, found: Found) -> tuple[Orders, Ints]:
        """Return the flying orders of what was found, and where in them its tours end."""


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
    layers_found, listed, complete = [], 0, True
    begin, end = 0, store.depart(problem, threshold)
    layers = [end]
    while end > begin:
        if beam is not None and end - begin > beam:
            complete = False
            end = store.keep_best(beam, begin, end)
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
        if stopped or (labels is not None and end + _LESS * _projected(layers) > room):
            complete = False
            break
        begin, end = end, free
    none = np.zeros(0, np.int64), np.zeros(0), np.zeros(0)
    at, value, cost = (np.concatenate(parts) for parts in zip(none, *layers_found, strict=True))
    visited = store.sets(at)
    slots = _cheapest_of_each_set(cost, visited)
    chosen = np.sort(slots[slots >= 0])
    return Found(at[chosen], value[chosen], cost[chosen], visited[chosen], end, complete)


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
    state = memory_of(problem.memory.near, problem.watch.members, nothing, task)
    left = bins_left(problem.cap - spent, problem.bins)
    return problem.sigma * spent - problem.price[task] + problem.best[task, left, state]


@njit(cache=True, inline="always")
def memory_of(near: Ints, members: Ints, seen: NDArray[np.uint64], task: int) -> int:
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
def hashed(words: NDArray[np.uint64], task: int, mask: int) -> np.int64:
    """Return the slot of a set and its last task where there are mask + 1."""
    h = np.uint64(task + 1) * _GOLDEN
    for w in range(words.size):
        h = (h ^ words[w]) * _GOLDEN
        h ^= h >> np.uint64(29)
    return np.int64(h & np.uint64(mask))


@njit(cache=True, inline="always")
def same(a: NDArray[np.uint64], b: NDArray[np.uint64]) -> bool:
    """Say whether two sets are equal."""
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
    courses, order, degree, cap = problem.bins.courses, problem.bins.order, problem.bins.degree, problem.cap
    price, sigma, best, bins = problem.price, problem.sigma, problem.best, problem.bins
    partners, rho, near, members = problem.cuts.partners, problem.cuts.rho, problem.memory.near, problem.watch.members
    mask = store.slots.size - 1
    for label in range(low, high):
        here, seen = store.last[label], store.visited[label]
        fresh, time = seen.copy(), store.cost[label]
        knot = knot_at(courses, time)
        since = time - courses.knots[knot]
        for a in range(degree[here]):
            j = order[here, a]
            spent = (time + on_course(courses, here, j, knot, since)) * courses.rounded
            if has(seen, j) or not spent <= cap:
                continue
            earned = store.gain[label] + price[j]
            for q in range(rho.shape[1]):
                if rho[j, q] > 0 and has(seen, partners[j, q, 0]) != has(seen, partners[j, q, 1]):
                    earned -= rho[j, q]
            left = bins_left(cap - spent, bins)
            least = sigma * spent - earned + best[j, left, memory_of(near, members, seen, j)]
            if least >= threshold:
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
                store.cost[at] = np.inf
            fresh[j >> 6] ^= bit
            if spent < store.cost[at]:
                store.cost[at], store.gain[at] = spent, earned
                store.bound[at], store.parent[at] = least, label
    return False, free


@njit(cache=True)
def clear(visited: NDArray[np.uint64], last: NDArray[np.int16], slots: NDArray[np.int32], begin: int, end: int) -> None:
    """Take the labels begin..end−1, which are all that is in it, out of the hash table."""
    mask = slots.size - 1
    if (end - begin) * 8 > slots.size:
        slots[:] = -1
        return
    for label in range(begin, end):
        slot = hashed(visited[label], last[label], mask)
        while slots[slot] >= 0:
            slots[slot] = -1
            slot = (slot + 1) & mask


def limit(bound: Floats, beam: int, begin: int, end: int) -> float:
    """Return the bound [s] that the `beam` best labels of a layer do not pass."""
    return float(np.partition(bound[begin:end], beam - 1)[beam - 1])


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
def _tours(problem: Subproblem, store: Store, threshold: float, begin: int, end: int) -> tuple[Ints, Floats, Floats]:
    """Return the labels of a layer that can fly home for less than the threshold, their reduced costs and costs [s]."""
    ends, values, costs, found = np.empty(end - begin, np.int64), np.empty(end - begin), np.empty(end - begin), 0
    courses, home, n = problem.bins.courses, problem.legs.home, problem.price.size
    for label in range(begin, end):
        last, time = store.last[label], store.cost[label]
        if not home[last] < np.inf:
            continue
        whole = (time + course_at(courses, last, n, time)) * courses.rounded
        value = problem.sigma * whole - store.gain[label]
        if whole <= problem.cap and value < threshold:
            ends[found], values[found], costs[found] = label, value, whole
            found += 1
    return ends[:found].copy(), values[:found].copy(), costs[:found].copy()


@njit(cache=True)
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
