"""`branch-and-price`: one tour per UAV, chosen from all tours, which are never all listed.

Let P_k be the tours of UAV k (over any set of tasks, from and to its depot) and a_ip = 1 where tour p visits task i:

    min z    Σ_k Σ_{p∈P_k} a_ip λ_p = 1                         for every task i,
             Σ_{p∈P_k} c_p λ_p ≤ z,   Σ_{p∈P_k} λ_p ≤ 1         for every UAV k,

λ binary: the paper's problem (eqs. c_max, const1–const6) after Dantzig–Wolfe decomposition. Its relaxation is far
stronger than that of θ_ijk, most of all because P_k holds only tours that cost less than the best routes known.

1. Incumbent: the memetic search, for a while, and again while a gap is left.                    `search_beside.py`
2. A tree, branching on who takes which task.                                    `columns/tree.py`, `branching.py`
3. Where tours are long, arcs left out by the capped total.                                          `capped_total.py`
   At a node the relaxation by column generation, at the root begun with walks; legs fixed away by reduced cost; a
   UAV's tours listed when they fit; subset-row cuts. Short tours are looked for from both sides where labels are many.
   A UAV that sets the relaxation alone is counted no more.
        `columns/tightening.py`, `walks.py`, `generation.py`, `smoothing.py`, `pricing.py`, `master.py`, `fixing.py`,
        `pool.py`, `label_search.py`, `two_sided.py`, `exempting.py`
4. Trees under lower caps, where pricing is dear at the root and gains little, or the gap stays wide to the end. One
   that ends without routes makes its cap a bound, one whose cap is a little above the best routes finds them
   (Klein & Scholl, Eur. J. Oper. Res. 112, 1999: destructive improvement).

Where nodes have several states, labels keep the least cost of each state of their last task; what bounds them knows
legs at their least over states (`columns/state_labelling.py`).

UAVs may differ in costs and endurance L_k: P_k are then the tours that UAV k can fly, of cost ≤ L_k. While no routes
are known the cap is a cost that no routes pass (`simple_bounds.worst_makespan`), and a tree that ends without routes
proves that there are none. Where costs change with time, they are the clock: labels keep arrivals, and legs in bins are
those of their time (`columns/courses.py`).

Several threads look for tours of several UAVs at once (`columns/team.py`); the tree is the same.

Strong where tours are short (n/m up to about 20). Sources: Baldacci, Mingozzi, Roberti (Oper. Res. 59, 2011) for
ng-routes and enumeration; Contardo & Martinelli (Discrete Optim. 12, 2014) for cutting over a listed pool.

Floating point: all bounds are Lagrangian, valid at any duals, with an explicit margin for rounding
(`columns/pricing.py`); times in bins are rounded down; nothing is claimed about routes better by less than `tolerance`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from formulations.routing.capped_total import capped_total
from formulations.routing.columns.cuts import separate
from formulations.routing.columns.fixing import fix_legs
from formulations.routing.columns.label_search import Clock, Labels, no_limit
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.node import Workspace, nothing_better
from formulations.routing.columns.pool import Pool, list_tours
from formulations.routing.columns.pricing import Column, DualBound, Duals, Effort, Pricer, efforts, walking
from formulations.routing.columns.proof_log import ProofLog
from formulations.routing.columns.recall import Recall
from formulations.routing.columns.state_labelling import StateLabels
from formulations.routing.columns.team import Team
from formulations.routing.columns.tree import Tree
from formulations.routing.columns.walks import relax_by_walks
from formulations.routing.proved import TOLERANCE, StoppedBy, result_of
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.memetic import Memetic
from formulations.routing.search.states.searching import warm_up
from formulations.routing.search_beside import Search, first_routes
from formulations.routing.simple_bounds import SIMPLE, worst_makespan
from formulations.routing.solver import Result
from formulations.routing.stateless import stateless
from formulations.routing.time_windows import windowed
from instances import InputError, Instance, Travel, tour_costs

MOST_TASKS = 300
_MOST_LEGS = 4_000_000
_MOST_LEGS_BY_CLOCK = 50_000
"""The same where costs change with time: their legs are kept for every bin, which fills about 1 GB."""
_MOST_THREADS = 4
"""Each has room for labels of its own, up to 0.8 GB."""
_LONG = 15
"""Tasks a UAV from which relaxations begin with the capped total and with walks, where all UAVs are alike: labels lose
their way at first duals. Up to it tours are looked for from both sides.

