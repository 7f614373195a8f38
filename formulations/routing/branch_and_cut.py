"""branch-and-cut: the paper's MILP in SCIP, subtour cuts (const6) added inside the tree.

``milp`` solves, separates and solves again from the start; here a constraint handler adds const6, in its depot-linked
form, to the one running search (``branch_and_cut_handler.py``), for integer solutions, as the paper has it, and for
fractional ones, by largest flows (``separation.py``). Branching goes first to the assignment of tasks to UAVs. After
Applegate, Cook, Dash & Rohe, "Solution of a min-max vehicle routing problem" (INFORMS J. Comput. 14, 2002).

Strong where tours are long (n/m ≥ about 20); where they are short, ``branch-and-price`` is.

Floating point. SCIP accepts rows violated by up to feastol = 1e-6 relatively, and reduced costs of the wrong sign by up
to dualfeastol = 1e-7. The routes it begins with cost U, 512 to 1024 in SCIP's unit, and any solution has at most n + m
arcs of θ = 1 besides C_max itself, so SCIP's dual bound is too high by at most feastol·U + (n + m + 1)·dualfeastol
units. Twice this margin is subtracted from every bound reported; costs of routes are recomputed from the float costs.
So OPTIMAL means: no routes are better by more than ``tolerance``, 4e-6·U and a little. Endurance is loosened as much in
SCIP, so INFEASIBLE has the same margin, and tours beyond it by less are cut off one by one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.branch_and_cut_handler import Messenger, Offers, Shared, SubtourHandler, report_bound
from formulations.routing.branch_and_cut_model import DUALFEASTOL, FEASTOL, ScipModel
from formulations.routing.capped_total import capped_total
from formulations.routing.model_solver import ModelSolver, cutoff
from formulations.routing.recorder import Recorder
from formulations.routing.search.ruin_recreate import RuinRecreate
from formulations.routing.separation import subtours, two_cycles
from formulations.routing.simple_bounds import SIMPLE
from formulations.routing.solver import Result
from formulations.routing.theta_count import why_too_large
from instances import Instance
from instances.arrays import Bools

MOST_THETA = 80_000
"""Beyond this building the model and its first relaxation alone take minutes."""
_MEMORY = 3500.0  # MB
_STEPS_A_TASK = 1000
_SHARE = 0.1  # of the time left, at most, for the arcs that are left out
_STOPPED = {"nodelimit": "iterations", "totalnodelimit": "iterations", "timelimit": "time", "memlimit": "memory"}

_TINY = Instance("warm-up", np.ones((5, 5)) - np.eye(5), 3, 2)


@dataclass(frozen=True)
class BranchAndCut(ModelSolver):
    """The paper's MILP on SCIP; ``limits.iterations`` counts the nodes of the tree.

    fractional : separate subtour cuts of fractional solutions by largest flows, not of integer ones alone.
    two_cycles : separate the sets S of two tasks by looking at all of them first.
    branch_on_visits : branch on which UAV visits which task before branching on arcs.
    symmetry : order UAVs that share a depot by their smallest task; with symmetric costs, fly each tour one way only.
    reach : C_max ≥ the way to each task and back from the UAV that visits it; drop θ that no tour within the
        incumbent can use.
    arcs : drop θ of arcs that the total bound of tours within the incumbent shows to be in no better routes.
    warm_start : begin from a short ruin-and-recreate search, not from greedy routes alone.
    """

    proves: ClassVar[bool] = True
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance"})

    fractional: bool = True
    two_cycles: bool = True
    branch_on_visits: bool = True
    symmetry: bool = True
    reach: bool = True
    arcs: bool = True
    warm_start: bool = True

    def accepts(self, instance: Instance) -> str | None:
        """Return why the instance is too large for the three-index form, or None."""
        return why_too_large(instance, MOST_THETA)

    def prepare(self, instance: Instance) -> None:
        """Compile the kernels."""
        super().prepare(instance)
        RuinRecreate().prepare(instance)
        subtours(np.zeros((2, 2)), 0.0)
        two_cycles(np.zeros((2, 2)), 0.0)
        capped_total(_TINY, 4.0, 60.0)

    def improve(self, recorder: Recorder, seed: int) -> Result:
        """Raise the bound by simple means, look for better routes, then `prove`."""
        for simple_bound in SIMPLE.values():
            recorder.raise_bound(simple_bound(recorder.instance, cutoff(recorder)))
        if self.warm_start:
            _warm_start(recorder, seed)
        if recorder.objective == 0:
            return recorder.result("proof", proved=True)
        if recorder.remaining == 0:
            return recorder.result("time")
        if recorder.limits.iterations == 0:
            return recorder.result("iterations")
        return self.prove(recorder, seed)

    def prove(self, recorder: Recorder, seed: int) -> Result:
        """Build the model, run SCIP below the recorder's incumbent and say how that ended."""
        instance = recorder.instance
        # twice what no routes exceed: a proof that there are none must not hang by it
        upper = recorder.objective if recorder.routes is not None else 2 * cutoff(recorder)
        arcs = _arcs(recorder) if self.arcs and recorder.routes is not None else None
        model = ScipModel(instance, upper, reach=self.reach, arcs=arcs)
        margin = 2 * model.seconds(model.slack)
        shared = Shared(model, recorder, margin)
        self._set_up(shared, seed)
        scip = model.scip
        if recorder.remaining == 0:  # building took it all; SCIP has no bound to ask for before it begins
            return recorder.result("time")
        scip.setParam("limits/time", recorder.remaining)
        scip.optimize()
        if shared.error is not None:
            raise shared.error
        status = scip.getStatus()
        if status == "userinterrupt" and not shared.stopped:
            raise KeyboardInterrupt
        if status == "infeasible" and recorder.routes is None:
            return recorder.infeasible(nodes=scip.getNTotalNodes(), **shared.counts)
        report_bound(shared)
        tolerance = 2 * margin
        proved = status == "optimal" and recorder.objective - recorder.bound <= tolerance
        limit = _STOPPED.get(status, "time" if recorder.remaining == 0 else "finished")
        counts = {"nodes": scip.getNTotalNodes(), **shared.counts}
        return recorder.result("proof" if proved else limit, proved=proved, tolerance=tolerance, **counts)

    def _set_up(self, shared: Shared, seed: int) -> None:
        """Set SCIP's parameters, add the rows asked for, the plugins and the routes known."""
        model, recorder = shared.model, shared.recorder
        scip = model.scip
        if self.symmetry:
            model.symmetry()
        for y in model.y.values():
            scip.markDoNotMultaggrVar(y)  # presolving must not replace y by sums of θ
            if self.branch_on_visits:
                scip.chgVarBranchPriority(y, 1)  # before θ: it settles many θ at once
        scip.setParams(
            {
                "numerics/feastol": FEASTOL,
                "numerics/dualfeastol": DUALFEASTOL,
                "timing/clocktype": 2,  # wall clock
                "limits/memory": _MEMORY,
                "randomization/randomseedshift": seed % 2**31,
                # reductions that keep one optimum only do not know of the cuts to come
                "misc/allowstrongdualreds": False,
                "misc/allowweakdualreds": False,
                "misc/usesymmetry": 0,
                "constraints/components/maxprerounds": 0,
            }
        )
        if recorder.limits.iterations is not None:
            scip.setParam("limits/totalnodes", recorder.limits.iterations)
        handler = SubtourHandler(shared, fractional=self.fractional, two_cycles=self.two_cycles)
        last = -5_000_000  # after all rows: they see integer solutions of const1–const5 only
        scip.includeConshdlr(
            handler, "subtours", "const6", 1_000_000, enfopriority=last, chckpriority=last, sepafreq=1, needscons=False
        )
        scip.includeEventhdlr(Messenger(shared), "bounds", "reports bounds")
        offers = Offers(shared)
        scip.includeHeur(offers, "offers", "routes found outside", "o", timingmask=offers.timing)
        solution = scip.createSol()
        if recorder.routes is not None:
            model.fill(solution, recorder.routes)
            scip.addSol(solution)


def _arcs(recorder: Recorder) -> Bools:
    """Raise the bound to the capped total, within a tenth of the time left; return the arcs it leaves, (N, N)."""
    found = capped_total(recorder.instance, recorder.objective, _SHARE * recorder.remaining)
    recorder.raise_bound(found.bound)
    return found.arcs


def _warm_start(recorder: Recorder, seed: int) -> None:
    """Run a short ruin-and-recreate from the routes known, within a tenth of the time left."""
    instance = recorder.instance
    steps = _STEPS_A_TASK * max(instance.n_tasks, 10)
    limits = Limits(time=max(recorder.remaining / 10, 1e-3), iterations=steps)
    found = RuinRecreate().solve(instance, limits=limits, seed=seed, start=recorder.routes)
    if found.routes is not None:
        recorder.incumbent(found.routes)
