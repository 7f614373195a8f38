"""`exact`: the portfolio. All sets where they are few, else a search and then columns from what it found."""

from __future__ import annotations

from dataclasses import dataclass

from formulations.selection.branch_and_price import BranchAndPrice
from formulations.selection.selection import Record, SelectionMethod, SelectionProblem
from formulations.selection.subset_dp import LARGEST, SubsetDp


@dataclass(frozen=True)
class Exact(SelectionMethod):
    """Subset programming to 18 tasks, branch-and-price beyond."""

    def method(self, problem: SelectionProblem) -> SelectionMethod:
        """Return the method for a problem of this size."""
        return SubsetDp() if problem.instance.n_tasks <= LARGEST else BranchAndPrice()

    def accepts(self, problem: SelectionProblem) -> str | None:
        """Ask the method for this size."""
        return self.method(problem).accepts(problem)

    def prepare(self, problem: SelectionProblem) -> None:
        """Compile what that method needs."""
        self.method(problem).prepare(problem)

    def search(self, problem: SelectionProblem, record: Record, seed: int) -> str:
        """Solve by that method."""
        return self.method(problem).search(problem, record, seed)
