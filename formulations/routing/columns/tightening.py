"""Tightening a node: the work that raises its bound, and what can come of it.

The relaxation is solved by column generation; legs or tours are fixed away by reduced cost, and the tours listed when
they fit; then it is cut and solved again. While they do not fit, exact pricing takes most of the time: before the next,
more cuts are asked for where tours are short, of relaxations solved by the quickest pricer alone, which give no
bounds. What ends this is one of the outcomes below; the tree decides what follows.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from formulations.routing.columns.branching import choose
from formulations.routing.columns.cuts import Cut, separate
from formulations.routing.columns.exempting import sole_bottleneck
from formulations.routing.columns.fixing import fix_as_worth
from formulations.routing.columns.generation import Ended, Relaxation, generate
from formulations.routing.columns.master import Master
from formulations.routing.columns.node import Hint, Node, Workspace
from formulations.routing.columns.pool import PoolPricer, list_tours
from formulations.routing.columns.pricing import Column, DualBound, Duals, Prices
from formulations.routing.columns.walks import relax_by_walks
from instances import Routes
from instances.arrays import Floats

_WORTH_LISTING = 0.08  # gap, as a share of the cap, above which tours are not listed, nor cuts sought
_QUICK_ROOM = 2_000_000  # labels of a UAV to list its tours with while cuts raise the bound: lists shrink with the gap
_MORE_ROOM = 4  # times the labels, after an attempt to list the tours that failed where cuts did no more
_CUTS_A_ROUND = 50
_ROUGH_ROUNDS = 2  # of cuts before each exact pricing where some tours are not listed
_ROUGH_UP_TO = 12  # tasks a UAV: with so many cuts at once pricing of longer tours loses labels
_STALLED = 0.05  # of the gap: cuts that close less of it
_ROUNDS_STALLED = 2
_DEAR = 0.1  # the same where some tours are not listed, so that pricing is dear: then one such round is enough
_HASTY = 0.5  # the same where a node is left then, as it is
_LONG = 15  # tasks a UAV above which labels that pay for cuts cost more than branches, and far-off duals lose labels
_RETRY = 0.8  # of the gap at the last list that did not fit
_REFIX = 0.9  # of the gap at which legs were fixed last
_FEW, _MANY = 100_000, 4  # tours of a pool in which columns are looked for first, and how many times more there must be
_USED = 1e-6  # weight of a tour
_MUCH = 0.2  # price σ_k of a UAV around whose tour routes are searched for
_DIVE = 1.0  # seconds, at most, for the branch and bound over the columns of a node


@dataclass(frozen=True)
class Pruned:
    """No routes of cost ≤ cap are left in the node."""


@dataclass(frozen=True)
class Improved:
    """`routes` of cost ≤ cap were found; the node is to be looked at again, under the cap they set."""

    routes: Routes


@dataclass(frozen=True)
class Branch:
    """All else is done: branch on whether `uav` takes `task`. `routes` were found by the way, or None."""

    uav: int
    task: int
    routes: Routes | None


@dataclass(frozen=True)
class Stuck:
    """Every task is decided, but the tours left are too many for the label store. `routes` as in `Branch`."""

    routes: Routes | None


@dataclass(frozen=True)
class Interrupted:
    """Time is up; the node's bound holds as far as it got."""


@dataclass(frozen=True)
class Overtaken:
    """The search beside the tree has lowered the cap: the node is to be taken up again, and counts only then."""


@dataclass(frozen=True)
class Dear:
    """Only dear pricing or a branch would go on here: lower caps may do more (`Workspace.hasty`)."""


Outcome = Pruned | Improved | Branch | Stuck | Interrupted | Overtaken | Dear


def tighten(node: Node, cap: float, work: Workspace) -> Outcome:
    """Raise the node's bound until it passes `cap` [s], routes are found, or nothing but branching helps."""
    dived, near = node.centre is not None, _begin(node, cap, work)
    if node.bound > cap:
        return Pruned()
    master, stalled, rounds = node.restricted_master(cap, near=near), 0, 0
    # not of the node's bound, which in trees under lower caps is known from outside
    level = -np.inf if node.centre is None else node.centre.value

    while True:
        gap = cap - level
        relaxation = _relax(node, master, near, cap, work)
        best, raised = relaxation.best, relaxation.best.value - level
        stalled = stalled + 1 if raised < _STALLED * gap else 0
        level = best.value
        if (ended := _ended(node, master, relaxation, cap, work)) is not None:
            return ended
        if not dived and (routes := _dive(master, work)) is not None:
            return Improved(routes)
        dived, listed = True, node.pool.listed
        _reduce(node, best, cap, work)
        cuts = _violated(master, relaxation.weight)
        wide = cap - best.value > _WORTH_LISTING * cap  # then a branch does more than cuts, and sooner
        alone = sole_bottleneck(master, best.duals, relaxation.weight) if rounds > 0 or wide or not cuts else None
        if alone is not None:
            work.log.put_aside(node.number, best, node.pool.listed & ~listed)
            node.exempt_cost_of(alone, level)
            master, near, stalled, rounds, level = node.restricted_master(cap), None, 0, 0, -np.inf
            continue
        if work.hasty and rounds > 0 and not node.pool.complete and raised < _HASTY * gap:
            work.log.put_aside(node.number, best, node.pool.listed & ~listed)
            return Dear()
        # what the first relaxation rises above the one before is the branch's doing, and says nothing of cuts
        dull = rounds > 0 and raised < _DEAR * gap
        dear = not node.pool.complete and (dull or master.n > _LONG * master.m)
        done = wide or not cuts or stalled >= _ROUNDS_STALLED or (dear and not _list_at_last(node, best, cap, work))
        work.log.put_aside(node.number, best, node.pool.listed & ~listed)
        if done:
            return _branch(node, cap, work)
        _cut(node, master, cuts, cap, work)
        rounds += 1


