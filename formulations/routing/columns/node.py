"""A node of the tree: the tours it still allows, its bound, and the work that raises it.

A node holds legs while its tours are too many to list, and a pool from then on. `tighten` solves the relaxation, fixes
legs or tours away by reduced cost, lists the tours when they fit, and cuts; it ends with the node's bound past the cap,
the relaxation solved by whole tours, or the node ready to be branched.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from formulations.routing.columns.cuts import Cut, separate
from formulations.routing.columns.enumeration import enumerate_tours
from formulations.routing.columns.fixing import fix_legs
from formulations.routing.columns.generation import Relaxation, generate
from formulations.routing.columns.labelling import Store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import Master
from formulations.routing.columns.pool import Pool, PoolPricer
from formulations.routing.columns.pricing import Column, Effort, Pricer, Prices

_WORTH_LISTING = 0.08  # gap, as a share of the cap, above which tours are not listed
_FIRST_ROOM = 1_000_000  # labels of the first attempt to list the tours; four times as many after each failure
_CUTS_A_ROUND = 50
_STALLED = 5e-4  # of the cap
_ROUNDS_STALLED = 3
_DIVE = 1.0  # seconds, at most, for the branch and bound over the columns of a node


class Efforts(NamedTuple):
    """How hard to work: `pricing` in the order to try, quick ones first; `thorough` to fix and list."""

    pricing: tuple[Effort, ...]
    thorough: Effort


@dataclass
class Workspace:
    """What all nodes share: clock, label store, limits, efforts and counters."""

    out_of_time: Callable[[], bool]
    store: Store
    tours_room: int
    plain: Efforts
    cutting: Efforts
    counts: dict[str, Any] = field(default_factory=dict)

    def count(self, what: str, by: int = 1) -> None:
        """Add to a counter of the statistics."""
        self.counts[what] = self.counts.get(what, 0) + by

    def efforts(self, node: Node) -> Efforts:
        """Return how hard to work at a node."""
        return self.cutting if node.cuts else self.plain

    def pricer(self, legs: Legs, cap: float, effort: Effort) -> Pricer:
        """Return a pricer of one effort."""
        return Pricer(legs, cap, effort, self.store, self.out_of_time)


@dataclass
class Node:
    """Tours allowed (`pool`, or `legs` where it is None), a valid `bound` [s], columns and cuts to start from.

    share : y_ki, how much of task i UAV k takes in the relaxation, shape (m, n); None unless ready to branch.
    routes : better routes found, tours by UAV, or None; without `share` they solve the relaxation itself.
    centre : the last relaxation solved here or above.
    room : labels to list the tours with next time.
    """

    legs: Legs
    bound: float
    columns: list[Column]
    cuts: tuple[Cut, ...] = ()
    centre: Relaxation | None = None
    pool: Pool | None = None
    room: int = _FIRST_ROOM
    share: NDArray[np.float64] | None = None
    routes: dict[int, Column] | None = None

    def may_visit(self) -> NDArray[np.bool_]:
        """Say which UAV may still take which task, shape (m, n)."""
        if self.pool is None:
            return self.legs.may_visit()
        columns = [self.pool.holds(i) for i in range(self.legs.n_tasks)]
        uavs = [self.pool.uav == k for k in range(self.legs.n_uavs)]
        return np.array([[bool((of_uav & holds).any()) for holds in columns] for of_uav in uavs])


def relax(node: Node, cap: float, work: Workspace) -> None:
    """Solve the node's relaxation once, for its bound and columns."""
    node.legs = node.legs.under(cap)
    master = _master(node, cap)
    relaxation = generate(master, _pricers(node, cap, work), cap, work.out_of_time)
    work.count("rounds", relaxation.rounds)
    node.centre = relaxation
    node.bound, node.columns = max(node.bound, relaxation.bound), list(master.columns)


