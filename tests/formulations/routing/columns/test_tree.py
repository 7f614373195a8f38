"""The tree: its bound holds at every moment, also while a node is worked on."""

import math

import numpy as np
import pytest

import formulations.routing.columns.tree as trees
from formulations.limits import Limits
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.legs import Legs
from formulations.routing.columns.tightening import tighten
from formulations.routing.recorder import Recorder
from formulations.routing.solver import ignore
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, makespan


@pytest.mark.parametrize("seed", [0, 1, 3, 5])
def test_the_bound_holds_while_a_node_is_worked_on(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    cost = rng.uniform(1, 10, (13, 13))
    np.fill_diagonal(cost, 0.0)
    instance = Instance("random", cost, 10, 3)
    best = makespan(instance, SubsetDp().solve(instance, limits=Limits(time=60)).routes)
    recorder, solver = Recorder(instance, Limits(time=60), ignore, None), BranchAndPrice(starts=0)
    recorder.incumbent((tuple(range(4)), (4, 5, 6), (7, 8, 9)))
    tree, seen = solver.tree(recorder, 0, lambda: np.inf, Legs.of(recorder.instance)), []

    def watched(*given):
        seen.append(tree.bound(math.inf))
        return tighten(*given)

    monkeypatch.setattr(trees, "tighten", watched)
    tree.grow(recorder, 1e-7, math.inf)
    assert recorder.objective == pytest.approx(best)
    assert seen
    assert max(seen) <= best * (1 + 1e-9)  # infinite where the node at hand is left out and no other is open
