"""The constraint handler of const6, and the two plugins that carry routes and bounds in and out of SCIP.

SCIP asks the handler whether a solution is feasible (check), what to do with an integer solution of a relaxation
(enforce) and for cuts of a fractional one (separate). An exception in a callback of PySCIPOpt is printed and lost, so
each one is kept, the search interrupted, and the exception raised again after it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from pyscipopt import Conshdlr, Eventhdlr, Heur
from pyscipopt.scip import PY_SCIP_EVENTTYPE, PY_SCIP_HEURTIMING, PY_SCIP_RESULT, Solution

from formulations.routing.branch_and_cut_model import ScipModel
from formulations.routing.model_solver import too_long
from formulations.routing.recorder import Recorder
from formulations.routing.separation import subtours, two_cycles
from formulations.routing.subtours import Arc, find_subtours, repair, walk
from instances.arrays import Bools, Floats, Ints

LEAST = 0.02
"""A fractional cut must be violated by more than this to be worth a row."""
COUNTED = ("handler_calls", "lazy_cuts", "fractional_cuts", "two_cycle_cuts")
_INTEGER = 0.5


class Shared:
    """What the plugins of one solve share: model, recorder, counters, the first exception, whether one stopped SCIP."""

    def __init__(self, model: ScipModel, recorder: Recorder, margin: float) -> None:
        self.model, self.recorder, self.margin = model, recorder, margin
        self.counts: dict[str, Any] = dict.fromkeys(COUNTED, 0)
        self.error: BaseException | None = None
        self.stopped = False


def guarded(otherwise: dict[str, Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Keep an exception of a callback and interrupt the search; the callback then answers `otherwise`."""

    def wrap(callback: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(callback)
        def safely(self: Any, *args: Any) -> Any:
            try:
                return callback(self, *args)
            except BaseException as error:
                self.shared.error = self.shared.error or error
                self.shared.model.scip.interruptSolve()
                return otherwise

        return safely

    return wrap


def routed_once(used: list[Bools]) -> bool:
    """Return whether the arcs of the UAVs keep const1–const4: SCIP also asks about solutions that break its rows."""
    balanced = all((arcs.sum(axis=0) == arcs.sum(axis=1)).all() and arcs[-1].sum() <= 1 for arcs in used)
    return balanced and bool((np.sum([arcs[:, :-1].sum(axis=0) for arcs in used], axis=0) == 1).all())


class SubtourHandler(Conshdlr):
    """const6 in its depot-linked form, added when violated; tours beyond endurance by less than SCIP can tell."""

    def __init__(self, shared: Shared, *, fractional: bool, two_cycles: bool) -> None:
        self.shared, self.fractional, self.two_cycles = shared, fractional, two_cycles
        # of each UAV, where its arcs lie in a matrix (n+1, n+1), the depot last
        arcs = [np.array(list(theta), dtype=int).reshape(-1, 2) for theta in shared.model.theta]
        self.places = [np.minimum(nodes, shared.model.instance.n_tasks).T for nodes in arcs]

    def theta(self, solution: Solution | None) -> list[Floats]:
        """Return θ of each UAV in a solution (None: of the relaxation), shape (n+1, n+1), its depot last."""
        size, value = self.shared.model.instance.n_tasks + 1, self.shared.model.scip.getSolVal
        matrices = []
        for (i, j), variables in zip(self.places, self.shared.model.theta, strict=True):
            matrix = np.zeros((size, size))
            matrix[i, j] = [value(solution, variable) for variable in variables.values()]
            matrices.append(matrix)
        return matrices

    @guarded({"result": PY_SCIP_RESULT.INFEASIBLE})
    def conscheck(self, constraints: Any, solution: Any, *what_to_check: Any) -> dict[str, Any]:
        """Refuse a solution with a flaw; offer the routes it comes to, repaired where need be."""
        self.shared.counts["handler_calls"] += 1
        feasible = not self.flawed(self.theta(solution))
        return {"result": PY_SCIP_RESULT.FEASIBLE if feasible else PY_SCIP_RESULT.INFEASIBLE}

    @guarded({"result": PY_SCIP_RESULT.INFEASIBLE})
    def consenfolp(self, constraints: Any, n_useful: Any, infeasible: Any) -> dict[str, Any]:
        """Cut off an integer solution of the relaxation that has subtours or tours too long."""
        self.shared.counts["handler_calls"] += 1
        theta = self.theta(None)
        if not self.flawed(theta):
            return {"result": PY_SCIP_RESULT.FEASIBLE}
        cutoff = self.add([subtours(np.round(matrix), 0.5) for matrix in theta], "lazy_cuts", force=True)
        for k, tour in self.too_long(self.arcs_of(theta)):
            cutoff |= self.add_never(k, tour)
        return {"result": PY_SCIP_RESULT.CUTOFF if cutoff else PY_SCIP_RESULT.SEPARATED}

    @guarded({"result": PY_SCIP_RESULT.INFEASIBLE})
    def consenfops(self, constraints: Any, n_useful: Any, infeasible: Any, objinfeasible: Any) -> dict[str, Any]:
        """Refuse a pseudo solution with a flaw (SCIP then branches)."""
        self.shared.counts["handler_calls"] += 1
        return {"result": PY_SCIP_RESULT.INFEASIBLE if self.flawed(self.theta(None)) else PY_SCIP_RESULT.FEASIBLE}

    @guarded({"result": PY_SCIP_RESULT.DIDNOTRUN})
    def conssepalp(self, constraints: Any, n_useful: Any) -> dict[str, Any]:
        """Separate a solution of the relaxation: two-cycles first, then flows."""
        if not self.fractional and not self.two_cycles:
            return {"result": PY_SCIP_RESULT.DIDNOTRUN}
        self.shared.counts["handler_calls"] += 1
        theta = self.theta(None)
        before = sum(self.shared.counts.values())
        cutoff = False
        if self.two_cycles:
            cutoff = self.add([two_cycles(matrix, LEAST) for matrix in theta], "two_cycle_cuts", force=False)
        if self.fractional:
            cutoff |= self.add([subtours(matrix, LEAST) for matrix in theta], "fractional_cuts", force=False)
        if cutoff:
            return {"result": PY_SCIP_RESULT.CUTOFF}
        found = sum(self.shared.counts.values()) > before
        return {"result": PY_SCIP_RESULT.SEPARATED if found else PY_SCIP_RESULT.DIDNOTFIND}

    def conslock(self, constraint: Any, locktype: Any, nlockspos: int, nlocksneg: int) -> None:
        """Tell SCIP that rows it does not see may be violated by moving θ or y either way."""
        model, both = self.shared.model, nlockspos + nlocksneg
        for variable in [*model.y.values(), *(v for theta in model.theta for v in theta.values())]:
            model.scip.addVarLocksType(variable, locktype, both, both)

    def arcs_of(self, theta: list[Floats]) -> list[list[Arc]]:
        """Return the arcs that each UAV flies in an integer solution."""
        n = self.shared.model.instance.n_tasks
        return [
            [(i if i < n else n + k, j if j < n else n + k) for i, j in np.argwhere(matrix > _INTEGER).tolist()]
            for k, matrix in enumerate(theta)
        ]

    def flawed(self, theta: list[Floats]) -> bool:
        """Return whether an integer solution has subtours or tours too long; offer its routes, subtours spliced in."""
        instance = self.shared.model.instance
        arcs_of, beyond = self.arcs_of(theta), False
        if routed_once([matrix > _INTEGER for matrix in theta]):
            self.shared.recorder.incumbent(repair(instance, arcs_of))
            beyond = bool(self.too_long(arcs_of))
        return beyond or any(
            find_subtours(arcs, instance.n_tasks + k, instance.n_tasks) for k, arcs in enumerate(arcs_of)
        )

    def too_long(self, arcs_of: list[list[Arc]]) -> list[tuple[int, list[int]]]:
        """Return the UAVs that fly beyond their endurance, each with its tour."""
        instance = self.shared.model.instance
        if instance.endurance is None:
            return []
        tours = [walk(arcs, instance.n_tasks + k)[1:] for k, arcs in enumerate(arcs_of)]
        return [(k, tours[k]) for k in too_long(instance, tours)]

    def add(self, found: list[tuple[Bools, Ints]], kind: str, *, force: bool) -> bool:
        """Add the cuts of the sets found, for every UAV; return whether SCIP saw that nothing is left."""
        cutoff = False
        for k, (sets, visited) in enumerate(found):
            for S, v in zip(sets, visited.tolist(), strict=True):
                cutoff |= self.add_cut(k, np.flatnonzero(S).tolist(), v, force)
                self.shared.counts[kind] += 1
        return cutoff

    def add_cut(self, k: int, S: list[int], v: int, force: bool) -> bool:
        """Add the depot-linked cut of S, v and UAV k in the form with fewer terms; return whether that ends the node.

        Either Σ_{i,j∈S} θ_ijk − Σ_{i∈S∖v} y_ik ≤ 0 or Σ_{i∉S,j∈S} θ_ijk − y_vk ≥ 0: valid in the whole tree.
        """
        model = self.shared.model
        scip, theta, n = model.scip, model.theta[k], model.instance.n_tasks
        inside = len(S) * len(S) <= len(S) * (n + 1 - len(S))
        lhs, rhs = (None, 0.0) if inside else (0.0, None)
        row = scip.createEmptyRowUnspec("subtour", lhs=lhs, rhs=rhs, local=False, removable=True)
        scip.cacheRowExtensions(row)
        members = set(S)
        sources = S if inside else [i for i in (*model.T, n + k) if i not in members]
        for i in sources:
            for j in S:
                if (i, j) in theta:
                    scip.addVarToRow(row, theta[i, j], 1.0)
        for i in (i for i in S if i != v) if inside else (v,):
            scip.addVarToRow(row, model.y[i, n + k], -1.0)
        scip.flushRowExtensions(row)
        return self.enter(row, force=force)

    def add_never(self, k: int, tour: list[int]) -> bool:
        """Cut off this tour of UAV k, valid in the whole tree: not all of its arcs at once."""
        model = self.shared.model
        scip, depot = model.scip, model.instance.n_tasks + k
        row = scip.createEmptyRowUnspec("endurance", lhs=None, rhs=float(len(tour)), local=False, removable=True)
        for arc in pairwise([depot, *tour, depot]):
            scip.addVarToRow(row, model.theta[k][arc], 1.0)
        self.shared.counts["lazy_cuts"] += 1
        return self.enter(row, force=True)

    def enter(self, row: Any, *, force: bool) -> bool:
        """Add a row as a cut and keep it; return whether SCIP saw that nothing is left."""
        scip = self.shared.model.scip
        cutoff: bool = scip.addCut(row, forcecut=force)
        scip.addPoolCut(row)
        scip.releaseRow(row)
        return cutoff


class Messenger(Eventhdlr):
    """Reports SCIP's dual bound, less the margin, whenever a relaxation or a node is solved."""

    events = (PY_SCIP_EVENTTYPE.LPSOLVED, PY_SCIP_EVENTTYPE.NODESOLVED)

    def __init__(self, shared: Shared) -> None:
        self.shared = shared

    def eventinit(self) -> None:
        """Listen."""
        for event in self.events:
            self.model.catchEvent(event, self)

    def eventexit(self) -> None:
        """Stop listening."""
        for event in self.events:
            self.model.dropEvent(event, self)

    @guarded({})
    def eventexec(self, event: Any) -> dict[str, Any]:
        """Report the bound; stop where the recorder has no time left (it may be told of a proof from outside)."""
        report_bound(self.shared)
        if self.shared.recorder.remaining == 0:
            self.shared.stopped = True
            self.model.interruptSolve()
        return {}


def report_bound(shared: Shared) -> None:
    """Offer SCIP's dual bound, less the margin, to the recorder."""
    dual = shared.model.scip.getDualbound()
    if 0 < dual <= shared.model.upper:
        shared.recorder.raise_bound(shared.model.seconds(dual) - shared.margin)


class Offers(Heur):
    """Hands the recorder's routes (repaired ones) to SCIP where they are better than SCIP's own."""

    timing = PY_SCIP_HEURTIMING.BEFORENODE | PY_SCIP_HEURTIMING.AFTERLPNODE

    def __init__(self, shared: Shared) -> None:
        self.shared = shared

    @guarded({"result": PY_SCIP_RESULT.DIDNOTRUN})
    def heurexec(self, heurtiming: Any, nodeinfeasible: Any) -> dict[str, Any]:
        """Offer better routes.

        Better by more than the margin: SCIP has fixed away what its own best solution needs, and that could be these.
        """
        recorder, model = self.shared.recorder, self.shared.model
        own = model.seconds(model.scip.getPrimalbound())
        if recorder.routes is None or recorder.objective >= own - self.shared.margin:
            return {"result": PY_SCIP_RESULT.DIDNOTRUN}
        solution = model.scip.createSol(self)
        model.fill(solution, recorder.routes)
        stored = model.scip.trySol(solution, printreason=False)
        return {"result": PY_SCIP_RESULT.FOUNDSOL if stored else PY_SCIP_RESULT.DIDNOTFIND}
