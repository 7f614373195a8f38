"""TSPLIB, LKH and VRPLIB files that we write: read back, and read by vrplib, tsplib95 and PyVRP with equal numbers."""

import warnings
from itertools import pairwise

import numpy as np
import pytest
import vrplib
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from instances import InputError, Instance, Travel, as_routes, tour_costs
from instances.files import read_instance, write_instance, write_routes
from instances.formats.edge_weights import METRIC_OF, WRITTEN
from instances.formats.numbering import customers, file_nodes
from instances.formats.tsplib_text import weight_scale
from instances.metrics import metric_cost

ENDINGS = (".tsp", ".atsp", ".mtsp", ".vrp")


def made(seed, n, m, *, whole=True, symmetric=False, together=False, size=100.0, places=True):
    rng = np.random.default_rng(seed)
    cost, xy = rng.uniform(0, size, (n + m, n + m)), rng.normal(size=(n + m, 2))
    if together:
        cost[n:], cost[:, n:], xy[n:] = cost[n], cost[:, [n]], xy[n]
        cost[n:, n:] = 0
    cost = np.minimum(np.floor(cost), 2**31 - 1) if whole else cost
    cost = np.maximum(cost, cost.T) if symmetric else cost
    np.fill_diagonal(cost, 0)
    return Instance("x", cost, n, m, xy if places else None)


def dealt(instance, seed=0):
    rng = np.random.default_rng(seed)
    home = rng.integers(0, instance.n_depots, instance.n_tasks)
    order = rng.permutation(instance.n_tasks)
    return as_routes([int(t) for t in order if home[t] == k] for k in range(instance.n_depots))


@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 5),
    m=st.integers(1, 3),
    exponent=st.integers(-6, 12),
    ending=st.sampled_from(ENDINGS),
    flags=st.tuples(*[st.booleans()] * 4),
)
def test_what_is_written_reads_back(tmp_path, seed, n, m, exponent, ending, flags):
    whole, symmetric, together, places = flags
    instance = made(
        seed, n, m, whole=whole, symmetric=symmetric or ending == ".tsp", together=together, size=10.0**exponent,
        places=places,
    )  # fmt: skip
    write_instance(instance, tmp_path / f"a{ending}")
    back = read_instance(tmp_path / f"a{ending}")
    assert (back.n_tasks, back.n_depots, back.name) == (n, m, "x")
    assert back.provenance["nodes"] == file_nodes(instance) == file_nodes(back)
    if whole:
        assert back.digest == instance.digest
    else:
        assert np.abs(back.cost - instance.cost).max() <= (0.5 + 1e-6) / weight_scale(instance)
        assert np.abs(back.cost - instance.cost).max() <= 5.1e-9 * instance.cost.max()


@pytest.mark.parametrize("size", [1e-300, 1e-6, 1.5, 1e9 + 0.5, 1e149])
def test_atsp_holds_costs_of_any_size(tmp_path, size):
    instance = Instance("x", [[0, size], [size / 3, 0]], 1, 1)
    write_instance(instance, tmp_path / "a.atsp")
    back = read_instance(tmp_path / "a.atsp")
    assert back.cost[0, 1] == pytest.approx(size, rel=1e-8)
    weights = vrplib.read_instance(tmp_path / "a.atsp", compute_edge_weights=False)["edge_weight"]
    assert weights.dtype.kind == "i"
    assert weights.max() < 2**31


@pytest.mark.parametrize("together", [False, True])
@pytest.mark.parametrize("m", [1, 3])
@pytest.mark.parametrize("ending", ENDINGS)
def test_vrplib_finds_the_costs_of_our_routes_in_its_own_arrays(tmp_path, ending, m, together):
    instance = made(3, 7, m, whole=False, symmetric=ending == ".tsp", together=together)
    routes = dealt(instance)
    write_instance(instance, tmp_path / f"a{ending}")
    write_routes(routes, instance, tmp_path / "a.sol")
    theirs, solution = vrplib.read_instance(tmp_path / f"a{ending}"), vrplib.read_solution(tmp_path / "a.sol")
    depots = np.resize(theirs["depot"], m)
    seconds = theirs["edge_weight"] / weight_scale(instance)
    legs = [[depot, *route, depot] for depot, route in zip(depots, solution["routes"], strict=True)]
    costs = [sum(seconds[a, b] for a, b in pairwise(stops)) for stops in legs]
    assert costs == pytest.approx(tour_costs(instance, routes), rel=1e-7)
    assert solution["cost"] == tour_costs(instance, routes).max()
    if ending == ".vrp":
        ours = instance.coordinates[[*instance.tasks]]
        assert theirs["node_coord"][customers(instance)].tolist() == ours.tolist()
        assert theirs["demand"].sum() <= theirs["capacity"]


def test_one_depot_has_the_numbers_of_cvrplib(tmp_path):
    """Node 1 is the depot, node i + 1 is customer i."""
    instance = made(0, 3, 2, together=True)
    write_instance(instance, tmp_path / "a.vrp")
    write_routes([[2, 0], [1]], instance, tmp_path / "a.sol")
    assert vrplib.read_solution(tmp_path / "a.sol")["routes"] == [[3, 1], [2]]
    assert vrplib.read_instance(tmp_path / "a.vrp")["depot"].tolist() == [0]


