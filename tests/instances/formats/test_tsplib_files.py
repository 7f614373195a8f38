import contextlib

import numpy as np
import pytest
import vrplib
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from instances import InputError, Instance
from instances.files import read_instance, write_instance
from instances.formats.atsp import weight_scale

COORDINATES = "NODE_COORD_SECTION\n1 0 0\n2 3 4\n3 0 1.5\n4 6 8\n"


def read(tmp_path, text, name="a.tsp"):
    (tmp_path / name).write_text(text)
    return read_instance(tmp_path / name)


def euclidean(edge_weight_type="EUC_2D", extra="", depots=""):
    return f"NAME: a\nTYPE: TSP\nDIMENSION: 4\nEDGE_WEIGHT_TYPE: {edge_weight_type}\n{extra}{COORDINATES}{depots}EOF\n"


def explicit(rows, form="FULL_MATRIX", size=3, extra="", depots="DEPOT_SECTION\n1\n-1\n"):
    return (
        f"NAME : a\nTYPE : ATSP\nDIMENSION : {size}\nEDGE_WEIGHT_TYPE : EXPLICIT\nEDGE_WEIGHT_FORMAT : {form}\n"
        f"{extra}EDGE_WEIGHT_SECTION\n{rows}\n{depots}EOF\n"
    )


@pytest.mark.parametrize(
    ("kind", "from_2_to_3"),
    [
        ("EUC_2D", 4.0),  # √(3² + 2.5²) = 3.905
        ("CEIL_2D", 4.0),
        ("FLOOR_2D", 3.0),
        ("EUC_2D_FLOAT", np.sqrt(15.25)),
        ("ATT", 2.0),  # √(15.25/10) = 1.235 rounds to 1 < 1.235, so 2
    ],
)
def test_distances_follow_tsplib(tmp_path, kind, from_2_to_3):
    instance = read(tmp_path, euclidean(kind))
    # node 1 is the depot: our nodes 0, 1, 2, 3 are the file's 2, 3, 4, 1
    assert instance.provenance["nodes"] == [2, 3, 4, 1]
    assert instance.cost[0, 1] == instance.cost[1, 0] == pytest.approx(from_2_to_3, rel=1e-15)
    assert (instance.n_tasks, instance.n_depots) == (3, 1)


def test_half_is_rounded_up_as_tsplib_says(tmp_path):
    assert read(tmp_path, euclidean("EUC_2D")).cost[1, 3] == 2.0  # 1.5 from node 3 to node 1


@pytest.mark.parametrize(
    ("extra", "depots", "nodes", "m"),
    [
        ("", "", [2, 3, 4, 1], 1),
        ("VEHICLES : 2\n", "", [2, 3, 4, 1, 1], 2),
        ("SALESMEN : 3\n", "", [2, 3, 4, 1, 1, 1], 3),
        ("", "DEPOT_SECTION\n3\n-1\n", [1, 2, 4, 3], 1),
        ("VEHICLES : 2\n", "DEPOT_SECTION\n3\n-1\n", [1, 2, 4, 3, 3], 2),
        ("VEHICLES : 2\n", "DEPOT_SECTION\n4\n2\n-1\n", [1, 3, 4, 2], 2),
        ("SALESMEN : 2\nDEPOT : 3\n", "", [1, 2, 4, 3, 3], 2),
        ("VEHICLES : 4\n", "DEPOT_SECTION\n4 1\n2 3\n-1\n", [1, 3, 4, 2, 2, 2], 4),
        ("", "DEPOT_SECTION\n4 1\n2 3\n-1\n", [1, 3, 4, 2, 2, 2], 4),
    ],
)
def test_where_the_uavs_start(tmp_path, extra, depots, nodes, m):
    instance = read(tmp_path, euclidean(extra=extra, depots=depots), "a.mtsp")
    assert instance.provenance["nodes"] == nodes
    assert instance.n_depots == m
    assert instance.coordinates is not None
    assert instance.coordinates.tolist() == [[[0, 0], [3, 4], [0, 1.5], [6, 8]][node - 1] for node in nodes]


MATRIX = np.array([[0, 1, 2, 3], [1, 0, 4, 5], [2, 4, 0, 6], [3, 5, 6, 0]])


