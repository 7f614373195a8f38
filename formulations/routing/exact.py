"""`exact`: the portfolio to try first. It chooses, combines, and says who proved it.

* n ≤ 16, with several states a node n ≤ 10: `subset-dp`, which is then done at once.
* otherwise `branch-and-price`, which closes tours of up to about twenty tasks each in seconds;
* with two threads, where UAVs are few for the tasks, or of at most two kinds, cuts run beside it in a process of their
  own, for longer tours: both pass on every better incumbent and bound the moment they have it, and the first proof ends
  both; else columns look for tours of two UAVs at once;
* with one thread and two UAVs for many tasks, cuts for three quarters of the time, then columns with what these found.

Cuts are `branch-and-cut` of two UAVs, `arc-tree` of three and more.
Methods that do not take the instance's axes are left out; with a window of take-off only `subset-dp` is left.
A proof without routes is one that there are none.

Where the change-over points come from: README.md in this folder. ``Result.statistics["proved_by"]`` names the method
whose bound met the incumbent.
"""

from __future__ import annotations

import contextlib
import dataclasses
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, ClassVar

import numpy as np

from formulations.limits import Limits
from formulations.routing.arc_tree import ArcTree
from formulations.routing.branch_and_cut import BranchAndCut
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.legs import Legs
from formulations.routing.peer import Peer
from formulations.routing.proved import left_open
from formulations.routing.recorder import LinkedRecorder, RecordedSolver, Recorder
from formulations.routing.search_beside import first_routes
from formulations.routing.solver import Observer, Result, Status, ignore, refusal
from formulations.routing.stateless import stateless
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, Routes

FEW = 16
"""Tasks up to which subset programming takes a fraction of a second."""
FEW_BETWEEN_STATES = 10
"""The same where nodes have several states."""
LONG, FEW_UAVS, FEW_KINDS = 18, 3, 2
"""Tasks per UAV from which, and UAVs up to which, cuts prove what columns do not; and kinds in which they do."""
TWO = 2
"""UAVs up to which `branch-and-cut` is the quicker with cuts."""
_CUTS_FIRST = 0.75
_PROVED = (Status.OPTIMAL, Status.INFEASIBLE)


@dataclass(frozen=True)
class Exact(RecordedSolver):
    """The portfolio of exact methods."""

    proves: ClassVar[bool] = True
    axes: ClassVar[frozenset[str]] = BranchAndPrice.axes & SubsetDp.axes | {"window"}
    recorder: ClassVar[type[Recorder]] = LinkedRecorder

    def accepts(self, instance: Instance) -> str | None:
        """Refuse what `branch-and-price` refuses; where take-off is within a window what `subset-dp` does."""
        if "window" in instance.axes:
            return SubsetDp().accepts(instance)
        return BranchAndPrice().accepts(instance)

    def prepare(self, instance: Instance) -> None:
        """Prepare the methods that this instance will use."""
        if _few(instance):
            SubsetDp().prepare(instance)
            return
        BranchAndPrice().prepare(instance)
        _cuts(instance)[1].prepare(instance)

    def search(self, recorder: Recorder, seed: int) -> Result:
        """Solve to proof or limit; `limits.iterations` counts nodes of each tree."""
        instance = recorder.instance
        if _few(instance):
            result = SubsetDp().search(recorder, seed)
            proved_by = "subset-dp" if result.status in _PROVED else None
            return dataclasses.replace(result, statistics={**result.statistics, "proved_by": proved_by})
        assert isinstance(recorder, LinkedRecorder)
        columns = BranchAndPrice()
        first_routes(recorder, 1000 * seed, columns.starts)
        if recorder.objective > 0 and refusal(_cuts(instance)[1], instance) is None:
            few = instance.n_depots <= FEW_UAVS and instance.n_tasks >= LONG * instance.n_depots
            if recorder.limits.threads >= 2 and (few or _kinds(instance) <= FEW_KINDS):
                return _side_by_side(recorder, columns, seed)
            if few and instance.n_depots <= TWO:
                return _one_after_the_other(recorder, columns, seed)
        ended, counts = columns.prove(recorder, seed, recorder.limits.threads)
        return _result(recorder, ended, "branch-and-price", left_open(recorder), counts)


