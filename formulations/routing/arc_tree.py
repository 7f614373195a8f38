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
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from formulations.routing.arcs.case import Case
from formulations.routing.arcs.lagrangian import ArcPrices, Cuts, reduced_costs
from formulations.routing.arcs.programme import Programme
from formulations.routing.arcs.proof import ArcProof
from formulations.routing.arcs.tree import CaseTree
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.searching import STEPS, Search, search
from formulations.routing.recorder import RecordedSolver, Recorder
from formulations.routing.search.memetic import Memetic
from formulations.routing.separation import subtours, two_cycles
from formulations.routing.simple_bounds import SIMPLE, worst_makespan
from formulations.routing.solver import Result
from formulations.routing.theta_count import why_too_large
from instances import InputError, Instance
from instances.arrays import Floats
from instances.routes import ENDURANCE_ROUNDING

TOLERANCE = 1e-7
"""Of the longest tour: routes better by less are neither looked for nor excluded."""

MOST_THETA = 80_000
"""Beyond this a programme takes seconds for every case."""
_ROUNDING = 1e-9


@dataclass(frozen=True)
class ArcTree(RecordedSolver):
    """Branch and cut over arcs.

    starts : memetic searches before the first programme; 0 uses only the start given, to the end (at least 0).
    tried : splits of a case that are tried before one is chosen; 1 takes the most undecided (at least 1).
    """

    starts: int = 1
    tried: int = 3

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
        one, nothing = np.ones(1), np.zeros(1)
        prices = ArcPrices(one, nothing, np.zeros((1, 2)), nothing, Cuts.none(1), np.zeros(0), np.zeros(0))
        reduced_costs(prices, np.ones((1, 2, 2)), Case.root(np.zeros(1, np.int64), 1))

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Solve to proof or limit; `limits.iterations` counts cases of the tree. Deterministic but for the clock."""
        self.improve(recorder, 1000 * seed)
        ended, counts = self.prove(recorder, seed)
        proved = ended == "proof"
        if proved and recorder.routes is None:
            return recorder.infeasible(**counts)
        return recorder.result(ended, proved=proved, tolerance=left_open(recorder), **counts)

    def improve(self, recorder: Recorder, seed: int) -> None:
        """Look for routes for a third of the time left; there are some afterwards, unless UAVs cannot fly them."""
        instance = recorder.instance
        recorder.incumbent((tuple(instance.tasks), *((),) * (instance.n_depots - 1)))
        for run in range(self.starts):
            share = recorder.remaining / (3 * (self.starts - run))
            search(recorder, STEPS * instance.n_tasks**2, seed, run, share)

    def prove(self, recorder: Recorder, seed: int) -> tuple[str, dict[str, Any]]:
        """Raise the recorder's bound to its incumbent, improving both; return `Result.stopped_by` and the counters.

        "proof" without routes proves that there are none.
        """
        instance = recorder.instance
        most = worst_makespan(instance) if instance.restricted else np.inf
        upper = min(recorder.objective, most)
        for simple_bound in SIMPLE.values():
            recorder.raise_bound(simple_bound(instance, upper))
        if recorder.bound >= recorder.objective * (1 - TOLERANCE):
            return "proof", {}
        tree = self.tree(recorder, seed, upper)
        nodes = np.inf if recorder.limits.iterations is None else recorder.limits.iterations
        ended = tree.grow(recorder, lambda: min(recorder.objective * (1 - TOLERANCE), most), nodes)
        return ended.value, dict(tree.counts)

    def tree(self, recorder: Recorder, seed: int, upper: float, proof: ArcProof | None = None) -> CaseTree:
        """Return the tree before it grows; `upper` [s] > 0 is a cost that the best routes do not pass."""
        instance, legs = recorder.instance, Legs.of(recorder.instance)
        counts: Counter[str] = Counter()
        beside = Search(recorder, counts, 1000 * seed, self.starts, TOLERANCE)

        def better() -> None:
            if self.starts > 0:
                counts["rounds"] = tree.counts["rounds"]
                beside.better(0.0, ())

        limits = instance.limits * (1 + ENDURANCE_ROUNDING)
        programme = Programme(_costs(instance, upper, limits), np.where(limits < upper, limits, np.inf) / upper)
        far = np.nan_to_num((legs.out + legs.home).min(axis=0), posinf=upper) + _ROUNDING * upper
        tree = CaseTree(
            programme,
            legs.kinds(),
            upper,
            far,
            lambda: recorder.remaining,
            better,
            self.tried,
            proof or ArcProof(),
        )
        return tree


def left_open(recorder: Recorder) -> float:
    """Return what a proof leaves open [s]."""
    return 0.0 if recorder.routes is None else 2 * TOLERANCE * recorder.objective


def _costs(instance: Instance, upper: float, limits: Floats) -> Floats:
    """Return c_ijk, (m, n + 1, n + 1), the depot last, in units of `upper` [s], infinite beyond it or endurance."""
    n = instance.n_tasks
    costs = np.empty((instance.n_depots, n + 1, n + 1))
    for k, (depot, of_class) in enumerate(zip(instance.depots, instance.classes.tolist(), strict=True)):
        nodes = [*instance.tasks, depot]
        costs[k] = instance.class_costs[of_class][np.ix_(nodes, nodes)]
        np.fill_diagonal(costs[k], np.inf)
        costs[k][costs[k] > min(upper, limits[k]) * (1 + _ROUNDING)] = np.inf
    return costs / upper