@pytest.mark.parametrize(
    ("form", "numbers"),
    [
        ("FULL_MATRIX", "0 1 2 3 1 0 4 5\n2 4 0 6 3 5 6 0"),
        ("UPPER_ROW", "1 2 3 4\n5 6"),
        ("LOWER_ROW", "1 2 4 3 5 6"),
        ("UPPER_DIAG_ROW", "0 1 2 3 0 4 5 0 6 0"),
        ("LOWER_DIAG_ROW", "0 1 0 2 4 0 3 5 6 0"),
        ("UPPER_COL", "1 2 4 3 5 6"),
        ("LOWER_COL", "1 2 3 4 5 6"),
        ("UPPER_DIAG_COL", "0 1 0 2 4 0 3 5 6 0"),
        ("LOWER_DIAG_COL", "0 1 2 3 0 4 5 0 6 0"),
    ],
)
def test_explicit_weights_in_every_form(tmp_path, form, numbers):
    instance = read(tmp_path, explicit(numbers, form, 4, depots="DEPOT_SECTION\n4\n-1\n"))
    assert instance.cost.tolist() == MATRIX.tolist()


def test_vrplib_reads_the_same_matrix(tmp_path):
    text = explicit("1\n2 4\n3 5 6", "LOWER_ROW", 4, depots="DEPOT_SECTION\n4\n-1\n")
    instance = read(tmp_path, text)
    assert vrplib.read_instance(tmp_path / "a.tsp")["edge_weight"].tolist() == instance.cost.tolist()


def test_the_diagonal_becomes_zero_also_between_uavs_of_one_depot(tmp_path):
    instance = read(tmp_path, explicit("9999 1 2 3 9999 4 5 6 9999", extra="VEHICLES : 2\n"))
    assert instance.cost.tolist() == [[0, 4, 3, 3], [6, 0, 5, 5], [1, 2, 0, 0], [1, 2, 0, 0]]


def test_what_min_max_does_not_know_is_named_as_ignored(tmp_path):
    text = euclidean(extra="CAPACITY: 100\n", depots="DEMAND_SECTION\n1 0\n2 5\n3 5\n4 5\nDEPOT_SECTION\n1\n-1\n")
    assert read(tmp_path, text, "a.vrp").provenance["ignored"] == ["CAPACITY", "DEMAND_SECTION"]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "the keyword DIMENSION is missing"),
        ("hello", "line 1 is neither 'KEYWORD : value' nor part of a section: 'hello'"),
        ("DIMENSION: x", "DIMENSION must be a whole number of at least 1, got 'x'"),
        ("DIMENSION: 0", "DIMENSION must be a whole number of at least 1, got '0'"),
        ("DIMENSION: 4\nDIMENSION: 4", "line 2: DIMENSION is given twice"),
        ("DIMENSION: 999999999\nEDGE_WEIGHT_TYPE: EUC_2D\n", "999999998 tasks and 1 depots are more than the 20000"),
        ("DIMENSION: 4\nVEHICLES: 999999999\n", "3 tasks and 999999999 depots are more than the 20000"),
        ("DIMENSION: 4\n", "the keyword EDGE_WEIGHT_TYPE is missing"),
        ("DIMENSION: 1\nEDGE_WEIGHT_TYPE: EUC_2D\n", "every one of the 1 nodes is a depot"),
        (euclidean("EUC2D"), "EDGE_WEIGHT_TYPE 'EUC2D' is not supported; did you mean 'EUC_2D'"),
        (euclidean("GEO"), "EDGE_WEIGHT_TYPE 'GEO' is not supported"),
        (euclidean(extra="VEHICLES: 0\n"), "VEHICLES must be a whole number of at least 1, got '0'"),
        (euclidean(extra="VEHICLES: 2\nSALESMEN: 3\n"), "VEHICLES is 2 but SALESMEN is 3"),
        (euclidean(extra="VEHICLES: 3\n", depots="DEPOT_SECTION\n1\n2\n-1\n"), "VEHICLES is 3 for 2 depots"),
        (euclidean(extra="VEHICLES: 3\n", depots="DEPOT_SECTION\n1 1\n2 1\n-1\n"), "VEHICLES is 3 but the counts"),
        (euclidean(depots="DEPOT_SECTION\n9\n-1\n"), "DEPOT_SECTION names node 9, but the nodes are 1 to 4"),
        (euclidean(depots="DEPOT_SECTION\n2\n2\n-1\n"), "DEPOT_SECTION names node 2 twice"),
        (euclidean(depots="DEPOT_SECTION\n2 0\n-1\n"), "DEPOT_SECTION puts 0 UAVs at node 2"),
        (euclidean(depots="DEPOT_SECTION\n2 1\n3\n-1\n"), "a count for some depots but not for all"),
        (euclidean(extra="DEPOT: 2\n", depots="DEPOT_SECTION\n2\n-1\n"), "both DEPOT and DEPOT_SECTION"),
        (euclidean(extra="DEPOT:\n"), "DEPOT_SECTION must hold 'node' or 'node count', got ''"),
        (euclidean(depots="DEPOT_SECTION\nx\n-1\n"), "DEPOT_SECTION must hold 'node' or 'node count', got 'x'"),
        (euclidean(depots="DEPOT_SECTION\n-1\n"), "DEPOT_SECTION names no depot"),
        (euclidean(depots="DEPOT_SECTION\n1 1\n2 1\n3 1\n4 1\n-1\n"), "every one of the 4 nodes is a depot"),
        (euclidean().replace("4 6 8\n", ""), "NODE_COORD_SECTION has 3 lines, must have DIMENSION = 4"),
        (euclidean().replace("4 6 8", "4 6"), "NODE_COORD_SECTION must hold 'node x y', got '4 6'"),
        (euclidean().replace("4 6 8", "4 6 x"), "NODE_COORD_SECTION holds something that is not a number"),
        (euclidean().replace("4 6 8", "4 6 nan"), "NODE_COORD_SECTION: node 4 is not finite"),
        (euclidean().replace("4 6 8", "7 6 8"), "must list the nodes 1 to 4 in order, got '7' as 4"),
        (euclidean().replace(COORDINATES, ""), "EDGE_WEIGHT_TYPE EUC_2D needs a NODE_COORD_SECTION"),
        (explicit("0 1 2 3 0 4 5 6"), "EDGE_WEIGHT_SECTION holds 8 numbers, must hold 9"),
        (explicit("0 1 2 3 0 4 5 6 x"), "EDGE_WEIGHT_SECTION holds 'x', which is not a number"),
        (explicit("0 1 2 3 0 4 5 -6 0"), r"the weight from 3 to 2 is negative \(-6.0\)"),
        (explicit("0 1 2 3 0 nan 5 6 0"), "the weight from 2 to 3 is not a number"),
        (explicit("0 1 2 3 0 4 inf 6 0"), "the weight from 3 to 1 is infinite"),
        (explicit("0 1 2", "FULL_MATRX"), "'FULL_MATRX' is not supported; did you mean 'FULL_MATRIX'"),
        (explicit("0").replace("EDGE_WEIGHT_SECTION\n0\n", ""), "there is no EDGE_WEIGHT_SECTION"),
    ],
)
def test_one_sentence_names_file_field_and_value(tmp_path, text, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        read(tmp_path, text)
    assert "a.tsp: " in str(caught.value)
    assert "\n" not in str(caught.value)


TEMPLATE = explicit("0 1 2\n3 0 4\n5 6 0", extra="VEHICLES : 2\nCOMMENT : cost [s] = weight / 10\n")


@settings(deadline=None, max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, len(TEMPLATE)), st.integers(0, 12), st.text("0159-+.: \nEODCaT_#naif", max_size=6))
def test_damaged_files_are_read_or_refused_in_a_sentence(tmp_path, start, length, instead):
    with contextlib.suppress(InputError):  # any other exception fails
        read(tmp_path, TEMPLATE[:start] + instead + TEMPLATE[start + length :])


