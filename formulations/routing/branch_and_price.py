"""`branch-and-price`: one tour per UAV, chosen from all tours, which are never all listed.

Let P_k be the tours of UAV k (over any set of tasks, from and to its depot) and a_ip = 1 where tour p visits task i:

    min z    Σ_k Σ_{p∈P_k} a_ip λ_p = 1                         for every task i,
             Σ_{p∈P_k} c_p λ_p ≤ z,   Σ_{p∈P_k} λ_p ≤ 1         for every UAV k,

λ binary: the paper's problem (eqs. c_max, const1–const6) after Dantzig–Wolfe decomposition. Its relaxation is far
stronger than that of θ_ijk, most of all because P_k holds only tours that cost less than the best routes known.

1. Incumbent: a few short annealed ruin-and-recreate runs.            `search/ruin_recreate.py`
2. Relaxation by column generation; Lagrangian bounds.                `columns/generation.py`, `pricing.py`, `master.py`
3. Legs fixed away by reduced cost; tours listed when they fit.       `columns/fixing.py`, `enumeration.py`, `pool.py`
4. Subset-row cuts, then branching on who takes which task.           `columns/cuts.py`, `node.py`, `tree.py`

Strong where tours are short (n/m up to about 20). Sources: Baldacci, Mingozzi, Roberti (Oper. Res. 59, 2011) for
ng-routes and enumeration; Contardo & Martinelli (Discrete Optim. 12, 2014) for cutting over a listed pool.

Floating point: all bounds are Lagrangian, valid at any duals, with an explicit margin for rounding
(`columns/pricing.py`); times in bins are rounded down; nothing is claimed about routes better by less than `tolerance`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from formulations.recorder import Recorder
from formulations.routing.columns.labelling import compile_beam, make_store
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.node import Efforts, Workspace
from formulations.routing.columns.pricing import Column, Effort
from formulations.routing.columns.tree import Incumbent, Tree
from formulations.routing.search.ruin_recreate import RuinRecreate
from formulations.solver import Limits, Observer, Result, Solver, ignore
from instances import InputError, Instance, Routes, tour_costs

TOLERANCE = 1e-7
"""Of the longest tour: routes better by less are neither looked for nor excluded."""

MOST_TASKS = 300
_MOST_LEGS = 4_000_000
_STEPS_A_TASK = 2000
_MOST_BATCHES = 5


@dataclass(frozen=True)
class BranchAndPrice(Solver):
    """Branch and price over tours.

    starts : ruin-and-recreate runs before the first relaxation, and in each batch after it while a gap is left and
        they help; 0 uses only the start given.
    bins : divisions of the longest tour allowed in the completion bounds; fewer are faster and weaker.
    labels : room for labels of one search, about 50 bytes each.
    tours : room for listed tours.
    """

    starts: int = 6
    bins: int = 500
    labels: int = 16_000_000
    tours: int = 3_000_000

    proves: ClassVar[bool] = True

    def __post_init__(self) -> None:
        for label, least in (("starts", 0), ("bins", 1), ("labels", 1000), ("tours", 100)):
            if getattr(self, label) < least:
                raise InputError(f"branch-and-price: {label} must be at least {least}, got {getattr(self, label)}")

    def accepts(self, instance: Instance) -> str | None:
        """Refuse instances whose completion bounds take longer than a time limit may be overrun, or much memory."""
        n, m = instance.n_tasks, instance.n_depots
        if n <= MOST_TASKS and m * n * n <= _MOST_LEGS:
            return None
        return f"columns take at most {MOST_TASKS} tasks and {_MOST_LEGS} legs (m·n²), not {n} and {m * n * n}"

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels (about a minute the first time, then cached)."""
        RuinRecreate().prepare(instance)
        compile_beam()
        # Small, and from a start poor enough that cuts, leg fixing and the pool are all needed.
        place = np.random.default_rng(0).uniform(0, 1, (15, 2))
        small = Instance("warm-up", np.hypot(*(place[:, None] - place).transpose(2, 0, 1)), 12, 3)
        poor = (tuple(range(4)), tuple(range(4, 8)), tuple(range(8, 12)))
        replace(self, starts=0).solve(small, limits=Limits(time=3600.0), start=poor)

    def solve(
        self,
        instance: Instance,
        *,
        limits: Limits,
        seed: int = 0,
        observe: Observer = ignore,
        start: Routes | None = None,
    ) -> Result:
        """Solve to proof or limit; `limits.iterations` counts nodes of the tree. Deterministic but for the clock."""
        recorder = Recorder(instance, limits, observe, start)
        self.improve(recorder, 1000 * seed, self.starts)
        ended, counts = self.prove(recorder, seed, lambda: False)
        proved = ended == "proof"
        return recorder.result(ended, proved=proved, tolerance=2 * TOLERANCE * recorder.objective, **counts)

    def prove(self, recorder: Recorder, seed: int, stop: Callable[[], bool]) -> tuple[str, dict[str, Any]]:
        """Raise the recorder's bound to its incumbent, improving both; return what ended it, and counters.

        The incumbent may also be improved from outside meanwhile, in `stop`, which is asked often and ends the work.
        """
        if recorder.objective == 0:
            return "proof", {}
        n, limits = recorder.instance.n_tasks, recorder.limits
        work = Workspace(
            lambda: recorder.remaining <= 0 or stop(), make_store(n, self.labels), self.tours, *self._efforts(n)
        )
        tree = Tree(Legs.of(recorder.instance), _columns(recorder), work)
        incumbent = Incumbent(lambda: recorder.objective * (1 - TOLERANCE), recorder.incumbent, recorder.raise_bound)
        nodes = np.inf if limits.iterations is None else limits.iterations
        if nodes > 0:
            tree.relax(incumbent)
            self._improve_again(recorder, seed, lambda: tree.bound(incumbent.cap()) >= incumbent.cap())
        proved = tree.grow(incumbent, nodes)
        recorder.raise_bound(tree.bound(incumbent.cap()) * (1 - 1e-12))
        if proved:
            return "proof", work.counts
        if tree.stuck:
            return "memory", work.counts
        return "time" if work.out_of_time() else "iterations", work.counts

    def improve(self, recorder: Recorder, seed: int, runs: int) -> None:
        """Make sure that there are routes; search `runs` times, from different seeds, for a third of the time left."""
        everything_to_one: list[tuple[int, ...]] = [() for _ in recorder.instance.depots]
        everything_to_one[0] = tuple(recorder.instance.tasks)
        recorder.incumbent(tuple(everything_to_one))
        steps = _STEPS_A_TASK * min(max(recorder.instance.n_tasks, 10), 200)
        share = recorder.remaining / (3 * max(runs, 1))
        for run in range(runs):
            if share <= 0:
                return
            limits = Limits(time=share, iterations=steps)
            found = RuinRecreate().solve(recorder.instance, limits=limits, seed=seed + run)
            if found.routes is not None:
                recorder.incumbent(found.routes)

    def _improve_again(self, recorder: Recorder, seed: int, enough: Callable[[], bool]) -> None:
        """Search in batches until one finds nothing better: a gap costs far more to close than this."""
        for batch in range(1, _MOST_BATCHES + 1):
            before = recorder.objective
            if enough() or recorder.remaining <= 0:
                return
            self.improve(recorder, 1000 * seed + batch * self.starts, self.starts)
            if recorder.objective == before:
                return

    def _efforts(self, n: int) -> tuple[Efforts, Efforts]:
        """Return how hard to work at a node without cuts, and at one with cuts."""
        near = 6 if n <= 100 else 5
        quick, middle, fine = (max(1, self.bins * share // 10) for share in (3, 5, 8))
        plain = (
            Effort(3, quick, 200),
            Effort(3, quick, 3000),
            Effort(near - 1, middle, 20_000),
            Effort(near, fine, 300_000),
        )
        cutting = (
            Effort(3, quick, 200, 3),
            Effort(3, quick, 3000, 4),
            Effort(4, middle, 30_000, 4),
            Effort(5, middle, 300_000, 4),
        )
        return Efforts(plain, Effort(near, fine, 0)), Efforts(cutting, Effort(5, fine, 0, 4))


def _columns(recorder: Recorder) -> list[Column]:
    """Return the tours of the incumbent."""
    assert recorder.routes is not None
    costs = tour_costs(recorder.instance, recorder.routes)
    return [Column(k, route, float(costs[k])) for k, route in enumerate(recorder.routes) if route]
