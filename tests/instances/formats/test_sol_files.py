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
    assert as_routes(others["routes"]) == routes
    assert others["cost"] == makespan(instance, routes)


def test_routes_may_be_left_out_and_come_in_any_order(tmp_path):
    (tmp_path / "a.sol").write_text("# remark\nRoute #3: 2 0\n\nroute 1 : 1\n")
    assert read_solution(tmp_path / "a.sol", instance_of(3, 3)) == (((1,), (), (2, 0)), None)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
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
@given(st.text("Route #:0123456789 \nCost.-+e²", max_size=40))
def test_any_text_is_read_or_refused_in_a_sentence(tmp_path, text):
    (tmp_path / "a.sol").write_text(text)
    with contextlib.suppress(InputError):  # any other exception fails
        read_routes(tmp_path / "a.sol", instance_of(1, 1))