@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 10**6), st.integers(1, 5), st.integers(1, 3), st.integers(-6, 12), st.booleans())
def test_atsp_reads_back_within_half_a_unit(tmp_path, seed, n, m, exponent, whole):
    rng = np.random.default_rng(seed)
    cost = rng.uniform(0, 10.0**exponent, (n + m, n + m))
    cost = np.minimum(np.floor(cost), 2**31 - 1) if whole else cost
    np.fill_diagonal(cost, 0)
    instance = Instance("x", cost, n, m, rng.normal(size=(n + m, 2)))
    write_instance(instance, tmp_path / "a.atsp")
    back = read_instance(tmp_path / "a.atsp")
    assert (back.n_tasks, back.n_depots, back.name) == (n, m, "x")
    assert back.provenance["nodes"] == list(range(1, n + m + 1))
    assert back.coordinates.tolist() == instance.coordinates.tolist()
    if whole:
        assert back.cost.tobytes() == cost.tobytes()
    else:
        assert np.abs(back.cost - cost).max() <= (0.5 + 1e-6) / weight_scale(instance)
        assert np.abs(back.cost - cost).max() <= 5.1e-9 * cost.max()


@pytest.mark.parametrize("size", [1e-300, 1e-6, 1.5, 1e9 + 0.5, 1e149])
def test_atsp_holds_costs_of_any_size(tmp_path, size):
    instance = Instance("x", [[0, size], [size / 3, 0]], 1, 1)
    write_instance(instance, tmp_path / "a.atsp")
    back = read_instance(tmp_path / "a.atsp")
    assert back.cost[0, 1] == pytest.approx(size, rel=1e-8)
    weights = vrplib.read_instance(tmp_path / "a.atsp", compute_edge_weights=False)["edge_weight"]
    assert weights.dtype.kind == "i"
    assert weights.max() < 2**31
