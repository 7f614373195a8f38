"""Certificates: a branch and price whose proof is kept, for `instances.certificate` to check.

The tree is that of `branch-and-price`; bounds from elsewhere (simple ones, bisection) are not used, so that the whole
proof is in it. Where time ends first, what is certified is the bound reached.
"""

from __future__ import annotations

from formulations.limits import Limits
from formulations.routing.branch_and_price import TOLERANCE, BranchAndPrice
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.proof_log import KeptProof
from formulations.routing.recorder import Recorder
from formulations.routing.solver import ignore, refusal
from instances import InputError, Instance, Routes
from instances.certificate import Certificate

_BELOW = 1e-9
"""Share by which the bound claimed is below the one found: room for rounding in the check."""


def certify(
    instance: Instance,
    *,
    limits: Limits,
    seed: int = 0,
    start: Routes | None = None,
    solver: BranchAndPrice | None = None,
) -> Certificate:
    """Prove a lower bound on the longest tour of `instance`, from the routes of `start` on where given.

    The better `start`, the less there is to prove; `solver` has other options than as they come. InputError where
    columns do not take the instance, or no bound was reached in time.
    """
    solver = solver or BranchAndPrice()
    reason = refusal(solver, instance)
    others = {"time": "change with time", "states": "depend on the state of a node"}
    reason = next((f"its costs {what}" for axis, what in others.items() if axis in instance.axes), reason)
    if reason:
        raise InputError(f"{instance.name} cannot be certified: {reason}")
    recorder, log = Recorder(instance, limits, ignore, start), KeptProof()
    if start is None:
        solver.improve(recorder, 1000 * seed, solver.starts)
    tree = solver.tree(recorder, seed, lambda: recorder.remaining <= 0, Legs.of(instance), log=log)
    tree.grow(recorder, TOLERANCE, float("inf") if limits.iterations is None else limits.iterations)
    tree.close()
    bound = min(log.bound, recorder.objective * (1 - TOLERANCE), tree.most) * (1 - _BELOW)
    if not bound > 0:
        raise InputError(f"{instance.name}: no bound was reached in {limits.time:g} s")
    objective = None if recorder.routes is None else recorder.objective
    nodes, steps = tuple(log.nodes), tuple(log.steps)
    return Certificate(instance.name, instance.digest, bound, objective, recorder.routes or (), nodes, steps)
