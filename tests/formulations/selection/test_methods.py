"""Every method against brute force, and the exact values that are known."""

import numpy as np
import pytest

from formulations.kernel import SquaredExponential
from formulations.limits import Limits
from formulations.routing.solver import Status
from formulations.selection.branch_and_price import BranchAndPrice
from formulations.selection.registry import METHODS
from formulations.selection.ruin_recreate import RuinRecreate
from formulations.selection.selection import SelectionProblem, select
from formulations.selection.subset_dp import SubsetDp
from formulations.selection.worth import Worth
from formulations.task_location.criterion import Criterion, convention
from instances import InputError, Instance, check_routes
from instances.travel import Travel

PROVING = {
    "subset-dp": SubsetDp(),
    "branch-and-price": BranchAndPrice(search_seconds=0.0),  # begins from nothing: what it claims is its own
}
CASES = [
    (n, m, seed, kind) for n, m, seed in ((5, 2, 0), (5, 3, 1), (6, 2, 2), (4, 1, 3)) for kind in ("prizes", "ig", "b")
]


def checked(found):
    problem = found.problem
    assert check_routes(problem.instance, found.routes, all_tasks=False) == []
    assert sorted(task for route in found.routes for task in route) == list(found.tasks)
    assert found.worth == pytest.approx(problem.worth.value(found.tasks), abs=1e-9)
    assert found.bound >= found.worth
    return found


@pytest.mark.parametrize(("n", "m", "seed", "kind"), CASES)
@pytest.mark.slow
def test_brute_force(problems, brute_force, n, m, seed, kind):
    problem = problems(n, m, seed, kind)
    best = brute_force(problem)
    for name, method in PROVING.items():
        found = checked(select(problem, method, name, limits=Limits(20.0)))
        assert found.status is Status.OPTIMAL, name
        assert found.worth == pytest.approx(best, rel=2e-6, abs=1e-9), name
        assert found.bound >= best
    found = checked(select(problem, RuinRecreate(), "ruin-recreate", limits=Limits(20.0, iterations=2000)))
    assert best * 0.99 <= found.worth <= best + 1e-9 <= found.bound + 2e-9


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100))
@pytest.mark.slow
def test_brute_force_at_length(problems, brute_force, seed):
    """By hand: pytest tests/formulations/selection -m slow."""
    n, m = 3 + seed % 4, 1 + seed % 3
    test_brute_force(problems, brute_force, n, m, seed, ("prizes", "ig", "b")[seed % 3 if seed % 2 else 0])


@pytest.mark.parametrize(
    ("limit", "nats", "tasks"),
    [
        (600, 3.401753, (1,)),
        (900, 6.126877, (1, 5)),
        (1200, 9.528619, (1, 4, 5)),
        (1500, 9.528619, (1, 4, 5)),
        (1800, 16.013501, (1, 2, 3, 4, 5)),
        (1977.2, 19.021663, (0, 1, 2, 3, 4, 5)),
    ],
)
def test_known_information_within_endurance(limit, nats, tasks):
    points = np.random.default_rng(6200).uniform(0, 20_000, (8, 2))
    cost = np.hypot(*(points[:, None] - points).transpose(2, 0, 1)) / 20
    instance = Instance("known", cost, 6, 2, points, endurance=np.full(2, float(limit)))
    kernel = SquaredExponential(30.0, (4000.0, 4000.0))
    worth = Worth.of_information(Criterion(kernel, points, None, 1.0, None, convention("ig")), points[:6])
    for name, method in PROVING.items():
        found = checked(select(SelectionProblem(instance, worth), method, name, limits=Limits(20.0)))
        assert (found.status, found.tasks) == (Status.OPTIMAL, tasks)
        assert found.worth == pytest.approx(nats, abs=1e-6)


def test_distinct_start_and_end():
    """Start (0,0), end (10,0), tasks at (5,0) and (0,-3): only the first lies on the way."""
    tasks, start, end = np.array([[5.0, 0], [0, -3]]), np.array([0.0, 0]), np.array([10.0, 0])
    cost = np.zeros((3, 3))
    cost[2, :2], cost[:2, 2] = np.hypot(*(tasks - start).T), np.hypot(*(tasks - end).T)
    cost[0, 1] = cost[1, 0] = np.hypot(5, 3)
    instance = Instance("open", cost, 2, 1, endurance=np.array([10.0]))
    for name, method in PROVING.items():
        found = select(SelectionProblem(instance, Worth.of_prizes([1.0, 100.0])), method, name, limits=Limits(20.0))
        assert (found.tasks, found.bound) == ((0,), 1.0)


def test_parts_of_what_fits_need_not_fit():
    """Without the triangle inequality a tour may be short only because of a task on the way."""
    far = 100.0
    cost = np.array([[0, 1, far], [far, 0, 1], [1, far, 0.0]])  # depot 2 → 0 → 1 → depot
    instance = Instance("detour", cost, 2, 1, endurance=np.array([3.0]))
    for name, method in PROVING.items():
        found = checked(select(SelectionProblem(instance, Worth.of_prizes([1.0, 1.0])), method, name))
        assert (found.worth, found.status) == (2.0, Status.OPTIMAL)


@pytest.mark.parametrize("name", METHODS.built_in)
@pytest.mark.slow
def test_nothing_fits_and_everything_fits(problems, name):
    given = problems(5, 2, 4).instance
    worth = Worth.of_prizes([1.0, 2.0, 3.0, 4.0, 5.0])
    for endurance, value in ((np.full(2, 1.0), 0.0), (np.full(2, np.inf), 15.0)):
        instance = Instance.of_travel("all", given.travel, 5, endurance=endurance)
        found = select(SelectionProblem(instance, worth), METHODS.make(name), name, limits=Limits(20.0))
        assert (found.worth, found.bound, found.status) == (value, value, Status.OPTIMAL)


def test_prizes_of_nothing_are_proved_at_once(problems):
    instance = problems(5, 2, 4).instance
    found = select(SelectionProblem(instance, Worth.of_prizes(np.zeros(5))), SubsetDp(), "subset-dp")
    assert (found.worth, found.status, found.gap) == (0.0, Status.OPTIMAL, 0.0)


def test_a_task_no_uav_can_fly_is_left_out():
    cost = np.ones((5, 5)) - np.eye(5)
    cost[1, [0, 2, 3, 4]] = cost[[0, 2, 3, 4], 1] = np.inf
    instance = Instance.of_travel("apart", Travel.of_uavs([cost, cost]), 3)
    for name, method in PROVING.items():
        found = checked(select(SelectionProblem(instance, Worth.of_prizes([1.0, 50.0, 1.0])), method, name))
        assert (found.tasks, found.bound) == ((0, 2), 2.0)


@pytest.mark.slow
def test_iterations_repeat(problems):
    problem = problems(8, 2, 0, "ig")
    runs = [select(problem, RuinRecreate(), "r", seed=3, limits=Limits(60.0, iterations=50)) for _ in range(2)]
    assert runs[0].routes == runs[1].routes
    assert runs[0].trace[-1][1] == runs[1].trace[-1][1]


def test_too_many_tasks_for_all_sets():
    instance = Instance("large", np.ones((20, 20)) - np.eye(20), 19, 1)
    with pytest.raises(InputError, match="subset-dp: all 2\\^n sets are looked at: at most 18 tasks, not 19"):
        select(SelectionProblem(instance, Worth.of_prizes(np.ones(19))), SubsetDp(), "subset-dp")
