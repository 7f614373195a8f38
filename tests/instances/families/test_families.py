import hashlib
import subprocess
import sys

import numpy as np
import pytest

from instances import InputError, check_routes
from instances.best_known import best_known, table
from instances.families import FAMILIES, generate, make_scenario
from instances.files import read_instance, write_instance

WINDY = [name for name, family in FAMILIES.items() if "wind" in {p.name for p in family.parameters}]


def test_the_families_we_promise_are_there_and_say_what_they_take():
    assert set(FAMILIES) == {"uniform", "clustered", "ring", "corridor", "square-wind"}
    for family in FAMILIES.values():
        assert family.description
        for parameter in family.parameters:
            assert parameter.meaning
            assert parameter.checked(parameter.default) == parameter.default
            assert parameter.checked(str(parameter.default)) == parameter.default


@pytest.mark.parametrize("name", FAMILIES)
def test_same_seed_same_file_in_another_process(tmp_path, name):
    write_instance(generate(name, 12, 3, seed=5), tmp_path / "here.json")
    program = (
        "import sys; from instances.families import generate; from instances.files import write_instance; "
        "write_instance(generate(sys.argv[1], 12, 3, seed=5), sys.argv[2])"
    )
    subprocess.run([sys.executable, "-c", program, name, str(tmp_path / "there.json")], check=True)
    assert (tmp_path / "here.json").read_bytes() == (tmp_path / "there.json").read_bytes()
    assert generate(name, 12, 3, seed=6).digest != generate(name, 12, 3, seed=5).digest


@pytest.mark.parametrize("name", FAMILIES)
def test_sizes_places_and_provenance(name):
    instance = generate(name, 30, 4, seed=1)
    scenario = make_scenario(name, 30, 4, seed=1)
    assert (instance.n_tasks, instance.n_depots) == (30, 4)
    assert instance.coordinates.tolist() == scenario.points.tolist()
    assert scenario.region.contains(instance.coordinates).all()
    assert instance.provenance["family"] == name
    assert instance.provenance["seed"] == 1
    assert (instance.cost[~np.eye(34, dtype=bool)] > 0).all()
    assert check_routes(instance, [range(30), [], [], []]) == []


@pytest.mark.parametrize("name", WINDY)
@pytest.mark.parametrize("wind", ["none", "uniform", "shear", "rotation"])
def test_wind_alone_makes_costs_asymmetric(name, wind):
    calm = generate(name, 15, 2, seed=3)
    windy = generate(name, 15, 2, seed=3, wind=wind)
    assert windy.coordinates.tolist() == calm.coordinates.tolist()
    if wind == "none":
        assert windy.asymmetry == 0
    else:
        assert windy.asymmetry > 0.02
        # wind helps one way about as much as it hinders the other: there and back is never longer than in calm air
        there_and_back, in_calm = windy.cost + windy.cost.T, calm.cost + calm.cost.T
        assert (there_and_back <= in_calm * (1 + 1e-12)).all() or name == "corridor"
        # and the scenario's own wind stays below the airspeed
        scenario = make_scenario(name, 15, 2, seed=3, wind=wind)
        assert np.linalg.norm(scenario.wind(scenario.region.sample(500, np.random.default_rng(0))), axis=1).max() <= 8.0


@pytest.mark.parametrize("name", WINDY)
def test_depots_spread_clustered_or_shared(name):
    def widest(depots):
        p = make_scenario(name, 10, 6, seed=2, depots=depots).depots
        return np.linalg.norm(p[:, None] - p[None], axis=-1)[np.triu_indices(6, 1)]

    assert widest("shared").max() == 0
    assert 0 < widest("clustered").max() < 0.11 * 20_000 * np.sqrt(2)
    assert widest("spread").min() > 2_000
    tasks = [make_scenario(name, 10, 6, seed=2, depots=d).tasks.tolist() for d in ("spread", "clustered", "shared")]
    assert tasks[0] == tasks[1] == tasks[2]


