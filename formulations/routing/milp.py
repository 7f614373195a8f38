"""milp: the paper's MILP with subtour cuts added lazily.

The paper on const6: "it is intractable to set up the subtour elimination constraint equation for every cases". So:
solve eqs. const1–const5 (``paper_model.py``); find the subtours of the solution (``subtours.py``); add const6 for every
set S found and every UAV; solve again, from the last solution repaired; stop when there is none. Each round solves a
relaxation, so its bound is a bound of the problem, and a solution without subtours is optimal.

Where endurance is limited, a round may end with tours that are too long by less than the integers of CP-SAT can tell
(``scaling.py``); each of them is cut off like a subtour.

CP-SAT cannot add rows during a search, hence the rounds. What is not in the paper is an option, on by default where
it helps (``strengthening.py``), so that a report can show what each is worth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from formulations.routing import cpsat, strengthening
from formulations.routing.cpsat import Values
from formulations.routing.model_solver import ModelSolver, cutoff, too_long
from formulations.routing.paper_model import PaperModel
from formulations.routing.recorder import Recorder
from formulations.routing.scaling import scale_costs
from formulations.routing.solver import Result
from formulations.routing.subtours import find_subtours, repair, walk
from formulations.routing.theta_count import why_too_large
from instances import Instance

MOST_THETA = 60_000
"""Beyond this building the model alone takes long; the proofs end far below (n ≈ 15)."""


@dataclass(frozen=True)
class Milp(ModelSolver):
    """The paper's MILP on CP-SAT; ``limits.iterations`` counts the rounds.

    depot_linked : subtour cuts in the stronger depot-linked form too, not const6 alone.
    two_cycles : cut all sets S of two tasks from the start.
    every_solution : cut the subtours of every solution a round passes on its way, not only of its last.
    symmetry : order UAVs that share a depot by their smallest task; with symmetric costs, fly each tour one way only.
    reach : C_max ≥ the way to each task and back from the UAV that visits it; drop θ that no tour within the
        incumbent can use.
    hint : start a round from the last solution repaired (its subtours spliced into tours).
    """

    proves: ClassVar[bool] = True
    axes: ClassVar[frozenset[str]] = frozenset({"fleet", "endurance"})
    counters: ClassVar[tuple[str, ...]] = ("rounds", "cuts")

    depot_linked: bool = True
    two_cycles: bool = True
    every_solution: bool = True
    symmetry: bool = True
    reach: bool = True
    hint: bool = True

    def accepts(self, instance: Instance) -> str | None:
        """Return why the instance is too large for the three-index form, or None."""
        return why_too_large(instance, MOST_THETA)

    def improve(self, recorder: Recorder, seed: int) -> Result:
        """Solve by rounds until no subtour is left."""
        return _Rounds(self, recorder, seed).run()


class _Rounds:
    """The rounds of one solve."""

    def __init__(self, options: Milp, recorder: Recorder, seed: int) -> None:
        self.options, self.recorder, self.seed = options, recorder, seed
        self.instance = instance = recorder.instance
        self.scaled = scale_costs(instance, cutoff(recorder))
        self.paper = PaperModel(instance, self.scaled)
        self.cuts: set[tuple[int, ...]] = set()
        self.found: list[list[int]] = []
        self.too_long: set[tuple[int, tuple[int, ...]]] = set()
        if options.two_cycles:
            self.add_cuts([[i, j] for i in instance.tasks for j in range(i)])
        if options.symmetry:
            strengthening.symmetry(self.paper, instance)
        if options.reach:
            strengthening.reach(self.paper, instance)

    def run(self) -> Result:
        """Solve, separate, cut and solve again."""
        recorder, rounds = self.recorder, 0
        while True:
            if recorder.remaining == 0:
                return self.result("time", rounds)
            if rounds == recorder.limits.iterations:
                return self.result("iterations", rounds)
            self.found, self.too_long = [], set()
            if self.options.hint and recorder.routes is not None:
                strengthening.hint(self.paper, self.instance, recorder.routes)
            ending = cpsat.search(self.paper.model, self.scaled, recorder, self.seed, self.on_solution)
            rounds += 1
            if recorder.objective - recorder.bound <= self.scaled.tolerance:
                return self.result("proof", rounds)
            if ending == "infeasible":
                return recorder.infeasible(rounds=rounds, cuts=len(self.cuts))
            if ending == "limit":
                return self.result("time", rounds)
            self.add_cuts(self.found)
            for k, tour in self.too_long:
                self.paper.never(k, tour)

    def on_solution(self, value: Values) -> None:
        """Offer the repaired routes of a solution; keep its subtours and tours too long for the next round."""
        theta, depots, n = self.paper.theta, self.instance.depots, self.instance.n_tasks
        arcs_of = [[(i, j) for i, j in self.paper.edges(k) if value(theta[i, j, k])] for k in depots]
        subtours = [S for k, arcs in zip(depots, arcs_of, strict=True) for S in find_subtours(arcs, k, n)]
        self.found = [*self.found, *subtours] if self.options.every_solution else subtours
        tours = [tuple(walk(arcs, k)[1:]) for k, arcs in zip(depots, arcs_of, strict=True)]
        self.too_long |= {(depots[k], tours[k]) for k in too_long(self.instance, tours)}
        self.recorder.incumbent(repair(self.instance, arcs_of))

    def add_cuts(self, sets: Sequence[Sequence[int]]) -> None:
        """Add const6 for each set S that has none yet."""
        for S in sets:
            key = tuple(sorted(S))
            if key in self.cuts:
                continue
            self.cuts.add(key)
            self.paper.const6(key)
            if self.options.depot_linked:
                self.paper.const6_depot_linked(key)

    def result(self, stopped_by: str, rounds: int) -> Result:
        """Write the Result."""
        proved, tolerance, cuts = stopped_by == "proof", self.scaled.tolerance, len(self.cuts)
        return self.recorder.result(stopped_by, proved=proved, tolerance=tolerance, rounds=rounds, cuts=cuts)
