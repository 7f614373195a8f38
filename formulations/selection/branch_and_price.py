"""`branch-and-price`: one tour a UAV, chosen from all tours that fit, which are never all listed. Team orienteering.

The programme and its Lagrangian bound are in `duals.py`; worth that is not modular stands there under its linear
overestimates, to which tangents are added where they are needed (`overestimates.py`).

1. A search for routes (`ruin_recreate.py`).
2. Column generation with ng-route completion bounds, tours listed where the gap lets them fit, subset-row cuts and a
   tree (`generation.py`, `pricing.py`, `tree.py`).

Sources: Boussier, Feillet, Gendreau, "An exact algorithm for team orienteering problems", 4OR 5 (2007), for the
decomposition; Baldacci, Mingozzi, Roberti (Oper. Res. 59, 2011) for ng-routes and lists; Jepsen et al. (Oper. Res. 56,
2008) for the cuts. Strong where tours are short.

Floating point: bounds hold at any duals and are raised by more than all rounding; prizes that are whole numbers let
them be rounded down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formulations.routing.columns.cuts import separate
from formulations.routing.columns.label_search import no_limit
from formulations.routing.columns.labelling import make_store
from formulations.routing.columns.pricing import Effort
from formulations.selection.duals import DualBound, Duals
from formulations.selection.fleet import groups_of
from formulations.selection.overestimates import Overestimate, first_overestimates
from formulations.selection.pricing import Pricer
from formulations.selection.ruin_recreate import RuinRecreate
from formulations.selection.selection import Record, SelectionMethod, SelectionProblem
from formulations.selection.tree import Tree
from formulations.selection.worth import Worth
from instances import Instance

MOST_TASKS = 300
_SHARE = 0.2
"""Of the time, what the search before the tree may take."""


@dataclass(frozen=True)
class BranchAndPrice(SelectionMethod):
    """Branch and price over tours.

    search_seconds : search before the first relaxation [s], at most a fifth of the time (at least 0).
    labels : room for labels of one search, about 50 bytes each (at least 0).
    tours : room for listed tours (at least 0).
    """

    search_seconds: float = 3.0
    labels: int = 4_000_000
    tours: int = 400_000

    def accepts(self, problem: SelectionProblem) -> str | None:
        """Refuse instances whose completion bounds take too long."""
        n = problem.instance.n_tasks
        return (
            None if n <= MOST_TASKS else f"columns take at most {MOST_TASKS} tasks, not {n}; ruin-recreate takes more"
        )

    def prepare(self, problem: SelectionProblem) -> None:
        """Compile the kernels (a minute the first time, then cached): use each on six tasks in a circle."""
        RuinRecreate().prepare(problem)
        angle = np.arange(7.0)
        place = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        place[6] = 0.0
        cost = np.hypot(*(place[:, None] - place).transpose(2, 0, 1))
        tiny = Instance("circle", cost, 6, 1, endurance=np.array([4.0]))
        groups, store = groups_of(tiny), make_store(6, 10_000)
        cuts = tuple(separate([(0, 1, 2), (2, 3, 4), (0, 4, 5)], np.full(3, 0.9), 6, set(), 5)) or ((0, 2, 4),)
        none, rho = Overestimate(0.0, np.ones(6)), np.full(len(cuts), 0.1)
        duals = Duals(np.ones(6), np.ones(1), np.zeros(1), rho, (none,), cuts)
        pricer = Pricer(groups, Effort(2, 10, 1, 2), store, no_limit)
        at = DualBound(6.0, duals, np.array([pricer.price(0, duals, 0.0).least]))
        pool = pricer.listing(at, 3.0, Worth.of_prizes(np.ones(6)), 10_000, 10_000)
        assert pool is not None
        pool.needed(at, 3.0).price(0, duals, 0.0)

    def search(self, problem: SelectionProblem, record: Record, seed: int) -> str:
        """Solve to proof or limit; `limits.iterations` counts nodes of the tree."""
        if self.search_seconds > 0:
            seconds = min(self.search_seconds, _SHARE * record.remaining)
            RuinRecreate(seconds).improve(problem, record, seed, None)
        return "proof" if record.proved else self._prove(problem, record)

    def _prove(self, problem: SelectionProblem, record: Record) -> str:
        """Raise the bound down to the best routes, improving both."""
        groups, n = groups_of(problem.instance), problem.instance.n_tasks
        store = make_store(n, min(self.labels, max(1000, n << min(n, 40))))
        reachable = np.logical_or.reduce([group.within() for group in groups])
        first = list(first_overestimates(problem.worth, reachable))
        return Tree(record, groups, store, self.tours, first).grow()