def test_what_the_shapes_are():
    ring = make_scenario("ring", 200, 1, seed=0, radius=5000, width=1000).tasks - 10_000
    radius = np.linalg.norm(ring, axis=1)
    assert radius.min() >= 4500
    assert radius.max() <= 5500
    assert len(np.unique(np.sign(ring), axis=0)) == 4  # all around
    clustered = make_scenario("clustered", 300, 1, seed=0, clusters=3, cluster_sd=10).tasks
    assert len(np.unique(np.round(clustered / 500), axis=0)) <= 12
    corridor = make_scenario("corridor", 10, 1, seed=0, walls=2).region
    assert corridor.area == pytest.approx(20_000**2 - 2 * 400 * 16_000)
    assert not corridor.polygon.equals(corridor.polygon.convex_hull)


def test_one_stretch_of_corridor_by_hand():
    """One wall of thickness 2 at x in [4, 6], opening 3 at the top of a 10 m square: a taut string over two corners."""
    from instances.environment.corner_paths import corner_path_costs
    from instances.environment.wind import Uniform
    from instances.families.corridor import winding

    region = winding({"size": 10.0, "walls": 1, "opening": 3.0, "thickness": 2.0})
    points = np.array([[1.0, 3.0], [9.0, 3.0], [2.0, 9.0]])
    cost = corner_path_costs(points, region, 2.0, None)
    assert cost[0, 1] == pytest.approx((5 + 2 + 5) / 2)
    assert cost[0, 2] == pytest.approx(np.sqrt(1 + 36) / 2)
    # closed form 2: uniform wind adds a potential difference, whatever the way
    windy = corner_path_costs(points, region, 2.0, Uniform((0.5, -0.3)))
    shift = -(points[None] - points[:, None]) @ np.array([0.5, -0.3]) / 4
    assert windy == pytest.approx(cost + shift)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        ({"name": "unifrom"}, "unknown family 'unifrom'; did you mean 'uniform'"),
        ({"winds": "shear"}, "family uniform has no parameter 'winds'; did you mean 'wind'"),
        ({"wind": "sheer"}, "wind: 'sheer' is not one of none, uniform, shear, rotation; did you mean 'shear'"),
        ({"wind": 3}, "wind: 3 is not one of"),
        ({"airspeed": 0}, r"airspeed: must be a number of at least 1e-09 \[m/s\], got 0"),
        ({"airspeed": "fast"}, "airspeed: must be a number"),
        ({"airspeed": float("nan")}, "airspeed: must be a number"),
        ({"airspeed": 10**400}, "airspeed: must be a number"),
        ({"airspeed": True}, "airspeed: must be a number"),
        ({"airspeed": [20]}, "airspeed: must be a number"),
        ({"wind": "uniform", "wind_speed": 20}, "wind_speed: must be below the airspeed of 20 m/s, got 20 m/s"),
        ({"wind": "rotation", "wind_speed": 19}, "wind: it reaches .* must stay below the airspeed"),
        ({"name": "clustered", "clusters": 2.5}, "clusters: must be a whole number of at least 1, got 2.5"),
        ({"name": "clustered", "clusters": 0}, "clusters: must be a whole number of at least 1, got 0"),
        ({"name": "ring", "radius": 9_500}, "radius ± width/2 must lie between 0 and size/2 = 10000 m"),
        ({"name": "corridor", "opening": 20_000}, "opening must be below size = 20000 m"),
        ({"name": "corridor", "walls": 100}, "100 walls of thickness 400 m fill the size"),
        ({"name": "square-wind", "wind": "shear"}, r"family square-wind has no parameter 'wind' \(it has none\)"),
        ({"n_tasks": 0}, "n_tasks must be a whole number of at least 1, got 0"),
        ({"n_tasks": 10**6}, "1000000 tasks and 2 depots are more than the 20000 nodes"),
        ({"n_depots": 1.0}, "n_depots must be a whole number of at least 1, got 1.0"),
        ({"seed": -1}, "seed must be a whole number of at least 0, got -1"),
    ],
)
def test_bad_names_and_values_in_one_sentence(call, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        generate(**{"name": "uniform", "n_tasks": 5, "n_depots": 2, "seed": 0, **call})
    assert "\n" not in str(caught.value)


def test_parameters_as_text_from_a_command_line():
    as_text = generate("clustered", 8, 2, seed=0, clusters="2", cluster_sd="500", wind="shear", wind_speed="3.5")
    as_numbers = generate("clustered", 8, 2, seed=0, clusters=2, cluster_sd=500.0, wind="shear", wind_speed=3.5)
    assert as_text.digest == as_numbers.digest


@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 4), (3, 7)])
@pytest.mark.parametrize("name", FAMILIES)
def test_few_tasks_and_many_uavs(tmp_path, name, n, m):
    instance = generate(name, n, m, seed=0)
    write_instance(instance, tmp_path / "a.json.gz")
    assert read_instance(tmp_path / "a.json.gz").digest == instance.digest


