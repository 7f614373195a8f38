"""Small problems of selection, and the oracle: every set, every partition, every order."""

import itertools

import numpy as np
import pytest

from formulations.kernel import SquaredExponential
from formulations.selection.selection import SelectionProblem
from formulations.selection.worth import Worth
from formulations.task_location.criterion import Criterion, convention
from instances import Instance, tour_costs
from instances.routes import ENDURANCE_ROUNDING
from instances.travel import Travel


def information(points, criterion="ig"):
    tests = np.random.default_rng(7).uniform(0, 20_000, (12, 2))
    kernel = SquaredExponential(30.0, (4000.0, 4000.0))
    return Worth.of_information(Criterion(kernel, tests, None, 1.0, None, convention(criterion)), points)


def problem(n, m, seed, kind="prizes", fleet=True):
    """Return a random problem: asymmetric costs, UAVs of their own speed, task and endurance; `kind` of worth."""
    rng = np.random.default_rng(1000 * n + 100 * m + seed)
    points = rng.uniform(0, 20_000, (n + m, 2))
    base = np.hypot(*(points[:, None] - points).transpose(2, 0, 1)) / 20 * rng.uniform(0.9, 1.1, (n + m, n + m))
    np.fill_diagonal(base, 0)
    more = {}
    costs = [base / speed for speed in (rng.uniform(0.7, 1.5, m) if fleet else np.ones(m))]
    if fleet and n > 2:
        costs[0][1, :] = costs[0][:, 1] = np.inf
        costs[0][1, 1] = 0.0
    more["endurance"] = rng.uniform(600, 2200, m) if fleet else np.full(m, 1200.0)
    instance = Instance.of_travel("small", Travel.of_uavs(costs), n, coordinates=points, **more)
    worth = Worth.of_prizes(rng.integers(1, 20, n) * 5.0) if kind == "prizes" else information(points[:n], kind)
    return SelectionProblem(instance, worth)


def best_worth(problem):
    """Return the best worth by looking at every assignment of tasks to UAVs or nobody, and every order."""
    instance, n, m = problem.instance, problem.instance.n_tasks, problem.instance.n_depots
    fits = {}
    for k in range(m):
        for size in range(n + 1):
            for tasks in itertools.combinations(range(n), size):
                least = min(
                    float(tour_costs(instance, [order if u == k else () for u in range(m)])[k])
                    for order in itertools.permutations(tasks)
                )
                fits[k, tasks] = least <= instance.limits[k] * (1 + ENDURANCE_ROUNDING)
    worths = [0.0]
    for homes in itertools.product(range(m + 1), repeat=n):
        parts = [tuple(i for i in range(n) if homes[i] == k) for k in range(m)]
        if all(fits[k, part] for k, part in enumerate(parts)):
            worths.append(problem.worth.value([i for part in parts for i in part]))
    return max(worths)


@pytest.fixture
def problems():
    return problem


@pytest.fixture
def brute_force():
    return best_worth
