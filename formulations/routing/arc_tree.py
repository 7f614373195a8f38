"""arc-tree: branch and cut over the paper's MILP by our own tree, and bounds computed anew from prices.

Where `branch-and-cut` leaves cases, branches and bounds to SCIP, here they are our own (`arcs/`): the linear programme
holds few arcs and prices the rest, cuts are const6 in its depot-linked form, and of the most undecided splits a case
takes the one of which trials say that both cases after it gain most: first on which UAV takes which task (after
Applegate, Cook, Dash & Rohe, "Solution of a min-max vehicle routing problem", INFORMS J. Comput. 14, 2002, who do so
in their tree). Bounds are the Lagrangian at the programme's duals, so that no tolerance of it is in them, and a proof
can be kept (`certifying.py`).

Strong where tours are long and UAVs three, and where two fly from one site; of two sites far apart `branch-and-cut` is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from formulations.routing.arcs.case import Case
from formulations.routing.arcs.crowds import one_tree
from formulations.routing.arcs.helper import Helper
from formulations.routing.arcs.lagrangian import ArcPrices, Cuts, reduced_costs
from formulations.routing.arcs.programme import Programme
from formulations.routing.arcs.proof import ArcProof
from formulations.routing.arcs.tree import CaseTree
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.node import Hint
from formulations.routing.proved import TOLERANCE, StoppedBy, result_of
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.memetic import Memetic
from formulations.routing.search_beside import Search, first_routes
from formulations.routing.separation import cut_tree, subtours, two_cycles
from formulations.routing.simple_bounds import SIMPLE, worst_makespan
from formulations.routing.solver import Result
from formulations.routing.theta_count import why_too_large
from instances import InputError, Instance
from instances.arrays import Floats
from instances.routes import ENDURANCE_ROUNDING

MOST_THETA = 80_000
"""Beyond this a programme takes seconds for every case."""
_ROUNDING = 1e-9
_SEED = 500
"""Of the search beside the tree, for another one than beside columns: in `exact` both may run."""


@dataclass(frozen=True)
class ArcTree(RecordedSolver):
    """Branch and cut over arcs.

    starts : memetic searches before the first programme; 0 uses only the start given, to the end (at least 0).
    tried : splits of a case that are tried before one is chosen; 1 takes the most undecided (at least 1).
    joint : add cuts of what all UAVs fly together too.
    """

    starts: int = 1
    tried: int = 3
    joint: bool = True

    proves: ClassVar[bool] = True
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance"})

    def __post_init__(self) -> None:
        for label, least in (("starts", 0), ("tried", 1)):
            if getattr(self, label) < least:
                raise InputError(f"arc-tree: {label} must be at least {least}, got {getattr(self, label)}")

    def accepts(self, instance: Instance) -> str | None:
        """Return why the instance is too large for the three-index form, or None."""
        return why_too_large(instance, MOST_THETA)

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels."""
        Memetic().prepare(instance)
        subtours(np.zeros((2, 2)), 0.0)
        two_cycles(np.zeros((2, 2)), 0.0)
        cut_tree(np.zeros((2, 2)))
        one_tree(np.ones((3, 3)), 4.0, 1)
        one, nothing = np.ones(1), np.zeros(1)
        none = np.zeros(0)
        prices = ArcPrices(one, nothing, np.zeros((1, 2)), nothing, Cuts.none(1), none, none, (), none)
        reduced_costs(prices, np.ones((1, 2, 2)), Case.root(np.zeros(1, np.int64), 1))

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Solve to proof or limit; `limits.iterations` counts cases of the tree. Deterministic but for the clock."""
        first_routes(recorder, 1000 * seed, self.starts)
        return self.prove(recorder, seed)

    def prove(self, recorder: Recorder, seed: int) -> Result:
        """Raise the recorder's bound to its incumbent, improving both; INFEASIBLE where that proves there are none."""
        instance = recorder.instance
        most = worst_makespan(instance) if instance.restricted else np.inf
        upper = min(recorder.objective, most)
        for simple_bound in SIMPLE.values():
            recorder.raise_bound(simple_bound(instance, upper))
        if recorder.bound >= recorder.objective * (1 - TOLERANCE):
            return result_of(recorder, StoppedBy.PROOF, {})
        nodes, threads = recorder.limits.iterations, recorder.limits.threads
        make = partial(_tree_of, instance, upper, self)
        # cases in turn are counted, and which a helper has depends on the clock
        helpers = [Helper(instance, make) for _ in range(threads - 1)] if nodes is None else []
        try:
            tree = self.tree(recorder, seed, upper)
            tree.helpers, limit = helpers, np.inf if nodes is None else nodes
            ended = tree.grow(recorder, lambda: min(recorder.objective * (1 - TOLERANCE), most), limit)
        finally:
            for helper in helpers:
                helper.peer.end()
        return result_of(recorder, ended.value, tree.counts)

    def tree(self, recorder: Recorder, seed: int, upper: float, proof: ArcProof | None = None) -> CaseTree:
        """Return the tree before it grows; `upper` [s] > 0 is a cost that the best routes do not pass."""
        counts: Counter[str] = Counter()
        beside = Search(recorder, counts, 1000 * seed + _SEED, self.starts, TOLERANCE)
        tree = _tree_of(recorder.instance, upper, self, lambda: recorder.remaining)

        def better() -> None:
            counts["rounds"] = tree.counts["rounds"]
            beside.better(Hint(recorder.bound))

        if self.starts > 0:
            tree.better = better
        if proof is not None:
            tree.proof = proof
        return tree


def _tree_of(instance: Instance, upper: float, options: ArcTree, remaining: Callable[[], float]) -> CaseTree:
    """Return a tree of the instance that searches for nothing beside, and keeps no proof."""
    legs, limits = Legs.of(instance), instance.limits * (1 + ENDURANCE_ROUNDING)
    limits_below = np.where(limits < upper, limits, np.inf)
    programme = Programme(_costs(legs, upper, limits), limits_below / upper, joint=options.joint)
    far = np.nan_to_num((legs.out + legs.home).min(axis=0), posinf=upper) + _ROUNDING * upper
    return CaseTree(programme, legs.kinds(), upper, far, remaining, options.tried)


def _costs(legs: Legs, upper: float, limits: Floats) -> Floats:
    """Return c_ijk, (m, n + 1, n + 1), the depot last, in units of `upper`, infinite beyond it or `limits` (m,) [s]."""
    n = legs.n_tasks
    costs = np.full((legs.n_uavs, n + 1, n + 1), np.inf)
    costs[:, :n, :n], costs[:, n, :n], costs[:, :n, n] = legs.between, legs.out, legs.home
    costs[costs > np.minimum(limits, upper)[:, None, None] * (1 + _ROUNDING)] = np.inf
    return costs / upper
