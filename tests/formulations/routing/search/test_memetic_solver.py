"""What `memetic` and `ruin-recreate` promise as solvers."""

import itertools
import subprocess
import sys

import numpy as np
import pytest

from formulations.limits import Limits
from formulations.routing.registry import make_solver
from formulations.routing.solver import Status
from instances import InputError, Instance, check_routes, makespan

BOTH = pytest.mark.parametrize("name", ["memetic", "ruin-recreate"])


def random_instance(seed, n, m):
    cost = np.random.default_rng(seed).uniform(1.0, 100.0, (n + m, n + m))
    np.fill_diagonal(cost, 0.0)
    return Instance(f"random {seed}", cost, n, m)


def brute_force(instance):
    best = np.inf
    for order in itertools.permutations(instance.tasks):
        for cut in range(instance.n_tasks + 1):
            best = min(best, makespan(instance, (order[:cut], order[cut:])))
    return best


@BOTH
def test_finds_the_brute_force_optimum(name):
    for seed in range(3):
        instance = random_instance(seed, 6, 2)
        result = make_solver(name).solve(instance, limits=Limits(time=3600, iterations=5000))
        assert result.objective == pytest.approx(brute_force(instance))
        assert result.status == Status.FEASIBLE
        assert result.stopped_by == "iterations"


def test_finds_a_proved_optimum_of_twenty_tasks_in_wind():
    """Optimum 1578.891 s, proved by column generation (cost: straight legs in uniform wind plus rotation)."""
    xy = np.random.default_rng(20_300).uniform(0, 20_000, (23, 2)) - 10_000
    leg = xy[None] - xy[:, None]
    spin = xy[:, None, 0] * xy[None, :, 1] - xy[:, None, 1] * xy[None, :, 0]
    cost = np.hypot(leg[..., 0], leg[..., 1]) / 20 - (4 * leg[..., 0] - 2 * leg[..., 1]) / 400 - 5e-4 * spin / 400
    np.fill_diagonal(cost, 0.0)
    result = make_solver("memetic").solve(Instance("wind", cost, 20, 3), limits=Limits(time=3600, iterations=100_000))
    assert result.objective == pytest.approx(1578.891, abs=1e-3)


@BOTH
@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 4), (2, 1), (3, 7), (9, 1), (30, 4)])
def test_feasible_routes_and_honest_events_for_every_shape(name, n, m):
    instance = random_instance(n, n, m)
    events = []
    result = make_solver(name).solve(instance, limits=Limits(time=3600, iterations=3000), seed=1, observe=events.append)
    assert check_routes(instance, result.routes) == []
    assert result.objective == makespan(instance, result.routes)
    assert events[-1].routes == result.routes
    values = [event.objective for event in events]
    assert values == sorted(values, reverse=True)


@pytest.mark.parametrize(("n", "m", "threads"), [(5, 2, 1), (8, 5, 1), (8, 5, 2), (1, 4, 1)])
def test_where_all_costs_are_zero_it_is_finished_at_once(n, m, threads):
    instance = Instance("zero", np.zeros((n + m, n + m)), n, m)
    found = make_solver("memetic").solve(instance, limits=Limits(time=3600.0, threads=threads))
    assert (found.objective, found.stopped_by) == (0.0, "finished")
    assert not check_routes(instance, found.routes)


@BOTH
def test_same_seed_same_answer_other_seed_other_way(name):
    instance = random_instance(3, 60, 4)
    solver, limits = make_solver(name), Limits(time=3600, iterations=2000)
    first, again, other = (solver.solve(instance, limits=limits, seed=s) for s in (7, 7, 8))
    assert first.routes == again.routes
    assert [e.objective for e in first.trace] == [e.objective for e in again.trace]
    assert first.routes != other.routes


@BOTH
def test_never_worse_than_its_start(name):
    instance = random_instance(4, 25, 3)
    solver = make_solver(name)
    good = solver.solve(instance, limits=Limits(time=3600, iterations=5000)).routes
    result = solver.solve(instance, limits=Limits(time=3600, iterations=1), start=good)
    assert result.objective <= makespan(instance, good)


def test_the_clock_stops_it():
    result = make_solver("memetic").solve(random_instance(1, 20, 2), limits=Limits(time=0.3))
    assert result.stopped_by == "time"


@pytest.mark.parametrize("options", [{"removals": 0}, {"cuts": 1.5}, {"powers": 9}, {"depth": 0}, {"removal": 3}])
def test_options_that_cannot_be_used_are_named(options):
    with pytest.raises(InputError, match=next(iter(options))):
        make_solver("memetic", options)
    if "removals" in options or "removal" in options:
        with pytest.raises(InputError, match=next(iter(options))):
            make_solver("ruin-recreate", options)


COMPILED = """
import sys
import numpy as np
from numba.core.dispatcher import Dispatcher
from formulations.routing.registry import make_solver
from formulations.limits import Limits
from instances import Instance

def compiled():
    modules = [module for name, module in sys.modules.items() if name.startswith("formulations.routing.search.")]
    kernels = {kernel for module in modules for kernel in vars(module).values() if isinstance(kernel, Dispatcher)}
    return sum(len(kernel.signatures) + len(kernel.inner.signatures) for kernel in kernels)

cost = np.random.default_rng(6).uniform(1.0, 100.0, (34, 34)) * (1.0 - np.eye(34))
solver = make_solver("memetic")
for symmetric in (False, True):
    instance = Instance("any", cost + symmetric * cost.T, 30, 4)
    solver.prepare(instance)
    before = compiled()
    result = solver.solve(instance, limits=Limits(time=3600, iterations=400_000))
    assert result.statistics["stages"] > 20, result.statistics
    assert compiled() == before > 10, (before, compiled())

place = np.random.default_rng(7).uniform(0.0, 100.0, (302, 2))
place[301] = place[300]
instance = Instance("long-tours", np.hypot(*(place[:, None] - place).transpose(2, 0, 1)), 300, 2)
solver.prepare(instance)
before = compiled()
result = solver.solve(instance, limits=Limits(time=3600, iterations=20_000))
assert result.statistics["stages"] == 1, result.statistics  # edge assembly from then on
assert compiled() == before, (before, compiled())

place = np.random.default_rng(8).uniform(0.0, 100.0, (1020, 2))
place[1000:], place[999] = 50.0, 900.0
instance = Instance("far", np.hypot(*(place[:, None] - place).transpose(2, 0, 1)), 1000, 20)
solver.prepare(instance)
before = compiled()
result = solver.solve(instance, limits=Limits(time=3600, iterations=400_000))
assert result.statistics["stages"] == 7, result.statistics  # a founder, growth, chained search and parts in turn
assert compiled() == before, (before, compiled())
"""


def test_nothing_is_compiled_after_prepare():
    """No limit pays for compilation; in a process of its own, where no other test has compiled anything."""
    done = subprocess.run([sys.executable, "-c", COMPILED], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