def tighten(node: Node, cap: float, work: Workspace) -> None:
    """Raise the node's bound until it exceeds `cap`, `share` (ready to branch) or `routes` is set, or time is up."""
    node.share = node.routes = None
    node.legs = node.legs.under(cap)
    node.pool = None if node.pool is None else node.pool.under(cap)
    master = _master(node, cap)
    stalled = 0
    while True:
        relaxation = generate(master, _pricers(node, cap, work), cap, work.out_of_time, node.centre)
        stalled = stalled + 1 if relaxation.bound < node.bound + _STALLED * cap else 0
        node.bound = max(node.bound, relaxation.bound)
        work.count("rounds", relaxation.rounds)
        if node.bound > cap or work.out_of_time():
            return
        node.columns, node.centre = list(master.columns), relaxation
        if relaxation.solved:
            node.routes = _whole_tours(master, relaxation.weight)
            if node.routes is not None:
                return
        _reduce(node, relaxation, cap, work)
        cuts = separate([c.tasks for c in master.columns], relaxation.weight, master.n, set(master.cuts), _CUTS_A_ROUND)
        if not cuts or stalled >= _ROUNDS_STALLED:
            node.share = _shares(master, relaxation.weight)
            node.routes = _routes(master.whole(_DIVE) or [], master.n)
            return
        master.cut_off(cuts)
        node.cuts = tuple(master.cuts)
        work.count("cuts", len(cuts))


def _master(node: Node, cap: float) -> Master:
    """Return the restricted master of the node's columns; duals begin in a box of thrice a fair share."""
    master = Master(node.legs.n_tasks, node.legs.n_uavs, 3 * cap / node.legs.n_tasks, node.cuts)
    master.add([c for c in node.columns if c.cost <= cap])
    return master


def _pricers(node: Node, cap: float, work: Workspace) -> list[Prices]:
    if node.pool is not None:
        return [PoolPricer(node.pool)]
    return [work.pricer(node.legs, cap, effort) for effort in work.efforts(node).pricing]


def _reduce(node: Node, relaxation: Relaxation, cap: float, work: Workspace) -> None:
    """Fix legs or tours away at the duals of the relaxation; list the tours where they fit."""
    found = relaxation.duals, relaxation.bound, relaxation.least
    if node.pool is not None:
        node.pool = node.pool.needed(*found, cap)
        return
    gap = cap - relaxation.bound
    thorough = work.efforts(node).thorough
    node.legs = fix_legs(work.pricer(node.legs, cap, thorough), *found)
    if gap > _WORTH_LISTING * cap:
        return
    node.pool = enumerate_tours(work.pricer(node.legs, cap, thorough), *found, node.room, work.tours_room)
    work.count("pools" if node.pool is not None else "pools that did not fit")
    if node.pool is None:
        node.room *= 4


def _shares(master: Master, weight: NDArray[np.float64]) -> NDArray[np.float64]:
    share = np.zeros((master.m, master.n))
    for p in np.flatnonzero(weight > 1e-9):
        column = master.columns[p]
        share[column.uav, list(column.tasks)] += weight[p]
    return share


def _routes(tours: list[Column], n: int) -> dict[int, Column] | None:
    """Return the tours by UAV where they are routes: one a UAV, every task once."""
    routes = {column.uav: column for column in tours}
    visited = sorted(i for column in tours for i in column.tasks)
    return routes if len(routes) == len(tours) and visited == list(range(n)) else None


def _whole_tours(master: Master, weight: NDArray[np.float64]) -> dict[int, Column] | None:
    """Return a tour for each UAV in use where no task is shared, else None.

    Then the tours in use of one UAV visit the same tasks; only the cheapest of them counts.
    """
    share = _shares(master, weight)
    if np.abs(share - share.round()).max() > 1e-6 or not np.array_equal(share.round().sum(axis=0), np.ones(master.n)):
        return None
    routes: dict[int, Column] = {}
    for p in np.flatnonzero(weight > 1e-6):
        column = master.columns[p]
        if column.uav not in routes or column.cost < routes[column.uav].cost:
            routes[column.uav] = column
    return routes