@pytest.mark.parametrize("m", [1, 3])
@pytest.mark.parametrize("ending", ENDINGS)
def test_tsplib95_reads_the_same_weights(tmp_path, ending, m):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tsplib95 = pytest.importorskip("tsplib95", reason="tsplib95 asks for an old networkx: install it by hand")
    together = ending == ".vrp"  # TSPLIB has no section that says whose depot is whose
    instance = made(1, 5, m, symmetric=ending == ".tsp", together=together)
    write_instance(instance, tmp_path / f"a{ending}")
    problem = tsplib95.load(tmp_path / f"a{ending}")
    nodes = file_nodes(instance)
    first = min(problem.get_nodes())
    read = [[problem.get_weight(i - 1 + first, j - 1 + first) for j in nodes] for i in nodes]
    assert read == instance.cost.tolist()
    assert problem.depots == sorted(set(nodes[5:]))


@pytest.mark.parametrize("kind", WRITTEN)
def test_costs_that_tsplib_computes_are_written_as_coordinates(tmp_path, kind):
    xy = np.random.default_rng(0).uniform(-80, 80, (6, 2)).round(2)
    metric = METRIC_OF[kind]
    instance = Instance("x", metric_cost(metric, xy), 5, 1, xy, {"metric": metric})
    write_instance(instance, tmp_path / "a.tsp")
    text = (tmp_path / "a.tsp").read_text()
    assert f"EDGE_WEIGHT_TYPE : {kind}" in text
    assert "EDGE_WEIGHT_SECTION" not in text
    assert read_instance(tmp_path / "a.tsp").digest == instance.digest
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tsplib95 = pytest.importorskip("tsplib95", reason="tsplib95 asks for an old networkx: install it by hand")
    problem = tsplib95.load(tmp_path / "a.tsp")
    nodes = file_nodes(instance)
    other = np.array([[problem.get_weight(i, j) if i != j else 0 for j in nodes] for i in nodes])
    # GEO's π is 3.141592, that of tsplib95 has more digits
    assert np.abs(other - instance.cost).max() <= (1 if kind == "GEO" else 0)


@pytest.mark.parametrize("together", [False, True])
def test_pyvrp_reads_instance_and_routes(tmp_path, together):
    pyvrp = pytest.importorskip("pyvrp", reason="PyVRP is not installed")
    instance = made(5, 8, 3, together=together)
    routes = dealt(instance)
    write_instance(instance, tmp_path / "a.vrp")
    write_routes(routes, instance, tmp_path / "a.sol")
    found = pyvrp.read_solution(tmp_path / "a.sol", pyvrp.read(tmp_path / "a.vrp"))
    assert found.is_feasible()
    flown = [cost for cost, route in zip(tour_costs(instance, routes), routes, strict=True) if route]
    assert sorted(route.distance() for route in found.routes()) == sorted(flown)


def test_the_numbers_of_the_file_that_was_read_are_kept(tmp_path):
    """Depots in the middle and at the end: the routes speak of the nodes of that file."""
    text = "DIMENSION: 6\nEDGE_WEIGHT_TYPE: EUC_2D\nNODE_COORD_SECTION\n" + "".join(
        f"{k} {k * k} 0\n" for k in range(1, 7)
    )
    (tmp_path / "a.vrp").write_text(f"{text}DEPOT_SECTION\n3\n6\n-1\nEOF\n")
    instance = read_instance(tmp_path / "a.vrp")
    write_routes([[2, 0], [3, 1]], instance, tmp_path / "a.sol")
    assert vrplib.read_solution(tmp_path / "a.sol")["routes"] == [[3, 0], [4, 1]]  # nodes 4, 1 and 5, 2
    write_instance(instance, tmp_path / "b.vrp")
    write_instance(instance, tmp_path / "c.json")
    for name in ("b.vrp", "c.json"):
        assert read_instance(tmp_path / name).digest == instance.digest
        assert file_nodes(read_instance(tmp_path / name)) == file_nodes(instance) == [1, 2, 4, 5, 3, 6]


@pytest.mark.parametrize(
    "nodes", [None, "all", [1], [2, 3, 4, 5, 1], [3, 2, 4, 1, 5], [1, 2, 2, 4, 5], [1, 2, 3, 9, 5]]
)
def test_a_numbering_that_does_not_fit_is_not_used(nodes):
    base = made(0, 3, 2)
    instance = Instance("x", base.cost, 3, 2, None, {"nodes": nodes})
    assert file_nodes(instance) == [3, 4, 5, 1, 2] if nodes != [2, 3, 4, 5, 1] else nodes


ROWS = [[0, 1, 2], [1, 0, 2], [1, 1, 0]]
FLEET = Instance.of_travel("x", Travel([[ROWS], [(2 * np.array(ROWS)).tolist()]], [0, 1]), 1)


@pytest.mark.parametrize(
    ("instance", "ending", "sentence"),
    [
        (made(0, 2, 1), ".tsp", "TSP has one cost for both directions, and those of this instance differ: write .atsp"),
        (Instance("x", np.zeros((2, 2)), 1, 1, endurance=[5]), ".vrp", "no place for limited endurance: write .json"),
        (FLEET, ".atsp", "no place for UAVs that differ: write .json"),
        (made(0, 2, 1), ".mdm", r"'.mdm' is no ending of instance files .*known: \.json, \.json\.gz, \.tsp, \.atsp"),
    ],
)
def test_what_a_format_has_no_place_for_is_refused_in_a_sentence(tmp_path, instance, ending, sentence):
    with pytest.raises(InputError, match=sentence):
        write_instance(instance, tmp_path / f"a{ending}")
    assert list(tmp_path.iterdir()) == []
