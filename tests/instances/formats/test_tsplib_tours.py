"""Routes as TSPLIB tours: there and back, LKH's tour of several salesmen, and what cannot be used."""

import contextlib
import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from instances import InputError, Instance, as_routes, makespan
from instances.files import read_claim, read_routes, write_instance, write_routes


def instance_of(n, m, seed=0, *, together=False):
    cost = np.random.default_rng(seed).uniform(0, 100, (n + m, n + m)).round()
    if together:
        cost[n:], cost[:, n:] = cost[n], cost[:, [n]]
        cost[n:, n:] = 0
    np.fill_diagonal(cost, 0)
    return Instance("x", cost, n, m)


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(1, 12), st.integers(1, 5), st.integers(0, 2**32 - 1), st.booleans())
def test_routes_round_trip_empty_ones_included(tmp_path, n, m, seed, together):
    instance = instance_of(n, m, seed, together=together)
    rng = np.random.default_rng(seed)
    home = rng.integers(0, m, n)
    routes = as_routes([int(t) for t in rng.permutation(n) if home[t] == k] for k in range(m))
    write_routes(routes, instance, tmp_path / "a.tour")
    assert read_claim(tmp_path / "a.tour", instance) == (routes, None)


def test_tsplib95_traces_the_same_tours(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tsplib95 = pytest.importorskip("tsplib95", reason="tsplib95 asks for an old networkx: install it by hand")
    instance = instance_of(6, 2)
    routes = ((4, 0, 1), (5, 3, 2))
    write_instance(instance, tmp_path / "a.atsp")
    write_routes(routes, instance, tmp_path / "a.tour")
    tours = tsplib95.load(tmp_path / "a.tour").tours
    assert tours == [[1, 7, 3, 4], [2, 8, 6, 5]]
    problem = tsplib95.load(tmp_path / "a.atsp")
    lengths = problem.trace_tours([[node - 1 for node in tour] for tour in tours])  # explicit weights: from 0
    assert max(lengths) == makespan(instance, routes)


@pytest.mark.parametrize(
    ("numbers", "routes"),
    [
        ("1 3 2 5 4 6", ((1, 0), (2,), ())),  # 5 and 6 are copies of the depot
        ("2 5 4 6 1 3", ((2,), (), (1, 0))),  # begins on the way
        ("1 3 2 1 4", ((1, 0), (2,), ())),
    ],
)
def test_the_tour_lkh_writes_for_several_salesmen(tmp_path, numbers, routes):
    (tmp_path / "a.tour").write_text("TYPE : TOUR\nTOUR_SECTION\n" + numbers.replace(" ", "\n") + "\n-1\nEOF\n")
    assert read_routes(tmp_path / "a.tour", instance_of(3, 3, together=True)) == routes


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("1 2 3\n", "there is no TOUR_SECTION"),
        ("TOUR_SECTION\n1 2 x\n", "line 2: TOUR_SECTION must hold nodes and -1, got 'x'"),
        ("TOUR_SECTION\n1 9\n", "TOUR_SECTION holds node 9, but the nodes are 1 to 5"),
        ("TOUR_SECTION\n3 4\n", "the tour that begins with node 3 visits no depot"),
        ("TOUR_SECTION\n1 3 -1 1 4 -1 2 5\n", "more routes begin at node 1 than UAVs start there"),
        ("TOUR_SECTION\n1 3 4 -1 -1\n", "Task 2 is visited by no route"),
        ("TOUR_SECTION\n1 3 3 -1 -1\n", r"Task 1 is visited by no route \(and 2 more faults\)"),
    ],
)
def test_one_sentence_names_file_and_node(tmp_path, text, sentence):
    (tmp_path / "a.tour").write_text(text)
    with pytest.raises(InputError, match=sentence) as caught:
        read_routes(tmp_path / "a.tour", instance_of(3, 2))
    assert "a.tour: " in str(caught.value)


def test_infeasible_routes_are_not_written(tmp_path):
    with pytest.raises(InputError, match=r"a\.tour: Task 0 is visited by no route"):
        write_routes([[]], instance_of(1, 1), tmp_path / "a.tour")
    assert not (tmp_path / "a.tour").exists()


@settings(deadline=None, max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text("0123456789 \n-EOF²", max_size=40))
def test_any_text_is_read_or_refused_in_a_sentence(tmp_path, text):
    (tmp_path / "a.tour").write_text(f"TOUR_SECTION\n{text}")
    with contextlib.suppress(InputError):  # any other exception fails
        read_routes(tmp_path / "a.tour", instance_of(2, 2))