def test_all_tasks_in_one_place():
    instance = generate("clustered", 6, 2, seed=0, clusters=1, cluster_sd=0, wind="rotation")
    assert np.abs(instance.cost[:6, :6]).max() == 0
    assert (instance.cost[6:, :6] > 0).all()


def test_square_wind_is_the_published_generator():
    """Recomputed entry by entry as the formula stands."""
    n, m, seed = 5, 2, 1
    p = np.random.default_rng(1000 * n + 100 * m + seed).uniform(0, 20000, (n + m, 2))
    q = p - 10000
    instance = generate("square-wind", n, m, seed)
    assert instance.coordinates.tolist() == p.tolist()
    for i in range(n + m):
        for j in range(n + m):
            d = q[j] - q[i]
            cost = np.hypot(*d) / 20 - np.dot((4, -2), d) / 400 - 5e-4 * (q[i][0] * q[j][1] - q[i][1] * q[j][0]) / 400
            assert instance.cost[i, j] == pytest.approx(cost, rel=1e-12, abs=1e-9)
    # the scenario says the same with one wind: its line integrals along straight legs give the same costs
    scenario = make_scenario("square-wind", n, m, seed)
    legs = np.linalg.norm(p[1] - p[0]) / 20 - scenario.wind.line_integral(p[:1], p[1:2])[0] / 400
    assert instance.cost[0, 1] == pytest.approx(legs, rel=1e-12)


def test_best_known_values_are_found_by_digest():
    for n, m, seed, value in [(20, 3, 0, 1578.891), (20, 2, 2, 1979.242), (50, 4, 1, 1608.736)]:
        known = best_known(generate("square-wind", n, m, seed).digest)
        assert known is not None
        assert (known.best_known, known.proven, known.n_tasks, known.n_depots) == (value, True, n, m)
        assert known.reached(value + 4e-4)
        assert not known.reached(value + 2e-3)
    assert best_known("no such digest") is None


def test_the_table_of_best_known_values_is_consistent():
    rows = table()
    assert len(rows) > 150
    for digest, row in rows.items():
        assert len(digest) == 12
        assert row.source
        assert row.bound is None or row.bound <= row.best_known * (1 + 1e-9)
        assert row.proven == (row.bound is not None and row.bound >= row.best_known * (1 - 1e-6))


@pytest.mark.slow
def test_five_thousand_tasks_fit(tmp_path):
    """A matrix of 0.2 GB is inevitable; its file is not."""
    instance = generate("clustered", 5000, 10, seed=0)
    write_instance(instance, tmp_path / "a.json")
    assert (tmp_path / "a.json").stat().st_size < 400_000
    assert hashlib.sha256(read_instance(tmp_path / "a.json").cost).digest() == hashlib.sha256(instance.cost).digest()
