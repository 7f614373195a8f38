"""Strong branching: on a task that several UAVs may take, by trials that leave the master as it was."""

import numpy as np
import pytest

from formulations.routing.columns.branching import choose
from formulations.routing.columns.master import Master
from formulations.routing.columns.pricing import Column


def shared_tasks() -> tuple[Master, float]:
    """Task 0 (far) costs the same on either UAV; task 1 (near) nearly closes the gap wherever it goes."""
    master = Master(2, np.arange(2), 1000.0)
    costs = {(0, 0): 50.0, (1, 0): 50.0, (0, 1): 20.0, (1, 1): 20.0}
    master.add([Column(k, (i,), cost) for (k, i), cost in costs.items()])
    master.add([Column(k, (0, 1), 60.0) for k in range(2)])
    return master, master.solve()[0]


def test_a_trial_leaves_the_master_as_it_was() -> None:
    master, value = shared_tasks()
    trials = [master.without(np.array([c.uav == k for c in master.columns]), 100) for k in range(2)]
    assert trials == pytest.approx([60.0, 60.0])
    assert master.solve()[0] == pytest.approx(value)


@pytest.mark.parametrize("gap", [1.0, 1e6])
def test_a_branch_is_on_a_task_that_several_may_take(gap: float) -> None:
    master, _ = shared_tasks()
    far, only_far = np.array([90.0, 30.0]), np.array([[True, False], [True, True]])
    branch = choose(master, only_far, far, gap, lambda: np.inf)
    assert branch is not None
    assert branch[1] == 0
    assert choose(master, np.eye(2, dtype=bool), far, gap, lambda: np.inf) is None


@pytest.mark.parametrize("seed", range(40))
def test_no_branch_on_a_task_that_is_decided(seed: int) -> None:
    """Whatever its price: any costs make some prices negative, tours without the task being dearer than with it."""
    rng = np.random.default_rng(seed)
    allowed = rng.random((3, 6)) < 0.6
    allowed[rng.integers(3, size=6), np.arange(6)] = True
    master = Master(6, np.arange(3), 1000.0)
    for k in np.repeat(np.arange(3), 8):
        tasks = np.flatnonzero(allowed[k] & (rng.random(6) < 0.6))
        if tasks.size:
            master.add([Column(int(k), tuple(tasks.tolist()), float(rng.uniform(1, 100)))])
    branch = choose(master, allowed, rng.uniform(1, 100, 6), 50.0, lambda: np.inf)
    undecided = allowed & (allowed.sum(axis=0) > 1)
    assert branch is None if not undecided.any() else branch is not None and undecided[branch]
