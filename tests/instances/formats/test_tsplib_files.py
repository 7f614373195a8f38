import contextlib

import numpy as np
import pytest
import vrplib
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from formulations.limits import Limits
from formulations.routing.registry import SOLVERS
from instances import InputError
from instances.files import read_instance

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
        ("MAN_2D", 6.0),  # 3 + 2.5 = 5.5
        ("MAX_2D", 3.0),
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


OF_EACH = "VEHICLES_DEPOT_SECTION\n1 3\n2 3\n3 1\nDEPOT_SECTION\n1\n3\n-1\n"


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
        ("VEHICLES : 3\n", OF_EACH, [2, 4, 3, 3, 1], 3),
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


DEMANDS = "DEMAND_SECTION\n1 0\n2 5\n3 5\n4 5\nDEPOT_SECTION\n1\n-1\n"
WINDOWS = "TIME_WINDOW_SECTION\n1 0 9\n2 0 9\n3 0 9\n4 0 9\n"


@pytest.mark.parametrize(
    ("extra", "depots", "ignored", "told"),
    [
        ("CAPACITY: 10\n", DEMANDS, ["CAPACITY", "DEMAND_SECTION"], "CAPACITY, DEMAND_SECTION"),
        ("CAPACITY: 15\n", DEMANDS, ["CAPACITY", "DEMAND_SECTION"], None),  # one vehicle carries all
        ("", WINDOWS + DEMANDS, ["DEMAND_SECTION", "TIME_WINDOW_SECTION"], "DEMAND_SECTION, TIME_WINDOW_SECTION"),
        ("CAPACITY: 15\nDISTANCE: 99\n", DEMANDS, ["CAPACITY", "DEMAND_SECTION", "DISTANCE"], "DISTANCE"),
        ("", "FIXED_EDGES_SECTION\n1 2\n-1\n", ["FIXED_EDGES_SECTION"], "FIXED_EDGES_SECTION"),
        ("", "", None, None),
    ],
)
def test_what_is_left_out_is_said_in_one_line(tmp_path, caplog, extra, depots, ignored, told):
    assert read(tmp_path, euclidean(extra=extra, depots=depots), "a.vrp").provenance.get("ignored") == ignored
    lines = [f"{tmp_path}/a.vrp: left out, as the min-max problem has no place for it: {told}"] if told else []
    assert caplog.messages == lines


@pytest.mark.parametrize(("kind", "from_1_to_2"), [("EUC_3D", 7.0), ("MAN_3D", 11.0), ("MAX_3D", 6.0), ("EUC_2D", 4.0)])
def test_a_third_coordinate_counts_where_the_type_says_so(tmp_path, caplog, kind, from_1_to_2):
    head = f"DIMENSION: 2\nEDGE_WEIGHT_TYPE: {kind}\nNODE_COORD_TYPE: THREED_COORDS\n"
    instance = read(tmp_path, f"{head}NODE_COORD_SECTION\n1 0 0 0\n2 2 3 6\n")
    assert instance.cost[0, 1] == from_1_to_2
    assert instance.coordinates.tolist() == [[2, 3], [0, 0]]
    assert "third coordinate" in caplog.messages[0]


# burma14 and ulysses16 of TSPLIB: where the towns are, and the length of the shortest tour, as Reinelt publishes them
BURMA = """16.47 96.10 16.47 94.44 20.09 92.54 22.39 93.37 25.23 97.24 22.00 96.05 20.47 97.02
17.20 96.29 16.30 97.38 14.05 98.12 16.53 97.38 21.52 95.59 19.41 97.13 20.09 94.55"""
ULYSSES = """38.24 20.42 39.57 26.15 40.56 25.32 36.26 23.12 33.48 10.54 37.56 12.19 38.42 13.11 37.52 20.44
41.23 9.10 41.17 13.05 36.08 -5.21 38.47 15.13 38.15 15.35 37.51 15.17 35.49 14.32 39.36 19.56"""


@pytest.mark.parametrize(("towns", "shortest"), [(BURMA, 3323), (ULYSSES, 6859)], ids=["burma14", "ulysses16"])
def test_geo_distances_give_the_published_optimum(tmp_path, towns, shortest):
    numbers = towns.split()
    lines = "".join(f"{k} {x} {y}\n" for k, (x, y) in enumerate(zip(numbers[::2], numbers[1::2], strict=True), 1))
    text = f"DIMENSION: {len(numbers) // 2}\nEDGE_WEIGHT_TYPE: GEO\nNODE_COORD_SECTION\n{lines}EOF\n"
    instance = read(tmp_path, text)
    assert (instance.cost == instance.cost.T).all()
    result = SOLVERS.make("subset-dp").solve(instance, limits=Limits(time=20))
    assert (result.status, result.objective) == ("OPTIMAL", shortest)


def test_geo_distances_of_one_place_and_of_the_other_side(tmp_path):
    text = "VEHICLES: 2\nDIMENSION: 3\nEDGE_WEIGHT_TYPE: GEO\nNODE_COORD_SECTION\n1 0 0\n2 0 0\n3 0 180\n"
    instance = read(tmp_path, text)
    assert instance.cost[0].tolist() == [0, int(6378.388 * 3.141592 + 1), 1, 1]  # TSPLIB has 1 for one place
    assert instance.cost[2:, 2:].tolist() == [[0, 0], [0, 0]]  # but two UAVs at one depot are one place


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "the keyword DIMENSION is missing"),
        ("hello", "line 1 is neither 'KEYWORD : value' nor part of a section: 'hello'"),
        ("DIMENSION: x", "DIMENSION must be a whole number of at least 1, got 'x'"),
        ("DIMENSION: 0", "DIMENSION must be a whole number of at least 1, got '0'"),
        ("DIMENSION: 4\nDIMENSION: 4", "line 2: DIMENSION is given twice"),
        ("DIMENSION: 999999999\nEDGE_WEIGHT_TYPE: EUC_2D\n", "999999998 tasks and 1 depots are more than the 100000"),
        ("DIMENSION: 4\nVEHICLES: 999999999\n", "3 tasks and 999999999 depots are more than the 100000"),
        ("DIMENSION: 4\n", "the keyword EDGE_WEIGHT_TYPE is missing"),
        ("DIMENSION: 1\nEDGE_WEIGHT_TYPE: EUC_2D\n", "every one of the 1 nodes is a depot"),
        (euclidean("EUC2D"), "EDGE_WEIGHT_TYPE 'EUC2D' is not supported; did you mean 'EUC_2D'"),
        (euclidean("XRAY1"), "EDGE_WEIGHT_TYPE 'XRAY1' is not supported"),
        (euclidean("EUC_3D"), "NODE_COORD_SECTION must hold 'node x y z', got '1 0 0'"),
        (euclidean(depots=OF_EACH.replace("2 3", "2 4")), "VEHICLES_DEPOT_SECTION names node 4, which is no depot"),
        (euclidean(depots=OF_EACH.replace("2 3", "3 3")), "must hold 'vehicle node' from 1 in order, got '3 3'"),
        (euclidean(extra="VEHICLES: 4\n", depots=OF_EACH), "VEHICLES is 4 but VEHICLES_DEPOT_SECTION has 3 lines"),
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