def _begin(node: Node, cap: float, work: Workspace) -> Duals | None:
    """Drop the tours beyond `cap`; raise the bound above it where a task is lost with them, else by walks if asked.

    A node taken up again goes on with the columns that routes under this cap may still use.

    Return duals that those of long tours are near: of the relaxation above, else of one over walks; else None.
    """
    node.legs, node.pool = node.legs.under(cap), node.pool.under(cap)
    lost = np.flatnonzero(~node.may_visit().any(axis=0))
    if lost.size > 0:
        node.raise_bound(DualBound.of_lost_task(int(lost[0]), node.legs.n_uavs, node.legs.n_tasks, cap))
        return None
    if node.centre is not None:
        node.lighten(cap)
        return node.centre.duals if node.legs.n_tasks > _LONG * node.legs.n_uavs else None
    if work.walks is None:
        return None
    walked = relax_by_walks(work.pricer(node.legs, cap, work.walks), node.kinds, node.columns)
    node.columns = walked.tours
    work.counts["rounds"] += walked.rounds
    node.raise_bound(walked.best)
    return walked.best.duals


def _relax(node: Node, master: Master, near: Duals | None, cap: float, work: Workspace) -> Relaxation:
    """Generate columns until the master is solved or what ends it comes first; the node keeps them, and its bound."""
    pricers = _pricers(node, master, cap, work)
    relaxation = generate(
        master, pricers, cap, work.time_left, node.centre, _reserve(node), near,
        lambda at, in_vain: work.meanwhile(max(node.level, at.value), in_vain),
    )  # fmt: skip
    node.raise_bound(relaxation.best)
    node.columns = list(master.columns)
    work.counts["rounds"] += relaxation.rounds
    return relaxation


def _ended(node: Node, master: Master, relaxation: Relaxation, cap: float, work: Workspace) -> Outcome | None:
    """Return what a relaxation comes to by itself, None where the work goes on; the node keeps its cuts and duals."""
    best, ended = relaxation.best, relaxation.ended
    if ended is Ended.PRUNED:
        return Pruned()
    if ended is Ended.OVERTAKEN:
        return Overtaken()
    if ended is Ended.INTERRUPTED or work.time_left() <= 0:
        return Interrupted()
    if ended is Ended.STUCK and len(master.cuts) > len(node.cuts):  # too many cuts to price with
        return _branch(node, cap, work)
    node.cuts, node.centre = tuple(master.cuts), best
    routes = _whole_tours(master, relaxation.weight) if ended is Ended.SOLVED else None
    if routes is not None:
        return Improved(routes)
    return Overtaken() if work.better(hint(master, best, relaxation.weight, node.level)) else None


def _branch(node: Node, cap: float, work: Workspace) -> Branch | Stuck:
    """Choose the branch, and look for routes among the columns."""
    node.lighten(cap)
    master = node.restricted_master(cap, apart=True)
    if master.m > 1 and len(node.alike(0)) == master.m:  # whoever takes the task farthest out may be called the first
        return Branch(0, int(np.argmax(work.far)), _dive(master, work))
    rise = cap - (node.bound if node.centre is None else node.centre.value)
    pair = choose(master, node.may_visit(), work.far, rise, work.time_left)
    routes = _dive(master, work)
    return Stuck(routes) if pair is None else Branch(*pair, routes)


def _cut(node: Node, master: Master, cuts: Sequence[Cut], cap: float, work: Workspace) -> None:
    """Add the cuts, and those that the relaxation solved roughly asks for then: all of them are priced exactly once."""
    _add(master, cuts, work)
    roughly = not node.pool.complete and master.n <= _ROUGH_UP_TO * master.m
    for _ in range(_ROUGH_ROUNDS if roughly else 0):
        quick = PoolPricer(node.pool, work.pricer(node.legs, cap, work.cutting.pricing[0]))
        rough = generate(master, [quick], cap, work.time_left, reserve=_reserve(node), roughly=True)
        work.counts["rounds"] += rough.rounds
        if rough.ended in (Ended.PRUNED, Ended.INTERRUPTED) or not (cuts := _violated(master, rough.weight)):
            break
        _add(master, cuts, work)


def _add(master: Master, cuts: Sequence[Cut], work: Workspace) -> None:
    """Add the cuts, and count them."""
    master.cut_off(cuts)
    work.counts["cuts"] += len(cuts)


