"""Travel: what a leg costs where one matrix does not suffice.

A leg leads from state s to state s', is flown by a UAV of class g, and begins at time t:

    c(g, t, s, s')   linear in t between the knots `departures`, constant after the last

so that three extensions of the paper are one array: UAVs that differ ("fleet", G > 1), costs that change with the
clock ("time", Q > 1) and several states at one node, such as headings ("states", S > N). The paper's problem is
G = Q = 1, S = N. An infinite cost says that a class cannot fly a leg.

The clock must be the cost: "first in, first out", c(t') + t' ≥ c(t) + t for t' > t, is checked, because only then is
the earliest arrival at a node always the best one (Held–Karp and every search rely on it).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from instances.arrays import Floats, Ints
from instances.errors import InputError, shown

MOST_ENTRIES = 400_000_000
"""Most entries of a cost array: it then fills 3.2 GB, as the largest instance does."""
ROUNDING = 1e-9
"""Share by which costs may break first in, first out: floating-point rounding of whoever made them."""

AXES = {
    "metric": "costs by a metric, too many for a matrix",
    "fleet": "UAVs that differ",
    "endurance": "limited endurance",
    "time": "costs that change with time",
    "states": "several states at a node",
    "window": "take-off within a window",
}
"""What an instance can have beyond one matrix of costs, in words."""


def _nothing() -> Floats:
    return np.zeros(1)


@dataclass(frozen=True, eq=False)
class Travel:
    """What each leg costs each class of UAV at each time. Equal classes are merged, in the order of the UAVs.

    Parameters
    ----------
    cost
        Shape (G, Q, S, S) [s], ≥ 0, +inf where a class cannot fly a leg; zero diagonal where each node has one state.
    classes
        Shape (m,): the class of each UAV, each below G.
    departures
        Shape (Q,) [s]: knots of time, from 0, increasing.
    nodes
        Shape (S,): the node of each state, each from 0 to N-1 once or more; one state a node if left out.
    closed
        Whether a tour ends in the state of its depot that it began in; else it may end in another.
    window
        Longest wait before take-off [s], ≥ 0: it may keep a flight within endurance (``instances/take_off.py``).
        Where it is above 0, each node has one state.

    Raises
    ------
    InputError
        With one sentence that names the entry; for first in, first out also leg and knot.
    """

    cost: Floats
    classes: Ints
    departures: Floats = field(default_factory=_nothing)
    nodes: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    closed: bool = False
    window: float = 0.0

    def __post_init__(self) -> None:
        cost = _checked_cost(self.cost)
        n_classes, n_knots, n_states, _ = cost.shape
        classes = whole(self.classes, "travel.classes")
        if not len(classes) or classes.min() < 0 or classes.max() >= n_classes:
            raise InputError(f"travel.classes must be numbers from 0 to {n_classes - 1}, got {shown(classes.tolist())}")
        departures = _checked_departures(self.departures, n_knots)
        nodes = whole(self.nodes if len(self.nodes) else np.arange(n_states), "travel.nodes")
        if len(nodes) != n_states or not np.array_equal(np.unique(nodes), np.arange(nodes.max(initial=-1) + 1)):
            raise InputError(
                f"travel.nodes must name the node of each of the {n_states} states, each node once or more"
            )
        order = np.argsort(nodes, kind="stable")
        if not np.array_equal(order, np.arange(n_states)):
            cost, nodes = cost[:, :, order][:, :, :, order], nodes[order]
        if nodes[-1] + 1 == n_states and (loops := np.diagonal(cost, axis1=2, axis2=3)).any():
            g, q, i = np.argwhere(loops)[0]
            raise InputError(f"travel.cost[{g}][{q}][{i}][{i}] must be 0 (the diagonal), got {loops[g, q, i]}")
        object.__setattr__(self, "window", _checked_window(self.window, n_states > nodes[-1] + 1))
        _check_fifo(cost, departures)
        cost, classes = _merged(cost, classes)
        for name, array in (("cost", cost), ("classes", classes), ("departures", departures), ("nodes", nodes)):
            kept = np.ascontiguousarray(array)
            kept.setflags(write=False)
            object.__setattr__(self, name, kept)

    def __reduce__(self) -> tuple[type[Travel], tuple[Any, ...]]:
        """Pickle through the constructor: arrays are read-only again on the other side, which kernels mind."""
        return Travel, (self.cost, self.classes, self.departures, self.nodes, self.closed, self.window)

    @classmethod
    def of_uavs(cls, costs: Sequence[Floats]) -> Travel:
        """Return the travel of a fleet: a matrix (N, N) [s] for each UAV; equal ones become one class."""
        return cls(np.stack(costs)[:, None], np.arange(len(costs)))

    @property
    def n_nodes(self) -> int:
        """Number of nodes N."""
        return int(self.nodes[-1]) + 1

    @cached_property
    def axes(self) -> frozenset[str]:
        """Which of "fleet" (classes, or legs that cannot be flown), "time" and "states" there are."""
        n_classes, n_knots, n_states, _ = self.cost.shape
        there = {
            "fleet": n_classes > 1 or not np.isfinite(self.cost).all(),
            "time": n_knots > 1,
            "states": n_states > self.n_nodes,
        }
        return frozenset(axis for axis, is_there in there.items() if is_there)

    def least(self) -> Floats:
        """Return the least cost of each leg over classes, knots and states, (N, N) [s]: no flight of it takes less.

        A leg that no class can fly takes the greatest finite cost, so that whoever reads the matrix as numbers
        (pictures, neighbours, bounds) need not know of infinities; no flight of it exists that this could exceed.
        """
        starts = np.searchsorted(self.nodes, np.arange(self.n_nodes))
        least = self.cost.min(axis=(0, 1))
        least = np.minimum.reduceat(np.minimum.reduceat(least, starts, axis=0), starts, axis=1)
        flown = np.isfinite(least)
        least[~flown] = least[flown].max(initial=0.0)
        np.fill_diagonal(least, 0.0)
        return least

    def tour_cost(self, uav: int, stops: Ints, take_off: float = 0.0) -> float:
        """Return C_k [s] of UAV `uav` along `stops` (depot, tasks, depot): earliest arrival over chains of states.

        It departs at `take_off` [s], which counts where costs change with time.
        """
        cost = self.cost[self.classes[uav]]
        if not self.axes & {"time", "states"}:
            return float(cost[0, stops[:-1], stops[1:]].sum())
        first, after = (np.searchsorted(self.nodes, stops, side=side) for side in ("left", "right"))
        starts = np.full((1, after[0] - first[0]), take_off)
        if self.closed:
            starts = np.where(np.eye(starts.size, dtype=bool), take_off, np.inf)
        ends = np.empty_like(starts)
        for k, arrival in enumerate(starts):
            for here in range(len(stops) - 1):
                legs = cost[:, first[here] : after[here], first[here + 1] : after[here + 1]]
                arrival = (arrival[:, None] + self._at(legs, arrival)).min(axis=0)
            ends[k] = arrival
        return float(np.diagonal(ends).min() if self.closed else ends.min())

    def _at(self, legs: Floats, times: Floats) -> Floats:
        """Return the costs (from, to) [s] of `legs` (Q, from, to) begun at `times` (from,)."""
        knot = np.clip(np.searchsorted(self.departures, times, side="right") - 1, 0, len(self.departures) - 1)
        rows = np.arange(len(times))
        before = legs[knot, rows]
        if len(self.departures) == 1:
            return before
        following = np.minimum(knot + 1, len(self.departures) - 1)
        span = np.where(following > knot, self.departures[following] - self.departures[knot], 1.0)
        share = np.where(np.isfinite(times), (times - self.departures[knot]) / span, 0.0) * (following > knot)
        with np.errstate(invalid="ignore"):
            between = before + share[:, None] * (legs[following, rows] - before)
        return np.where(share[:, None] > 0, np.where(np.isnan(between), np.inf, between), before)


def whole(value: Any, label: str) -> Ints:
    """Return a list of whole numbers as an array; InputError names it."""
    try:
        numbers = np.array(value)
    except (TypeError, ValueError, OverflowError):
        numbers = np.empty(0)
    if numbers.ndim != 1 or numbers.dtype.kind not in "iu":
        raise InputError(f"{label} must be a list of whole numbers, got {shown(value)}")
    return numbers.astype(np.int64)


def _checked_cost(cost: Any) -> Floats:
    try:
        c = np.array(cost, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError("travel.cost must be an array of numbers (classes, knots, states, states)") from None
    if c.ndim != 4 or c.shape[2] != c.shape[3] or 0 in c.shape:
        raise InputError(f"travel.cost must have shape (classes, knots, states, states), got {c.shape}")
    if c.size > MOST_ENTRIES:
        raise InputError(f"travel.cost has {c.size} entries; it can have {MOST_ENTRIES}")
    for bad, what in ((np.isnan(c), "not a number"), (c < 0, "negative")):
        if bad.any():
            g, q, i, j = np.argwhere(bad)[0]
            raise InputError(f"travel.cost[{g}][{q}][{i}][{j}] is {what} ({c[g, q, i, j]})")
    return c


def _checked_departures(departures: Any, n_knots: int) -> Floats:
    try:
        t = np.array(departures, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError("travel.departures must be a list of times [s]") from None
    rising = t.shape == (n_knots,) and np.isfinite(t).all() and t[0] == 0 and (np.diff(t) > 0).all()
    if not rising:
        raise InputError(
            f"travel.departures must be {n_knots} increasing times [s] from 0, one a knot, got {shown(t.tolist())}"
        )
    return t


def _checked_window(window: Any, several_states: bool) -> float:
    number = isinstance(window, int | float | np.integer | np.floating) and not isinstance(window, bool)
    if not number or not 0 <= window < np.inf:
        raise InputError(f"travel.window must be a time [s] of at least 0, got {shown(window)}")
    if window > 0 and several_states:
        raise InputError(f"travel.window is {shown(window)}, which wants one state a node; travel.nodes has several")
    return float(window)


def _check_fifo(cost: Floats, departures: Floats) -> None:
    """Raise InputError where a later departure arrives earlier; infinite costs may begin, but not end."""
    for q, step in enumerate(np.diff(departures)):
        with np.errstate(invalid="ignore"):
            slack = cost[:, q + 1] + step - cost[:, q]
        slack[np.isinf(cost[:, q]) & np.isinf(cost[:, q + 1])] = 0.0
        bad = slack < -ROUNDING * np.minimum(cost[:, q], np.finfo(float).max)
        if bad.any():
            g, i, j = np.argwhere(bad)[0]
            raise InputError(
                f"travel.cost[{g}]: the leg from state {i} to state {j} takes {cost[g, q, i, j]} s at knot {q} and "
                f"{cost[g, q + 1, i, j]} s at knot {q + 1}, {step} s later: who departs later would arrive earlier"
            )


def _merged(cost: Floats, classes: Ints) -> tuple[Floats, Ints]:
    """Return costs and classes without unused and equal ones, numbered in the order of the UAVs."""
    kept: list[int] = []
    number: dict[int, int] = {}
    for g in dict.fromkeys(classes.tolist()):
        same = next((k for k, other in enumerate(kept) if np.array_equal(cost[g], cost[other])), len(kept))
        if same == len(kept):
            kept.append(g)
        number[g] = same
    return cost[kept], np.array([number[g] for g in classes.tolist()], dtype=np.int64)
