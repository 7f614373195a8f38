import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instances import Instance, as_routes, check_routes, makespan, tour_costs


@st.composite
def instances_with_routes(draw):
    n, m = draw(st.integers(1, 8)), draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    cost = rng.uniform(0, 10.0 ** rng.integers(-6, 10), (n + m, n + m))
    np.fill_diagonal(cost, 0)
    order, home = rng.permutation(n), rng.integers(0, m, n)
    routes = as_routes([task for task in order if home[task] == k] for k in range(m))
    return Instance("x", cost, n, m), routes


def naive_costs(instance, routes):
    """Eq. costsum leg by leg."""
    costs = []
    for k, route in enumerate(routes):
        depot, here, total = instance.n_tasks + k, instance.n_tasks + k, 0.0
        for task in route:
            total += float(instance.cost[here, task])
            here = task
        costs.append(total + float(instance.cost[here, depot]))
    return costs


@settings(deadline=None)
@given(instances_with_routes())
def test_costs_are_the_sum_of_the_legs(case):
    instance, routes = case
    assert check_routes(instance, routes) == []
    assert tour_costs(instance, routes) == pytest.approx(naive_costs(instance, routes), rel=1e-12)
    assert makespan(instance, routes) == max(tour_costs(instance, routes))


@settings(deadline=None)
@given(instances_with_routes(), st.floats(1e-6, 1e6))
def test_scaled_costs_scale_and_reversed_routes_cost_the_transpose(case, factor):
    instance, routes = case
    scaled = Instance("x", instance.cost * factor, instance.n_tasks, instance.n_depots)
    assert tour_costs(scaled, routes) == pytest.approx(factor * tour_costs(instance, routes), rel=1e-9)
    transposed = Instance("x", instance.cost.T, instance.n_tasks, instance.n_depots)
    backwards = [route[::-1] for route in routes]
    assert tour_costs(transposed, backwards) == pytest.approx(tour_costs(instance, routes), rel=1e-9)


@settings(deadline=None)
@given(instances_with_routes(), st.data())
def test_every_single_fault_is_found(case, data):
    instance, routes = case
    spoiled = [list(route) for route in routes]
    k = data.draw(st.integers(0, len(spoiled) - 1))
    fault = data.draw(st.sampled_from(["drop", "repeat", "depot", "negative", "shorter", "longer"]))
    if fault == "drop":
        victim = next(i for i, route in enumerate(spoiled) if route)
        spoiled[victim].pop()
    elif fault == "repeat":
        spoiled[k].append(0)
    elif fault == "depot":
        spoiled[k].append(instance.n_tasks)
    elif fault == "negative":
        spoiled[k].append(-1)
    elif fault == "shorter":
        spoiled.pop()
    else:
        spoiled.append([])
    assert check_routes(instance, spoiled)


def test_the_sentences_name_the_task():
    instance = Instance("x", np.zeros((5, 5)), 3, 2)
    faults = check_routes(instance, [[0, 0], [7]])
    assert faults == [
        "UAV 1 visits 7, which is not a task (tasks are 0 to 2).",
        "Task 1 is visited by no route.",
        "Task 2 is visited by no route.",
        "Task 0 is visited 2 times.",
    ]


def test_a_uav_that_stays_home_costs_nothing():
    instance = Instance("x", [[0, 2, 5], [3, 0, 1], [7, 1, 0]], 1, 2)
    assert tour_costs(instance, [[0], []]).tolist() == [5.0, 0.0]
    assert tour_costs(instance, [[], [0]]).tolist() == [0.0, 12.0]


def test_tasks_may_be_left_out_where_that_is_said():
    instance = Instance("left-out", np.ones((4, 4)) - np.eye(4), 3, 1)
    assert check_routes(instance, [(2,)], all_tasks=False) == []
    assert len(check_routes(instance, [(2,)])) == 2
    assert check_routes(instance, [(2, 2)], all_tasks=False) == ["Task 2 is visited 2 times."]