def _violated(master: Master, weight: Floats) -> list[Cut]:
    """Return cuts that the master's solution violates."""
    return separate([c.tasks for c in master.columns], weight, master.n, set(master.cuts), _CUTS_A_ROUND)


def _pricers(node: Node, master: Master, cap: float, work: Workspace) -> list[Prices]:
    """Return how to price at the node, the quickest first."""
    if node.pool.complete:
        return [PoolPricer(node.pool)]
    efforts = work.cutting if master.cuts else work.plain
    return [PoolPricer(node.pool, work.pricer(node.legs, cap, effort)) for effort in efforts.pricing]


def _reserve(node: Node) -> PoolPricer | None:
    """Return how to look for columns in a few tours before the others, None where there are none or few others."""
    if not node.pool.complete:
        return PoolPricer(node.reserve) if node.reserve.size else None
    if node.centre is None or node.pool.size <= _MANY * _FEW:
        return None
    return PoolPricer(node.pool.nearest(node.centre, _FEW))


def _reduce(node: Node, at: DualBound, cap: float, work: Workspace) -> None:
    """Fix legs or tours away at the best duals; list the tours where they fit."""
    node.pool = node.pool.needed(at, cap)
    others = np.flatnonzero(~node.pool.listed)
    if others.size == 0:
        return
    gap = cap - at.value
    pricing, thorough = work.cutting if node.cuts else work.plain
    if gap < _REFIX * node.fixed_at:
        quick = work.pricer(node.legs, cap, pricing[0])
        node.legs, node.fixed_at = fix_as_worth(quick, thorough, others, at), gap
    if gap <= min(_WORTH_LISTING * cap, _RETRY * node.listing_failed) and not _list(node, at, cap, work, _QUICK_ROOM):
        node.listing_failed = gap


def _list_at_last(node: Node, at: DualBound, cap: float, work: Workspace) -> bool:
    """List the tours where there is much room for it, and nothing else to do but branching; return whether they fit."""
    if cap - at.value > _RETRY * node.last_failed:
        return False
    if _list(node, at, cap, work, node.room):
        return True
    node.room, node.last_failed = _MORE_ROOM * node.room, cap - at.value
    return False


def _list(node: Node, at: DualBound, cap: float, work: Workspace, labels: int) -> bool:
    """List the tours, of each UAV with up to so many `labels`; return whether they fit."""
    pricer = work.pricer(node.legs, cap, (work.cutting if node.cuts else work.plain).thorough)
    node.pool, node.reserve, in_vain = list_tours(
        node.pool,
        pricer,
        at,
        labels,
        work.tours_room,
        node.reserve,
        at_once=work.team.size,
        known_are_of_here=node.reserved_at is at,
    )
    node.reserved_at = at
    work.counts["pools" if node.pool.complete else "lists in vain"] += 1
    work.counts["labels in vain"] += in_vain
    return node.pool.complete


def hint(master: Master, best: DualBound, weight: Floats, level: float = -np.inf) -> Hint:
    """Return what a relaxation says of routes, whose `level` [s] is known to be no lower.

    Long is, of each UAV that sets much of it, the longest tour in use; the UAV that sets most comes first.
    """
    used, sigma = [(master.columns[p], float(weight[p])) for p in np.flatnonzero(weight > _USED)], best.duals.sigma
    uavs = [k for k in np.argsort(-sigma, kind="stable").tolist() if sigma[k] > _MUCH]
    flown = ([column for column, _ in used if column.uav == k] for k in uavs)
    return Hint(max(level, best.value), [max(tours, key=lambda tour: tour.cost) for tours in flown if tours], used)


def _dive(master: Master, work: Workspace) -> Routes | None:
    """Return routes made of the columns known, by a short branch and bound over them, or None; where that is due."""
    time = min(_DIVE, work.time_left())
    if time <= 0 or not work.dives.due():
        return None
    routes = _routes(master.whole(time), master)
    work.dives.note(routes is not None)
    return routes


def _whole_tours(master: Master, weight: Floats) -> Routes | None:
    """Return the tours in use where no task is shared, else None.

    Then those that share a task visit the same tasks; only the cheapest of them counts.
    """
    tours: dict[tuple[int, frozenset[int]], Column] = {}
    used = [master.columns[p] for p in np.flatnonzero(weight > _USED)]
    for column in sorted(used, key=lambda column: column.cost):
        tours.setdefault((column.uav, frozenset(column.tasks)), column)
    return _routes(tours.values(), master)


def _routes(tours: Iterable[Column], master: Master) -> Routes | None:
    """Return `tours` as routes, those of UAVs that are alike in any order; None where they are none."""
    tours = list(tours)
    if sorted(i for column in tours for i in column.tasks) != list(range(master.n)):
        return None
    routes: list[tuple[int, ...]] = [()] * master.m
    for column in tours:
        free = [k for k in np.flatnonzero(master.first == column.uav) if not routes[k]]
        if not free:
            return None
        routes[free[0]] = column.tasks
    return tuple(routes)
