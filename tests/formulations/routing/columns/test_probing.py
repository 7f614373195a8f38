"""The root's relaxation under lower caps: bounds stay bounds, and the tree still ends at the optimum."""

from itertools import pairwise

import numpy as np
import pytest

import formulations.routing.columns.tree as trees
from formulations.limits import Limits
from formulations.routing.branch_and_price import BranchAndPrice
from formulations.routing.columns.tightening import tighten
from formulations.routing.recorder import Recorder
from formulations.routing.solver import ignore
from formulations.routing.subset_dp import SubsetDp
from instances import Instance, makespan


@pytest.mark.parametrize("seed", [0, 1, 3, 5])
def test_lower_caps_at_the_root_leave_the_optimum_as_it_is(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    cost = rng.uniform(1, 10, (13, 13))
    np.fill_diagonal(cost, 0.0)
    instance = Instance("random", cost, 10, 3)
    best = makespan(instance, SubsetDp().solve(instance, limits=Limits(time=60)).routes)
    caps = []

    def watched(node, cap, *others):
        caps.append(cap)
        return tighten(node, cap, *others)

    monkeypatch.setattr(trees, "tighten", watched)
    monkeypatch.setattr(trees, "_WIDE", -1.0)
    monkeypatch.setattr(trees, "_HOPELESS", 2.0)
    recorder = Recorder(instance, Limits(time=60), ignore, None)
    recorder.incumbent((tuple(range(4)), (4, 5, 6), (7, 8, 9)))
    BranchAndPrice(starts=0).prove(recorder, 0)
    assert recorder.objective == pytest.approx(best)
    assert recorder.bound <= best * (1 + 1e-9)
    assert any(after > before for before, after in pairwise(caps)), "no lower cap was tried: others never rise"