def _few(instance: Instance) -> bool:
    """Say whether subset programming is the method."""
    return instance.n_tasks <= (FEW_BETWEEN_STATES if "states" in instance.axes else FEW)


def _kinds(instance: Instance) -> int:
    """Return how many kinds of UAVs there are, by costs, endurance and depot."""
    return np.unique(Legs.of(stateless(instance)).kinds()).size


def _cuts(instance: Instance) -> tuple[str, BranchAndCut | ArcTree]:
    """Return the method with cuts, and its name."""
    return ("branch-and-cut", BranchAndCut()) if instance.n_depots <= TWO else ("arc-tree", ArcTree())


def _one_after_the_other(recorder: Recorder, columns: BranchAndPrice, seed: int) -> Result:
    """Cuts, and columns with what these found."""
    limits = dataclasses.replace(recorder.limits, time=max(_CUTS_FIRST * recorder.remaining, 1e-3))
    own = Recorder(recorder.instance, limits, _into(recorder), recorder.routes)
    own.raise_bound(recorder.bound)
    by, cuts = _cuts(recorder.instance)
    cut = cuts.prove(own, seed)
    counts = {f"cut_{name}": value for name, value in cut.statistics.items()}
    if cut.status in _PROVED or recorder.remaining <= 0:
        return _result(recorder, cut.stopped_by, by, cut.tolerance, counts)
    ended, own_counts = columns.prove(recorder, seed, recorder.limits.threads)
    return _result(recorder, ended, "branch-and-price", left_open(recorder), {**own_counts, **counts})


def _into(recorder: Recorder) -> Observer:
    """Return an observer that passes incumbents and bounds on to `recorder`."""

    def observe(event: Any) -> None:
        if event.routes is not None:
            recorder.incumbent(event.routes)
        if event.bound is not None:
            recorder.raise_bound(event.bound)

    return observe


def _side_by_side(recorder: LinkedRecorder, columns: BranchAndPrice, seed: int) -> Result:
    """Columns here, cuts in another process."""
    limits = Limits(time=max(recorder.remaining, 1e-3), iterations=recorder.limits.iterations)
    peer = Peer(_cut_beside, recorder.instance, limits, seed, recorder.routes)
    recorder.link = peer.link
    try:
        ended, counts = columns.prove(recorder, seed)
        while ended != "proof" and recorder.remaining > 0 and recorder.link is not None:
            peer.link.poll(min(recorder.remaining, 0.1))
        by = "branch-and-price" if ended == "proof" else _cuts(recorder.instance)[0]
        tolerance = left_open(recorder)
        if recorder.met_by_peer:
            ended, tolerance = "proof", recorder.tolerance
    finally:
        peer.end()
    return _result(recorder, ended, by, tolerance, counts)


def _cut_beside(link: Connection, instance: Instance, limits: Limits, seed: int, start: Routes | None) -> None:
    """Prove with cuts in this process and keep the peer informed."""
    recorder = LinkedRecorder(instance, limits, ignore, start)
    recorder.link = link
    with contextlib.suppress(KeyboardInterrupt):  # how SCIP says that it was interrupted: the peer was first
        result = _cuts(instance)[1].prove(recorder, seed)
        if result.status in _PROVED:
            recorder.tell_proof(result.tolerance)
    link.close()


def _result(recorder: Recorder, ended: str, by: str, tolerance: float, counts: dict[str, Any]) -> Result:
    """Write the result; a bound of one method and routes of another prove together."""
    if ended == "proof" and recorder.routes is None:
        return recorder.infeasible(proved_by=by, **counts)
    if recorder.routes is not None and recorder.objective - recorder.bound <= tolerance:
        return recorder.result("proof", proved=True, tolerance=tolerance, proved_by=by, **counts)
    return recorder.result("time" if ended == "proof" else ended, proved_by=None, **counts)