Where UAVs are not alike, walks are priced for every one of them and cost more than they save (50/3, 60/4: a third
more).
"""
_FOR_ARCS = 0.2  # share of the time, at most, for the capped total
_PRECISION = 1e-3  # share of the longest tour, and of the time, at which trials of caps end
_WIDE = 0.02  # gap above which trials of caps get the last third of the time, or half of it, and are searched beside
_APART = 0.005  # gap at the root, of short tours, above which trials of caps come before its children, and to which


@dataclass(frozen=True)
class BranchAndPrice(RecordedSolver):
    """Branch and price over tours.

    starts : memetic searches before the first relaxation; 0 uses only the start given, to the end (at least 0).
    bins : divisions of the longest tour allowed in the completion bounds; fewer are faster and weaker (at least 1).
    labels : room for labels of one search, about 40 bytes each, used only where needed (at least 1000).
    tours : room for listed tours (at least 100).
    """

    starts: int = 1
    bins: int = 500
    labels: int = 16_000_000
    tours: int = 6_000_000

    proves: ClassVar[bool] = True
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance", "time", "states"})

    def __post_init__(self) -> None:
        for label, least in (("starts", 0), ("bins", 1), ("labels", 1000), ("tours", 100)):
            if getattr(self, label) < least:
                raise InputError(f"branch-and-price: {label} must be at least {least}, got {getattr(self, label)}")

    def accepts(self, instance: Instance) -> str | None:
        """Refuse instances whose completion bounds take longer than a time limit may be overrun, or much memory."""
        n, m, travel = instance.n_tasks, instance.n_depots, instance.travel
        if {"time", "states"} <= instance.axes:
            return "columns take costs that change with time or several states at a node, not both"
        if "states" in instance.axes and travel is not None and travel.closed and (travel.nodes >= n).sum() > m:
            return "columns take depots of one state where tours must end in the state that they began in"
        most = _MOST_LEGS_BY_CLOCK if "time" in instance.axes else _MOST_LEGS
        if n <= MOST_TASKS and m * n * n <= most:
            return None
        return f"columns take at most {MOST_TASKS} tasks and {most} legs (m·n²), not {n} and {m * n * n}"

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (about a minute the first time, then cached): use each once, on six tasks in a circle."""
        Memetic().prepare(instance)
        if "states" in instance.axes:
            _prepare_states()
        make_store(3, 8).keep_best(2, 0, 4)
        angle = np.arange(7.0)
        place = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        place[6] = 0.0
        circle = Instance("circle", np.hypot(*(place[:, None] - place).transpose(2, 0, 1)), 6, 1)
        if instance.axes & {"fleet", "endurance"}:
            Memetic().prepare(circle)  # part of a fleet may be alike, for which other kernels are compiled
        capped_total(circle, 10.0, 60.0)
        if "time" in instance.axes:
            travel = Travel(np.repeat(circle.cost[None, None], 2, axis=1), np.array([0]), np.array([0.0, 1.0]))
            circle = Instance.of_travel("circle", travel, 6)
        cap, tours = 10.0, [(0, 1, 2), (2, 3, 4), (0, 4, 5)]
        cuts = tuple(separate(tours, np.full(3, 0.9), 6, set(), 5)) or ((0, 2, 4),)
        duals = Duals(np.ones(6), np.ones(1), np.zeros(1), np.full(len(cuts), 0.1), cuts)
        pricer = Pricer(Legs.of(circle).under(cap), cap, Effort(2, 10, 5, 2, both=True), make_store(6, 10_000))
        at = DualBound(0.0, duals, np.array([pricer.price(0, duals, 0.0).least]))
        fix_legs(pricer, [0], at)
        relax_by_walks(pricer, np.zeros(1, np.int64), [])
        pricer.sides(0, duals).search(pricer.store.of_uav(0), np.inf, no_limit, beam=1, tours=100)  # many labels for it
        pool = list_tours(nothing := Pool.empty(1, 6), pricer, at, 10_000, 10_000, nothing).pool
        pool.needed(at, cap)

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Solve to proof or limit; `limits.iterations` counts nodes of the tree. Deterministic but for the clock."""
        first_routes(recorder, 1000 * seed, self.starts)
        return result_of(recorder, *self.prove(recorder, seed, recorder.limits.threads))

    def prove(self, recorder: Recorder, seed: int, threads: int = 1) -> tuple[str, dict[str, Any]]:
        """Raise the recorder's bound to its incumbent, improving both; return `Result.stopped_by` and the counters.

        threads : for as many UAVs tours are looked for at once.

        "proof" without routes proves that there are none. The incumbent may also be improved from outside meanwhile,
        whenever the recorder is asked for the time left.
        """
        instance = recorder.instance
        most = worst_makespan(instance) if instance.restricted else np.inf
        upper, least = min(recorder.objective, most), stateless(instance)
        plain = windowed(instance, upper) if "time" in instance.axes else least
        for simple_bound in SIMPLE.values():
            recorder.raise_bound(simple_bound(plain, upper))
        if recorder.bound >= recorder.objective * (1 - TOLERANCE):
            return StoppedBy.PROOF.value, {}
        legs = Legs.of(least)
        if _long(instance, legs) and recorder.routes is not None:
            found = capped_total(plain, recorder.objective, _FOR_ARCS * recorder.remaining)
            recorder.raise_bound(found.bound)
            legs = legs.among(found.arcs)
        limits, patience = recorder.limits, Patience(recorder)
        tree = self.tree(recorder, seed, patience.left, legs, bound=recorder.bound, threads=threads)
        work = tree.work

        def wide() -> bool:
            return limits.iterations is None and tree.bound(np.inf) < (1 - _WIDE) * recorder.objective

        nodes = np.inf if limits.iterations is None else limits.iterations
        patience.share(2 / 3)
        work.time_left = lambda: left if (left := patience.left()) > 0 or wide() else recorder.remaining
        if limits.iterations is None and _short(instance):
            tree = self.approach(recorder, patience, tree, legs)
        ended = tree.grow(recorder, TOLERANCE, nodes)
        if ended is not StoppedBy.PROOF:
            if wide():
                # the tree has far to go from a gap as wide as this; but of short tours it may be near its end
                patience.share(1 / 2 if _short(instance) else 1)
                self.destroy(recorder, patience, tree, legs)
            patience.share(1)
            ended = tree.grow(recorder, TOLERANCE, nodes - work.counts["nodes"])
        recorder.raise_bound(tree.bound(min(recorder.objective * (1 - TOLERANCE), most)) * (1 - 1e-12))
        return ended.value, dict(work.counts)

    def tree(
        self,
        recorder: Recorder,
        seed: int,
        time_left: Clock,
        legs: Legs,
        *,
        bound: float = 0.0,
        log: ProofLog | None = None,
        threads: int = 1,
    ) -> Tree:
        """Return the tree before it grows: `time_left` says how long it may, `bound` [s] what is known before.

        legs : all of the instance but those that no routes shorter than the recorder's use.
        """
        instance = recorder.instance
        team = Team(lambda: labels_for(instance, self.labels), min(threads, instance.n_depots, _MOST_THREADS))
        far = np.nan_to_num((legs.out + legs.home).min(axis=0), posinf=instance.cost.max())
        hard, recall = efforts(instance.n_tasks, self.bins, both=_short(instance)), Recall(instance.n_tasks)
        work = Workspace(time_left, team, self.tours, *hard, far, recall, log=log or ProofLog())
        if self.starts > 0:
            work.better = Search(recorder, work.counts, 1000 * seed, self.starts, TOLERANCE).better
        most = worst_makespan(instance) if instance.restricted else np.inf
        # states may differ where their least legs do not
        kinds = None if "states" in instance.axes else legs.kinds()
        if _long(instance, legs):
            work.walks = walking(instance.n_tasks, self.bins)
        return Tree(legs, _columns(recorder), work, bound, most, kinds)

    def approach(self, recorder: Recorder, patience: Patience, tree: Tree, legs: Legs) -> Tree:
        """Return the tree to grow: another, after trials of caps, where pricing is dear at the root and the gap wide.

        Under lower caps tours are listed sooner, and a cap a little above the best routes finds them.
        """
        tree.work.hasty = True
        ended = tree.grow(recorder, TOLERANCE, np.inf)
        tree.work.hasty = False
        if ended is not StoppedBy.ITERATIONS or tree.bound(np.inf) >= (1 - _APART) * recorder.objective:
            return tree
        patience.share(1)
        columns = self.destroy(recorder, patience, tree, legs, _APART)
        patience.share(2 / 3)
        return Tree(legs, columns, tree.work, recorder.bound, tree.most, tree.kinds)

    def destroy(
        self, recorder: Recorder, patience: Patience, whole: Tree, legs: Legs, precision: float = _PRECISION
    ) -> list[Column]:
        """Raise the bound by trees under caps below the incumbent: where one ends without routes, its cap is a bound.

        A tree whose cap is half-way to the incumbent is far smaller than half the tree, and one whose cap is a little
        above the best routes finds them. The next cap is half-way between the highest proved and the lowest not proved
        in its share of the time, as long as they differ by more than `precision`, a share. Each begins with the columns
        of the one before (not with its cuts, which make pricing dear before legs are fixed), the first with those of
        the `whole` tree, all with its `legs`; those of the last are returned. Where the gap is narrow no routes are
        searched for beside, but for the last: trees under lower caps find them or show that there are none.
        """
        work, high, end, columns = whole.work, min(recorder.objective, whole.most), patience.until, whole.columns
        search, time_left, work.time_left = work.better, work.time_left, patience.left
        while high - recorder.bound > precision * high and recorder.remaining - end > _PRECISION * recorder.remaining:
            cap = (recorder.bound + high) / 2
            last = cap - recorder.bound <= precision * high  # what stops this one stops the whole tree as well
            patience.share(1 if last else 1 / 2, end)
            wide = high - recorder.bound > _WIDE * high
            work.better = search if last or wide else nothing_better
            tree = Tree(legs, columns, work, recorder.bound, cap, whole.kinds)
            tree.grow(recorder, TOLERANCE, np.inf)
            columns = tree.columns
            high = min(high if recorder.bound >= cap * (1 - TOLERANCE) else cap, recorder.objective)
        work.better, work.time_left = search, time_left
        return columns


def _short(instance: Instance) -> bool:
    """Say whether tours are so short that they are looked for from both sides."""
    return instance.n_tasks <= _LONG * instance.n_depots


def _long(instance: Instance, legs: Legs) -> bool:
    """Say whether tours are long and all UAVs alike, at costs that neither time nor the state of a node changes."""
    plain = not instance.axes & {"time", "states"}
    return plain and instance.n_tasks >= _LONG * instance.n_depots and not legs.kinds().any()


def labels_for(instance: Instance, most: int) -> Labels:
    """Return room for labels of an instance: `most` of them, but no more than all sets and last tasks."""
    n = instance.n_tasks
    room = min(most, max(1000, n << min(n, 40)))
    return StateLabels.of(instance, room) if "states" in instance.axes else make_store(n, room)


def _prepare_states() -> None:
    """Compile the kernels of labels over states."""
    tiny = warm_up(Instance("any", np.zeros((2, 2)), 1, 1))
    duals = Duals(np.full(tiny.n_tasks, 9.0), np.ones(tiny.n_depots), np.zeros(tiny.n_depots), np.zeros(0))
    Pricer(Legs.of(stateless(tiny)), 9.0, Effort(2, 10, 5), StateLabels.of(tiny, 1000)).price(0, duals, 0.0)


class Patience:
    """How long to go on with what is being done."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder, self.until = recorder, 0.0

    def share(self, part: float, end: float = 0.0) -> None:
        """Allow a share of the time that remains before `end` [s] are left."""
        remaining = self._recorder.remaining
        self.until = remaining - part * max(0.0, remaining - end)

    def left(self) -> float:
        """Return what is left of the time allowed [s]."""
        return self._recorder.remaining - self.until


def _columns(recorder: Recorder) -> list[Column]:
    """Return the tours of the incumbent, none where there is none."""
    routes = recorder.routes or ()
    costs = tour_costs(recorder.instance, routes)
    return [Column(k, route, float(costs[k])) for k, route in enumerate(routes) if route]
