"""`subset-dp`: Held–Karp over every subset of tasks per depot, then the best min-max partition. The oracle.

Three recursions over sets of tasks, none of which needs the triangle inequality or symmetry:

    f_k({j}, j) = c_kj,   f_k(S, j) = min_{i ∈ S∖j} f_k(S∖j, i) + c_ij     cheapest path k → … → j through S
    t_k(S)      = min_{j ∈ S} f_k(S, j) + c_jk,   t_k(∅) = 0               cheapest tour of UAV k over S
    g_1 = t_1,   g_k(S) = min_{R ⊆ S} max(g_{k−1}(S∖R), t_k(R))            best longest tour of UAVs 1..k

and the optimum is g_m(T) (paper, eqs. c_max and const1–const6). Where UAVs differ, c is that of UAV k, +∞ where it
cannot fly; where endurance is limited, t_k(S) = +∞ beyond L_k; g_m(T) = +∞ then proves that there are no routes. Where
costs change with time, f and t are earliest arrivals (``subset_dp_clocks.py``).

The first two are Held & Karp, "A dynamic programming approach to sequencing problems", J. SIAM 10 (1962), in 2ⁿn²
steps a depot; the third is a subset convolution in the semiring (min, max), 3ⁿ steps for each UAV but the first and the
last, done block by block over the low bits so that it stays in cache, and skipping blocks that cannot beat known
routes. Memory: 8·n·2ⁿ bytes for f, used again by every depot, and 8·2ⁿ for each t_k and g_k.

Floating point: a tour is a sum of at most n + 1 non-negative costs, so the recursion is within a relative
(n + 1)·2⁻⁵³ of the exact value; the bound reported is lowered by more than that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from typing import ClassVar, NamedTuple

import numpy as np

from formulations.limits import Limits
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.solver import Result
from formulations.routing.state_dp import LARGEST_TABLE, cheapest_chain, state_tour_table
from formulations.routing.stateless import stateless
from formulations.routing.subset_dp_clocks import Extend, arrivals, earliest_order, let_wait
from instances import Instance, Routes, Travel
from instances.arrays import Floats
from instances.kernels import njit
from instances.routes import ENDURANCE_ROUNDING

LARGEST = 22
"""Tasks beyond which the tables pass about a gigabyte and the partition a minute."""
LARGEST_WAITING = 14
"""Tasks beyond which take-off within a window, a recursion of its own for each set of tasks, takes a minute."""
WAITING_TOLERANCE = 1e-6
"""Share by which routes with waiting may be longer than the optimum they prove: take-offs are climbed to from below."""

_BLOCK_BITS = 5
_PATH_CHUNK = 1 << 17
_BLOCK_CHUNK = 16
_RELATIVE_ROUNDING = 1e-13  # > 2·(LARGEST + 1)·2⁻⁵³


@dataclass(frozen=True)
class SubsetDp(RecordedSolver):
    """Dynamic programming over all subsets: exact, n ≤ 22, time and memory known beforehand."""

    proves: ClassVar[bool] = True
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance", "time", "states", "window"})

    def accepts(self, instance: Instance) -> str | None:
        """Refuse instances whose tables do not fit."""
        n = instance.n_tasks
        if "window" in instance.axes and n > LARGEST_WAITING:
            return f"subset-dp takes at most {LARGEST_WAITING} tasks where take-off is within a window, not {n}"
        if n <= LARGEST:
            return self._states_fit(instance)
        need = 8 * Decimal(2) ** n * (n + 2 * instance.n_depots) / 10**9  # no float reaches 2 ** 1024
        return (
            f"subset-dp has a table of all 2^n subsets: at most {LARGEST} tasks, not {n} (that would be {need:.3g} GB)"
        )

    def _states_fit(self, instance: Instance) -> str | None:
        """Refuse states together with time, and more of them than fit."""
        if instance.travel is None or "states" not in instance.axes:
            return None
        if "time" in instance.axes:
            return "subset-dp takes states or costs that change with time, not both"
        entries = (1 << instance.n_tasks) * int((instance.travel.nodes < instance.n_tasks).sum())
        if entries <= LARGEST_TABLE:
            return None
        return f"subset-dp has a table of all subsets and states: {8e-9 * entries:.3g} GB here; it takes 1.2 GB"

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels."""
        if "states" in instance.axes:
            self.solve(_tiny_states(), limits=Limits(time=3600.0))
        cost = np.ones((5, 5)) - np.eye(5)
        tiny = Instance("warm-up", cost, 2, 3)
        if "time" in instance.axes:
            twice = Travel(np.stack([cost, cost])[None], np.zeros(3, dtype=np.int64), np.array([0.0, 1.0]))
            tiny = Instance.of_travel("warm-up", twice, 2)
            let_wait(tiny, 0, np.full(4, 3.0), np.inf, lambda: True)
        self.solve(tiny, limits=Limits(time=3600.0))

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Solve exactly; known routes only let blocks be skipped. Deterministic, so `seed` is not used."""
        instance = recorder.instance
        recorder.incumbent(_nearest_task_to_the_shortest_tour(stateless(instance)))
        tours = []
        for k in range(instance.n_depots):
            table = tour_table(instance, k, recorder)
            if table is None:
                return recorder.result("time", message="The clock ran out in the tables of tours.")
            tours.append(table)
        best = _partition_tables(tours, recorder)
        if best is None:
            return recorder.result("time", message="The clock ran out in the partition.")
        value = float(best[-1][-1])
        if math.isinf(value) and recorder.routes is None:
            return recorder.infeasible(subsets=1 << instance.n_tasks)
        if value < recorder.objective:
            recorder.incumbent(_recover(instance, tours, best))
        bound = min(value, recorder.objective) * (1 - _RELATIVE_ROUNDING)
        recorder.raise_bound(bound)
        if "window" in instance.axes and not recorder.objective <= bound * (1 + WAITING_TOLERANCE):
            return recorder.result("finished", message="Some flight shrinks too slowly with waiting to tell.")
        tolerance = max(2 * _RELATIVE_ROUNDING * recorder.objective, recorder.objective - bound)
        return recorder.result("proof", proved=True, tolerance=tolerance, subsets=1 << instance.n_tasks)


def _tiny_states() -> Instance:
    """Return an instance of two tasks with two states each, which compiles the kernels of states."""
    nodes = np.array([0, 0, 1, 1, 2, 3, 4])
    return Instance.of_travel("warm-up", Travel(np.ones((1, 1, 7, 7)), np.zeros(3, dtype=np.int64), nodes=nodes), 2)


def tour_table(instance: Instance, k: int, clock: Recorder | None = None) -> Floats | None:
    """Return t_k(S) [s] for every set S of tasks (bit i is task i), shape (2ⁿ,); None when the clock runs out.

    Sets that UAV k cannot fly, or not on one battery, have t_k(S) = +inf.
    """
    tour = (state_tour_table if "states" in instance.axes else _stateless_table)(instance, k, clock)
    if tour is not None and "window" in instance.axes:
        below, in_time = (np.inf, lambda: True) if clock is None else (clock.objective, lambda: clock.remaining > 0)
        return tour if let_wait(instance, k, tour, below, in_time) else None
    if tour is not None and instance.endurance is not None:
        tour[tour > instance.endurance[k] * (1 + ENDURANCE_ROUNDING)] = np.inf
    return tour


def _stateless_table(instance: Instance, k: int, clock: Recorder | None) -> Floats | None:
    """Return t_k(S) [s] whatever the endurance, by one state a task."""
    n, extend = instance.n_tasks, arrivals(instance, k) if "time" in instance.axes else _least_costs(instance, k)
    path = np.empty((1 << n, n))
    tour = np.zeros(1 << n)
    for low in range(1, 1 << n, _PATH_CHUNK):
        if clock is not None and clock.remaining <= 0:
            return None
        extend(low, min(low + _PATH_CHUNK, 1 << n), path, tour)
    return tour


def _least_costs(instance: Instance, k: int) -> Extend:
    """Return what fills f (2ⁿ, n) and t (2ⁿ,) [s] of UAV k for the sets low..high−1, those before being filled."""
    n, c = instance.n_tasks, instance.uav_cost(k)
    to_task, home = c[n + k, :n].copy(), c[:n, n + k].copy()
    between = np.ascontiguousarray(c[:n, :n].T)
    return lambda low, high, path, tour: _extend_paths(low, high, to_task, between, home, path, tour)


@njit(cache=True)
def _extend_paths(
    low: int, high: int, to_task: Floats, between: Floats, home: Floats, path: Floats, tour: Floats
) -> None:
    """Fill f and t of the sets low..high−1; every subset of a set has a smaller number. between[j, i] = c_ij."""
    n = to_task.size
    members = np.empty(n, np.int64)
    for s in range(low, high):
        size = 0
        for j in range(n):
            if s >> j & 1:
                members[size] = j
                size += 1
        best_tour = np.inf
        for a in range(size):
            j = members[a]
            if size == 1:
                best = to_task[j]
            else:
                best = np.inf
                before = path[s ^ (1 << j)]
                for b in range(size):
                    i = members[b]
                    if i != j:
                        best = min(best, before[i] + between[j, i])
            path[s, j] = best
            best_tour = min(best_tour, best + home[j])
        tour[s] = best_tour


class Blocks(NamedTuple):
    """A table over all sets of tasks, `value` (2ⁿ,), and the `least` of each block of 2^bits that share high bits."""

    value: Floats
    least: Floats
    bits: int

    @classmethod
    def of(cls, value: Floats) -> Blocks:
        """Cut a table into blocks."""
        bits = min(_BLOCK_BITS, value.size.bit_length() - 1)
        return cls(value, value.reshape(-1, 1 << bits).min(axis=1), bits)


def _partition_tables(tours: list[Floats], recorder: Recorder) -> list[Floats] | None:
    """Return g_1..g_m; entries not below the incumbent may be too high, and only g_m(T) is filled in g_m."""
    best = [tours[0]]
    for k in range(1, len(tours)):
        g = np.full(tours[0].size, np.inf)
        first, second, last = Blocks.of(best[-1]), Blocks.of(tours[k]), k == len(tours) - 1
        blocks = first.least.size
        for low in range(blocks - 1 if last else 0, blocks, _BLOCK_CHUNK):
            if recorder.remaining <= 0:
                return None
            _convolve(low, min(low + _BLOCK_CHUNK, blocks), first, second, recorder.objective, g)
        best.append(g)
    return best


@njit(cache=True)
def _convolve(low: int, high: int, first: Blocks, second: Blocks, cutoff: float, out: Floats) -> None:
    """out(S) = min_{R ⊆ S} max(first(S∖R), second(R)) for the blocks low..high−1.

    Pairs of blocks whose smallest entries reach the cutoff are skipped: no set of theirs is part of better routes.
    """
    bits, width, f, g = first.bits, 1 << first.bits, first.value, second.value
    for block in range(low, high):
        base = block << bits
        part = block
        while True:
            if max(first.least[block ^ part], second.least[part]) < cutoff:
                left, right = (block ^ part) << bits, part << bits
                for s in range(width):
                    best = out[base + s]
                    r = s
                    while True:
                        best = min(best, max(f[left + (s ^ r)], g[right + r]))
                        if r == 0:
                            break
                        r = (r - 1) & s
                    out[base + s] = best
            if part == 0:
                break
            part = (part - 1) & block


def _recover(instance: Instance, tours: list[Floats], best: list[Floats]) -> Routes:
    """Walk back from g_m(T): the part R of each UAV, then its cheapest order."""
    rest = tours[0].size - 1
    parts = [0] * len(tours)
    for k in range(len(tours) - 1, 0, -1):
        parts[k] = int(_best_part(rest, best[k - 1], tours[k]))
        rest ^= parts[k]
    parts[0] = rest
    sets = [[i for i in instance.tasks if part >> i & 1] for part in parts]
    return tuple(cheapest_order(instance, k, tasks) for k, tasks in enumerate(sets))


@njit(cache=True)
def _best_part(rest: int, first: Floats, second: Floats) -> int:
    """Return the R ⊆ rest that minimises max(first(rest∖R), second(R))."""
    best, arg, part = np.inf, rest, rest
    while True:
        value = max(first[rest ^ part], second[part])
        if value < best:
            best, arg = value, part
        if part == 0:
            return arg
        part = (part - 1) & rest


def cheapest_order(instance: Instance, k: int, tasks: list[int]) -> tuple[int, ...]:
    """Return `tasks` (at most 22 or so) in the order of UAV k's cheapest tour, by Held–Karp on these alone."""
    if not tasks:
        return ()
    if "states" in instance.axes:
        return cheapest_chain(instance, k, tasks)
    if "time" in instance.axes:
        return earliest_order(instance, k, tasks)
    depot = instance.n_tasks + k
    cost = instance.uav_cost(k)
    to_task, home = cost[depot, tasks], cost[tasks, depot]
    between = np.ascontiguousarray(cost[np.ix_(tasks, tasks)].T)
    path, tour = np.empty((1 << len(tasks), len(tasks))), np.zeros(1 << len(tasks))
    _extend_paths(1, 1 << len(tasks), to_task, between, home, path, tour)
    order, rest, following = [], (1 << len(tasks)) - 1, home
    while rest:
        members, before = [i for i in range(len(tasks)) if rest >> i & 1], path[rest]
        j = min(members, key=lambda i: float(before[i] + following[i]))
        order.append(tasks[j])
        rest, following = rest ^ 1 << j, between[j]
    return tuple(reversed(order))


def _nearest_task_to_the_shortest_tour(instance: Instance) -> Routes:
    """First routes, so that a run cut short has some: the shortest tour so far takes its cheapest next task."""
    routes: list[list[int]] = [[] for _ in instance.depots]
    spent = np.zeros(instance.n_depots)
    open_tasks = set(instance.tasks)
    while open_tasks:
        k = int(spent.argmin())
        depot = instance.n_tasks + k
        here = routes[k][-1] if routes[k] else depot
        cost = instance.cost if "time" in instance.axes else instance.uav_cost(k)
        task = min(open_tasks, key=lambda i: float(cost[here, i] + cost[i, depot]))
        spent[k] += cost[here, task]
        routes[k].append(task)
        open_tasks.remove(task)
    return tuple(tuple(route) for route in routes)
