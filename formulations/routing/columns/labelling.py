"""Forward labels: elementary paths from a depot, layer by layer, kept where they may still become a good tour.

A label is a set of visited tasks V, the last of them, and the least cost of getting there (for one V and last task the
cheaper path is better in every way, as in Held & Karp). Its reduced cost is σ·cost − gain, with gain = Σ_{i∈V} π_i less
ρ of every cut (see `cuts`) with two tasks in V. A label is dropped as soon as reduced cost plus completion bound (see
`completion`) reaches the threshold: no tour that begins so is wanted. `label_search` goes through the layers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.clocks import knot_at
from formulations.routing.columns.completion import bins_left
from formulations.routing.columns.courses import course_at, on_course
from formulations.routing.columns.cuts import half_held, paid_for
from formulations.routing.columns.label_search import Found, Orders, Subproblem, limit
from formulations.routing.columns.word_sets import clear, has, hashed, same
from instances.arrays import Floats, Ints
from instances.kernels import njit


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

    def depart(self, problem: Subproblem, threshold: float, free: int) -> int:
        """Make the labels of one task, from label `free` on, and return the next free one."""
        return int(_depart(problem, self, threshold, free))

    def expand(
        self, problem: Subproblem, threshold: float, low: int, high: int, free: int, room: int
    ) -> tuple[bool, int]:
        """Extend labels low..high−1 by every task; return whether `room` labels are too few, and the next free one."""
        full, free = _expand(problem, self, threshold, low, high, free, room)
        return full, free

    def keep_best(self, beam: int, begin: int, end: int) -> tuple[int, float]:
        """Keep the `beam` labels of smallest bound of a layer, in order; return its new end, the others' bound."""
        most = limit(self.bound, beam, begin, end)
        return int(_keep(self, beam, begin, end, most)), most

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


def make_store(n_tasks: int, room: int) -> Store:
    """Make room for `room` labels over `n_tasks` tasks."""
    slots = 1 << int(2 * room - 1).bit_length()
    visited, last = np.zeros((room, (n_tasks + 63) // 64), np.uint64), np.zeros(room, np.int16)
    cost, gain, bound = np.zeros(room), np.zeros(room), np.zeros(room)
    return Store(visited, last, cost, gain, bound, np.zeros(room, np.int32), np.full(slots, -1, np.int32))


@njit(cache=True, nogil=True)
def least_of_all(problem: Subproblem) -> float:
    """Return a lower bound on the reduced cost [s] of all tours: the best first leg and its completion."""
    least = np.inf
    for j in range(problem.price.size):
        least = min(least, _beginning_with(problem, j))
    return least


@njit(cache=True, nogil=True)
def _beginning_with(problem: Subproblem, task: int) -> float:
    """Return a lower bound on the reduced cost [s] of the tours whose first task is `task`, infinite past the cap."""
    spent = problem.legs.out[task]
    if not spent <= problem.cap:
        return np.inf
    nothing = np.zeros((problem.price.size + 63) // 64, np.uint64)
    state = memory_of(problem.memory.near, problem.watch.members, nothing, task)
    left = bins_left(problem.cap - spent, problem.bins)
    return problem.sigma * spent - problem.price[task] + problem.best[task, left, state]


@njit(cache=True, nogil=True, inline="always")
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


@njit(cache=True, nogil=True)
def _depart(problem: Subproblem, store: Store, threshold: float, free: int) -> int:
    """Make the labels of one task, from label `free` on, and return the next free one."""
    for j in range(problem.price.size):
        least = _beginning_with(problem, j)
        if least < threshold and problem.legs.out[j] <= problem.reach and free < store.last.size:
            for w in range(store.visited.shape[1]):
                store.visited[free, w] = np.uint64(0)
            store.visited[free, j >> 6] = np.uint64(1) << np.uint64(j & 63)
            store.last[free], store.parent[free] = j, -1
            store.cost[free], store.gain[free], store.bound[free] = problem.legs.out[j], problem.price[j], least
            free += 1
    return free


@njit(cache=True, nogil=True)
def _expand(
    problem: Subproblem, store: Store, threshold: float, low: int, high: int, free: int, room: int
) -> tuple[bool, int]:
    """Extend the labels low..high−1 by every task; return whether `room` labels are too few, and the next free one."""
    courses, order, degree, cap = problem.bins.courses, problem.bins.order, problem.bins.degree, problem.cap
    reach, price, sigma, best, bins = problem.reach, problem.price, problem.sigma, problem.best, problem.bins
    bits, prices, near, members = problem.cuts.bits, problem.cuts.prices, problem.memory.near, problem.watch.members
    half = np.empty(bits.shape[1], np.uint64)
    mask, nothing_seen = store.slots.size - 1, problem.least
    for label in range(low, high):
        here, seen = store.last[label], store.visited[label]
        fresh, time = seen.copy(), store.cost[label]
        half_held(seen, bits, half)
        knot = knot_at(courses, time)
        since = time - courses.knots[knot]
        most = bins_left(reach - time, bins)
        for a in range(degree[here]):
            j = order[here, a]
            if bins.fewest[here, j] > most:
                break
            spent = (time + on_course(courses, here, j, knot, since)) * courses.rounded
            if has(seen, j) or not spent <= reach:
                continue
            earned = store.gain[label] + price[j]
            left = bins_left(cap - spent, bins)
            if sigma * spent - earned + nothing_seen[j, left] >= threshold:  # with nothing remembered: most end here
                continue
            earned -= paid_for(half, bits[j], prices)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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
