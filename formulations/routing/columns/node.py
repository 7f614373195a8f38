"""A node of the tree: the tours it still allows, its bound, and the work that raises it.

A node holds the legs of a UAV while its tours are too many to list, and lists them in its pool from then on. `tighten`
solves the relaxation, fixes legs or tours away by reduced cost, lists the tours when they fit, and cuts; it ends with
the node's bound past the cap, the relaxation solved by whole tours, or the node ready to be branched.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from formulations.routing.columns.branching import ALONE, choose, shares
from formulations.routing.columns.cuts import Cut, separate
from formulations.routing.columns.enumeration import list_tours
from formulations.routing.columns.fixing import fix_legs
from formulations.routing.columns.generation import Relaxation, generate
from formulations.routing.columns.labelling import Store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.master import Master
from formulations.routing.columns.pool import MixedPricer, Pool, PoolPricer
from formulations.routing.columns.pricing import Column, Effort, Pricer, Prices
from instances.arrays import Bools, Floats

_WORTH_LISTING = 0.08  # gap, as a share of the cap, above which tours are not listed, nor cuts sought
_FIRST_ROOM = 1_000_000  # labels of the first attempt to list the tours; four times as many after each failure
_CUTS_A_ROUND = 50
_STALLED = 0.05  # of the gap: cuts that close less of it
_ROUNDS_STALLED = 2
_DEAR = 0.15  # the same where some tours are not listed, so that pricing is dear: then one such round is enough
_RETRY = 0.8  # of the gap at the last list that did not fit
_REFIX = 0.9  # of the gap at which legs were fixed last
_USED = 1e-6  # weight of a tour
_DIVE = 1.0  # seconds, at most, for the branch and bound over the columns of a node


class Efforts(NamedTuple):
    """How hard to work: `pricing` in the order to try, quick ones first; `thorough` to fix and list."""

    pricing: tuple[Effort, ...]
    thorough: Effort


@dataclass
class Workspace:
    """What all nodes share: clock, label store, limits, efforts and counters.

    far : the cheapest way to each task and back [s].
    better : asked after every relaxation: searches on for better routes, and says whether there are any. It is told
        the tour, if there is one, that alone makes the relaxation as long as it is: routes with it may be optimal.
    """

    out_of_time: Callable[[], bool]
    store: Store
    tours_room: int
    plain: Efforts
    cutting: Efforts
    far: Floats
    better: Callable[[Column | None], bool] = lambda _: False
    counts: dict[str, Any] = field(default_factory=dict)

    def count(self, what: str, by: int = 1) -> None:
        """Add to a counter of the statistics."""
        self.counts[what] = self.counts.get(what, 0) + by

    def efforts(self, cuts: Sequence[Cut]) -> Efforts:
        """Return how hard to work at a node with these cuts."""
        return self.cutting if cuts else self.plain

    def pricer(self, legs: Legs, cap: float, effort: Effort) -> Pricer:
        """Return a pricer of one effort."""
        return Pricer(legs, cap, effort, self.store, self.out_of_time)


@dataclass
class Node:
    """Tours allowed (by `legs`, or in `pool` where a UAV is listed), a valid `bound` [s], columns and cuts to start.

    ready : whether to branch next, on UAV and task `branch`; None where all tasks are decided.
    routes : better routes found, tours by UAV, or None; unless `ready` they solve the relaxation itself.
    listing_failed : gap [s] at which the tours did not fit a list.
    fixed_at : gap [s] at which legs were fixed away last, here or above.
    centre : the last relaxation solved here or above.
    room : labels to list the tours with next time.
    """

    legs: Legs
    bound: float
    columns: list[Column]
    pool: Pool
    cuts: tuple[Cut, ...] = ()
    centre: Relaxation | None = None
    room: int = _FIRST_ROOM
    listing_failed: float = np.inf
    fixed_at: float = np.inf
    ready: bool = False
    branch: tuple[int, int] | None = None
    routes: dict[int, Column] | None = None

    def may_visit(self) -> Bools:
        """Say which UAV may still take which task, shape (m, n)."""
        return np.where(self.pool.listed[:, None], self.pool.may_visit(self.legs.n_tasks), self.legs.may_visit())


def tighten(node: Node, cap: float, work: Workspace) -> bool:
    """Raise the node's bound until it exceeds `cap`, it is `ready` to branch, `routes` are found, or time is up.

    Return False where it ended before that, because better routes were found elsewhere.
    """
    node.ready, node.routes = False, None
    node.legs = node.legs.under(cap)
    node.pool = node.pool.under(cap)
    master = restricted_master(node, cap)
    stalled, dived = 0, node.centre is not None
    while True:
        gap = cap - node.bound
        relaxation = generate(master, _pricers(node, master, cap, work), cap, work.out_of_time, node.centre)
        raised = relaxation.bound - node.bound
        stalled = stalled + 1 if raised < _STALLED * gap else 0
        node.bound = max(node.bound, relaxation.bound)
        work.count("rounds", relaxation.rounds)
        node.columns = list(master.columns)
        if node.bound > cap or work.out_of_time():
            return True
        if not relaxation.solved and len(master.cuts) > len(node.cuts):  # so many cuts that pricing is lost
            return _prepare_branching(node, cap, work)
        node.cuts, node.centre = tuple(master.cuts), relaxation
        if relaxation.solved:
            node.routes = _whole_tours(master, relaxation.weight)
            if node.routes is not None:
                return True
        if work.better(longest_of_all(master, relaxation)):
            return False
        if not dived:
            dived, node.routes = True, _routes(master.whole(_DIVE) or [], master.n)
            if node.routes is not None and max(c.cost for c in node.routes.values()) <= cap:
                return True
        _reduce(node, relaxation, cap, work)
        cuts = separate([c.tasks for c in master.columns], relaxation.weight, master.n, set(master.cuts), _CUTS_A_ROUND)
        wide = cap - relaxation.bound > _WORTH_LISTING * cap  # then a branch does more than cuts, and sooner
        dear = not node.pool.complete and raised < _DEAR * gap
        if not cuts or wide or dear or stalled >= _ROUNDS_STALLED:
            return _prepare_branching(node, cap, work)
        master.cut_off(cuts)
        work.count("cuts", len(cuts))


def _prepare_branching(node: Node, cap: float, work: Workspace) -> bool:
    """Choose the branch, and look for routes among the columns."""
    _lighten(node, cap)
    master = restricted_master(node, cap)
    node.branch = choose(master, node.may_visit(), work.far, cap - node.bound, work.out_of_time)
    node.ready = True
    node.routes = _routes(master.whole(_DIVE) or [], master.n)
    return True


def _lighten(node: Node, cap: float) -> None:
    """Drop cuts that nothing pays for, and columns that better routes cannot use."""
    centre = node.centre
    if centre is None:
        return
    duals = centre.duals.paid()
    node.cuts, node.centre = duals.cuts, replace(centre, duals=duals)
    values, uav = duals.values(node.columns), np.array([c.uav for c in node.columns], dtype=np.int64)
    needed = values <= cap - centre.bound + centre.least[uav]
    node.columns = [node.columns[p] for p in np.flatnonzero(needed)]


def restricted_master(node: Node, cap: float) -> Master:
    """Return the restricted master of the node's columns.

    Duals begin in a box of thrice a fair share, or twice what they were above.
    """
    box = np.full(node.legs.n_tasks, 3 * cap / node.legs.n_tasks)
    if node.centre is not None:
        box = np.maximum(box, 2 * np.abs(node.centre.duals.price))
    master = Master(node.legs.n_tasks, node.legs.n_uavs, box, node.cuts)
    master.add([c for c in node.columns if c.cost <= cap])
    return master


def _pricers(node: Node, master: Master, cap: float, work: Workspace) -> list[Prices]:
    listed = PoolPricer(node.pool)
    if node.pool.complete:
        return [listed]
    efforts = work.efforts(master.cuts).pricing
    return [MixedPricer(listed, work.pricer(node.legs, cap, effort)) for effort in efforts]


def _reduce(node: Node, relaxation: Relaxation, cap: float, work: Workspace) -> None:
    """Fix legs or tours away at the duals of the relaxation; list the tours where they fit."""
    found = relaxation.duals, relaxation.bound, relaxation.least
    node.pool = node.pool.needed(*found, cap)
    others = np.flatnonzero(~node.pool.listed)
    if others.size == 0:
        return
    gap = cap - relaxation.bound
    thorough = work.efforts(node.cuts).thorough
    if gap < _REFIX * node.fixed_at:
        node.legs, node.fixed_at = fix_legs(work.pricer(node.legs, cap, thorough), others, *found), gap
    if gap > min(_WORTH_LISTING * cap, _RETRY * node.listing_failed):
        return
    pricer = work.pricer(node.legs, cap, thorough)
    node.pool, in_vain = list_tours(node.pool, pricer, *found, node.room, work.tours_room)
    if node.pool.complete:
        work.count("pools")
    else:
        work.count("labels in vain", in_vain)
        node.room, node.listing_failed = 4 * node.room, gap


def longest_of_all(master: Master, relaxation: Relaxation) -> Column | None:
    """Return the tour most used by the UAV that sets the relaxation nearly alone; None where several do."""
    k = int(np.argmax(relaxation.duals.sigma))
    used = [p for p in np.flatnonzero(relaxation.weight > _USED) if master.columns[p].uav == k]
    if relaxation.duals.sigma[k] < ALONE or not used:
        return None
    return master.columns[max(used, key=lambda p: float(relaxation.weight[p]))]


def _routes(tours: list[Column], n: int) -> dict[int, Column] | None:
    """Return the tours by UAV where they are routes: one a UAV, every task once."""
    routes = {column.uav: column for column in tours}
    visited = sorted(i for column in tours for i in column.tasks)
    return routes if len(routes) == len(tours) and visited == list(range(n)) else None


def _whole_tours(master: Master, weight: Floats) -> dict[int, Column] | None:
    """Return a tour for each UAV in use where no task is shared, else None.

    Then the tours in use of one UAV visit the same tasks; only the cheapest of them counts.
    """
    share = shares(master, weight)
    if np.abs(share - share.round()).max() > 1e-6 or not np.array_equal(share.round().sum(axis=0), np.ones(master.n)):
        return None
    routes: dict[int, Column] = {}
    for p in np.flatnonzero(weight > 1e-6):
        column = master.columns[p]
        if column.uav not in routes or column.cost < routes[column.uav].cost:
            routes[column.uav] = column
    return routes
