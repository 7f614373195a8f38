"""Instances of generator families: closed forms over open country, published costs, planned ones around walls."""

import hashlib
import json
import subprocess
import sys

import numpy as np
import pytest

from formulations.moving_cost.families import costed, generate
from instances import InputError, check_routes
from instances.best_known import best_known
from instances.families import FAMILIES, make_scenario
from instances.files import read_instance, write_instance
from instances.old_corridor_metric import old_corridor_costs
from instances.paths import check_paths

WINDY = ["uniform", "clustered", "ring", "corridor"]
"""Families with every option of wind and depots."""
COARSE = {"wind-mountains": {"cells": 40}}
"""A flow over mountains that takes little time."""


ELSEWHERE = """
import json, sys
from pathlib import Path
from formulations.moving_cost.families import generate
from instances.files import write_instance
folder, parameters = Path(sys.argv[1]), json.loads(sys.argv[2])
for name in parameters:
    write_instance(generate(name, 3, 2, seed=5, **parameters[name]), folder / f"{name}.json")
"""


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    """An instance of each family, made in another process."""
    folder = tmp_path_factory.mktemp("elsewhere")
    parameters = {name: COARSE.get(name, {}) for name in FAMILIES.built_in}
    subprocess.run([sys.executable, "-c", ELSEWHERE, str(folder), json.dumps(parameters)], check=True)
    return folder


@pytest.mark.parametrize("name", FAMILIES.built_in)
def test_same_seed_same_file_in_another_process(tmp_path, elsewhere, name):
    here = generate(name, 3, 2, seed=5, **COARSE.get(name, {}))
    write_instance(here, tmp_path / "here.json")
    assert (tmp_path / "here.json").read_bytes() == (elsewhere / f"{name}.json").read_bytes()
    assert generate(name, 3, 2, seed=6, **COARSE.get(name, {})).digest != here.digest


@pytest.mark.parametrize("name", FAMILIES.built_in)
def test_sizes_places_and_provenance(name):
    instance = generate(name, 7, 3, seed=1, **COARSE.get(name, {}))
    scenario = make_scenario(name, 7, 3, seed=1, **COARSE.get(name, {}))
    assert (instance.n_tasks, instance.n_depots) == (7, 3)
    assert instance.coordinates.tolist() == scenario.points.tolist()
    assert scenario.region.contains(instance.coordinates).all()
    assert instance.provenance["family"] == name
    assert instance.provenance["seed"] == 1
    assert (instance.cost[~np.eye(10, dtype=bool)] > 0).all()
    assert check_routes(instance, [range(7), [], []]) == []


@pytest.mark.parametrize("name", WINDY)
@pytest.mark.parametrize("wind", ["none", "uniform", "shear", "rotation"])
def test_wind_alone_makes_costs_asymmetric(name, wind):
    calm = generate(name, 15, 2, seed=3)
    windy = generate(name, 15, 2, seed=3, wind=wind)
    assert windy.coordinates.tolist() == calm.coordinates.tolist()
    if wind == "none":
        assert windy.asymmetry < (1e-9 if name == "corridor" else 1e-300)
    else:
        assert windy.asymmetry > 0.02
        # wind helps one way about as much as it hinders the other: there and back is never longer than in calm air
        there_and_back, in_calm = windy.cost + windy.cost.T, calm.cost + calm.cost.T
        assert (there_and_back <= in_calm * (1 + (1e-6 if name == "corridor" else 1e-12))).all()
        # and the scenario's own wind stays below the ground speed
        scenario = make_scenario(name, 15, 2, seed=3, wind=wind)
        assert np.linalg.norm(scenario.wind(scenario.region.sample(500, np.random.default_rng(0))), axis=1).max() <= 8.0


@pytest.mark.parametrize("wind", ["none", "uniform", "rotation"])
def test_corridor_costs_are_true_ones(wind):
    """Never above the best path through corners only, of old files; in calm and uniform wind there is no better one."""
    instance = generate("corridor", 10, 2, seed=3, wind=wind)
    scenario = make_scenario("corridor", 10, 2, seed=3, wind=wind)
    through_corners = old_corridor_costs(scenario.points, scenario.region, scenario.speed, scenario.wind)
    off = ~np.eye(12, dtype=bool)
    ratio = instance.cost[off] / through_corners[off]
    assert ratio.max() <= 1 + 1e-6
    if wind == "rotation":
        assert ratio.min() < 0.99
    else:
        assert ratio.min() >= 1 - 1e-6


def test_corridor_says_what_its_legs_flew_around():
    stated = generate("corridor", 3, 1, seed=0, wind="shear").provenance["surroundings"]
    scenario = make_scenario("corridor", 3, 1, seed=0, wind="shear")
    assert stated["region"] == [ring.tolist() for ring in scenario.region.rings]
    assert stated["wind"] == scenario.wind.to_toml()


@pytest.mark.parametrize("name", ["wind-uniform", "wind-vortices"])
def test_planned_costs_come_with_their_paths(name):
    scenario = make_scenario(name, 4, 2, seed=1)
    instance, paths = costed(scenario, FAMILIES.load(name).legs)
    assert instance.provenance["moving_cost"] == {"method": "refined"}
    assert check_paths(paths, instance.cost, scenario.points, scenario.free, scenario.wind, scenario.speed) == []


def test_a_wind_as_fast_as_the_uavs_where_arcs_lead_is_refused():
    with pytest.raises(InputError, match=r"wind: it reaches .* must stay below the ground speed"):
        generate("uniform", 5, 2, seed=0, wind="rotation", wind_speed=19)


def test_parameters_as_text_from_a_command_line():
    as_text = generate("clustered", 8, 2, seed=0, clusters="2", cluster_sd="500", wind="shear", wind_speed="3.5")
    as_numbers = generate("clustered", 8, 2, seed=0, clusters=2, cluster_sd=500.0, wind="shear", wind_speed=3.5)
    assert as_text.digest == as_numbers.digest


@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 4), (3, 7)])
@pytest.mark.parametrize("name", FAMILIES.built_in)
def test_few_tasks_and_many_uavs(tmp_path, name, n, m):
    instance = generate(name, n, m, seed=0, **COARSE.get(name, {}))
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


@pytest.mark.slow
def test_five_thousand_tasks_fit(tmp_path):
    """A matrix of 0.2 GB is inevitable; its file is not."""
    instance = generate("clustered", 5000, 10, seed=0)
    write_instance(instance, tmp_path / "a.json")
    assert (tmp_path / "a.json").stat().st_size < 400_000
    assert hashlib.sha256(read_instance(tmp_path / "a.json").cost).digest() == hashlib.sha256(instance.cost).digest()


def test_a_dense_survey_has_the_spacing_asked_for_and_headings_for_states():
    instance = generate("dense-survey", 8, 2, 1, spacing=2.0, radius=100.0, headings=6, sights=1)
    assert instance.axes == {"states"}
    assert instance.provenance["turns"]["radius"] == 100.0
    assert 0.5 < np.ptp(instance.coordinates[:8], axis=0).max() / (2.0 * 100.0 * np.sqrt(8)) <= 1.0
    straight = np.hypot(*(instance.coordinates[0] - instance.coordinates[1])) / instance.provenance["turns"]["speed"]
    assert instance.cost[0, 1] >= straight * (1 - 1e-12)
    with pytest.raises(InputError, match="a task needs a heading"):
        generate("dense-survey", 8, 2, 1, headings=0)
