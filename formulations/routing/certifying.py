"""Certificates: a tree over tours or over arcs whose proof is kept, for `instances.certificate` to check.

The tree is that of `branch-and-price` or of `arc-tree`; bounds from elsewhere (simple ones, bisection) are not used, so
that the whole proof is in it. Where time ends first, what is certified is the bound reached.
"""

from __future__ import annotations

from typing import NamedTuple

from formulations.limits import Limits
from formulations.routing.arc_tree import ArcTree
from formulations.routing.arcs.proof import KeptArcProof
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.proof_log import KeptProof
from formulations.routing.proved import TOLERANCE
from formulations.routing.recorder import Recorder
from formulations.routing.search_beside import first_routes
from formulations.routing.simple_bounds import worst_makespan
from formulations.routing.solver import ignore, refusal
from instances import InputError, Instance, Routes
from instances.certificate import Blossom, Certificate, Crowd, Cut, Node, Step

_BELOW = 1e-9
"""Share by which the bound claimed is below the one found: room for rounding in the check."""
_LONG = 15
"""Tasks a UAV from which arcs prove more than tours."""


def certifier(instance: Instance) -> BranchAndPrice | ArcTree:
    """Return the solver whose proofs get farther: over arcs where tours are long, else over tours."""
    over_arcs = ArcTree()
    long = instance.n_tasks >= _LONG * instance.n_depots
    return over_arcs if long and refusal(over_arcs, instance) is None else BranchAndPrice()


def certify(
    instance: Instance,
    *,
    limits: Limits,
    seed: int = 0,
    start: Routes | None = None,
    solver: BranchAndPrice | ArcTree | None = None,
) -> Certificate:
    """Prove a lower bound on the longest tour of `instance`, from the routes of `start` on where given.

    The better `start`, the less there is to prove; `solver` says over what and with what options, the `certifier` as it
    comes where it is not given. InputError where it does not take the instance, or no bound was reached in time.
    """
    solver = solver or certifier(instance)
    reason = refusal(solver, instance)
    others = {"time": "change with time", "states": "depend on the state of a node"}
    reason = next((f"its costs {what}" for axis, what in others.items() if axis in instance.axes), reason)
    if reason:
        raise InputError(f"{instance.name} cannot be certified: {reason}")
    recorder = Recorder(instance, limits, ignore, start)
    if recorder.routes is None:
        first_routes(recorder, 1000 * seed, solver.starts)
    kept = _over_arcs(recorder, seed, solver) if isinstance(solver, ArcTree) else _over_tours(recorder, seed, solver)
    bound = min(kept.bound, recorder.objective * (1 - TOLERANCE), kept.most) * (1 - _BELOW)
    if not bound > 0:
        raise InputError(f"{instance.name}: no bound was reached in {limits.time:g} s")
    objective = None if recorder.routes is None else recorder.objective
    nodes, steps = tuple(kept.nodes), tuple(kept.steps)
    about = (instance.name, instance.digest, bound, objective, recorder.routes or ())
    return Certificate(*about, nodes, steps, kept.cuts, kept.joint)


class _Kept(NamedTuple):
    """The bound reached [s], a cost that no routes pass [s], and the parts of the certificate."""

    bound: float
    most: float
    nodes: list[Node]
    steps: list[Step]
    cuts: tuple[Cut, ...] = ()
    joint: tuple[Blossom | Crowd, ...] = ()


def _over_tours(recorder: Recorder, seed: int, solver: BranchAndPrice) -> _Kept:
    log = KeptProof()
    tree = solver.tree(recorder, seed, lambda: recorder.remaining, Legs.of(recorder.instance), log=log)
    tree.grow(recorder, TOLERANCE, _nodes(recorder))
    tree.close()
    return _Kept(log.bound, tree.most, log.nodes, log.steps)


def _over_arcs(recorder: Recorder, seed: int, solver: ArcTree) -> _Kept:
    instance = recorder.instance
    most = worst_makespan(instance) if instance.restricted else float("inf")
    unit = min(recorder.objective, most)
    proof = KeptArcProof(instance.n_depots, instance.n_tasks, unit)
    tree = solver.tree(recorder, seed, unit, proof)
    tree.grow(recorder, lambda: min(recorder.objective * (1 - TOLERANCE), most), _nodes(recorder))
    tree.close()
    return _Kept(unit * proof.bound, most, proof.nodes, proof.steps, proof.cuts, proof.joint)


def _nodes(recorder: Recorder) -> float:
    return float("inf") if recorder.limits.iterations is None else recorder.limits.iterations
