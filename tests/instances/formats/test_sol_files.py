import contextlib

import numpy as np
import pytest
import vrplib
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from instances import InputError, Instance, as_routes, makespan
from instances.files import read_routes, write_routes
from instances.formats.sol import read_solution


def instance_of(n, m, seed=0):
    cost = np.random.default_rng(seed).uniform(0, 100, (n + m, n + m))
    np.fill_diagonal(cost, 0)
    return Instance("x", cost, n, m)


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(1, 12), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_routes_round_trip_empty_ones_included(tmp_path, n, m, seed):
    instance = instance_of(n, m, seed)
    rng = np.random.default_rng(seed)
    home = rng.integers(0, m, n)
    routes = as_routes([int(t) for t in rng.permutation(n) if home[t] == k] for k in range(m))
    write_routes(routes, instance, tmp_path / "a.sol")
    assert read_solution(tmp_path / "a.sol", instance) == (routes, makespan(instance, routes))
    others = vrplib.read_solution(tmp_path / "a.sol")
    assert as_routes(others["routes"]) == as_routes([[m + task for task in route] for route in routes])
    assert others["cost"] == makespan(instance, routes)


def test_routes_may_be_left_out_and_come_in_any_order(tmp_path):
    (tmp_path / "a.sol").write_text("# remark\nRoute #3: 2 0\n\nroute 1 : 1\n")
    assert read_solution(tmp_path / "a.sol", instance_of(3, 3)) == (((1,), (), (2, 0)), None)


OLD = "# x, digest 0123456789ab: tasks are numbered from 0, route k starts and ends at node 2 + k\n"
NEW = "# x, digest 0123456789ab: Cost is that of the longest route [s]\n# customers 2-4 are the tasks, in order\n"
GAPS = "# customers 1,4-5 are the tasks\n"


@pytest.mark.parametrize(
    ("text", "routes"),
    [
        (OLD + "Route #1: 2 1\nRoute #2: 0\n", ((2, 1), (0,))),  # as all were until the end of 2026
        (NEW + "Route #1: 4 3\nRoute #2: 2\n", ((2, 1), (0,))),
        (GAPS + "Route #1: 5 4\nRoute #2: 1\n", ((2, 1), (0,))),
        ("Route #1: 2 1\nRoute #2: 0\n", ((2, 1), (0,))),  # tasks from 0
        ("Route #1: 4 3\nRoute #2: 2\n", ((2, 1), (0,))),  # two depots, so the customers are 2 to 4
        ("Route #1: 3 2\nRoute #2: 1\n", ((2, 1), (0,))),  # customers 1 to 3, as Cordeau numbers them
    ],
)
def test_the_numbering_is_stated_or_seen(tmp_path, text, routes):
    (tmp_path / "a.sol").write_text(text)
    assert read_routes(tmp_path / "a.sol", instance_of(3, 2)) == routes


def test_a_part_of_the_tasks_in_every_stated_numbering(tmp_path):
    """What cannot be told by the numbers alone: 1 and 2 are tasks, and with one depot also customers."""
    instance = instance_of(3, 1)
    for remark, route in ((OLD, (1, 2)), ("# customers 1-3 are the tasks\n", (0, 1)), ("", (0, 1))):
        (tmp_path / "a.sol").write_text(f"{remark}Route #1: 1 2\n")
        assert read_routes(tmp_path / "a.sol", instance, all_tasks=False) == (route,)
    write_routes([[1, 2]], instance, tmp_path / "b.sol", all_tasks=False)
    assert read_routes(tmp_path / "b.sol", instance, all_tasks=False) == ((1, 2),)


def test_a_name_that_vrplib_would_take_for_a_route(tmp_path):
    instance = Instance("Route 66: a", instance_of(2, 1).cost, 2, 1)
    write_routes([[1, 0]], instance, tmp_path / "a.sol")
    assert vrplib.read_solution(tmp_path / "a.sol")["routes"] == [[2, 1]]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (NEW + "Route #1: 2 3 5\n", "route #1 holds 5, which is none of the customers 2-4"),
        (NEW + "Route #1: 2 3\n", "Task 2 is visited by no route; tasks from 0 are here customers 2-4"),
        ("# customers 2-9 are the tasks\nRoute #1: 2\n", "line 1: '2-9' are not the numbers of 3 customers"),
        ("# customers 1-99999999,9-1 are the tasks\nRoute #1: 2\n", "are not the numbers of 3 customers"),
        ("# customers - are the tasks\nRoute #1: 2\n", "line 1: '-' are not the numbers of 3 customers"),
        ("Route #1: 0 1 2 1\n", "Task 1 is visited 2 times"),
        ("Route #1: 0 1\n", "Task 2 is visited by no route"),
        ("Route #1: 0\n", r"Task 1 is visited by no route \(and 1 more faults\)"),
        ("Route #1: 0 1 2 3\n", "UAV 0 visits 3, which is not a task"),
        ("Route #3: 0 1 2\n", "line 1: route #3, but the depots are 1 to 2"),
        ("Route #0: 0 1 2\n", "line 1: route #0"),
        ("Route #1: 0 1\nRoute #1: 2\n", "line 2: route #1 is given twice"),
        ("Route #1: 0 1 two\n", "line 1: route #1 holds 'two', which is not a task number"),
        ("Route #1: 0 1 -2\n", "line 1: route #1 holds '-2'"),
        ("Route #1: 0 1 2\nCost much\n", "line 2: the cost must be a number, got 'much'"),
        ("Route #1: 0 1 2\nCost nan\n", "line 2: the cost must be a number, got 'nan'"),
        ("Rout #1: 0 1 2\n", "line 1 must read 'Route #k: tasks' or 'Cost value', got 'Rout #1: 0 1 2'"),
        ("Cost 7\n", "there is no line 'Route #k: tasks'"),
        ("", "there is no line 'Route #k: tasks'"),
    ],
)
def test_one_sentence_names_file_and_task(tmp_path, text, sentence):
    (tmp_path / "bad.sol").write_text(text)
    with pytest.raises(InputError, match=sentence) as caught:
        read_routes(tmp_path / "bad.sol", instance_of(3, 2))
    assert "bad.sol: " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_binary_missing_and_infeasible(tmp_path):
    (tmp_path / "a.sol").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not UTF-8 text"):
        read_routes(tmp_path / "a.sol", instance_of(1, 1))
    with pytest.raises(InputError, match="No such file"):
        read_routes(tmp_path / "b.sol", instance_of(1, 1))
    with pytest.raises(InputError, match="Task 0 is visited by no route"):
        write_routes([[]], instance_of(1, 1), tmp_path / "b.sol")
    assert not (tmp_path / "b.sol").exists()


@settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text("Route #:0123456789 \nCost.-+e²", max_size=40), st.text("0123456789,-²", max_size=9))
def test_any_text_is_read_or_refused_in_a_sentence(tmp_path, text, customers):
    (tmp_path / "a.sol").write_text(f"# customers {customers} are the tasks\n{text}" if customers else text)
    with contextlib.suppress(InputError):  # any other exception fails
        read_routes(tmp_path / "a.sol", instance_of(1, 1))
