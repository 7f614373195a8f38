import numpy as np
import pytest

from instances import InputError
from instances.best_known import table
from instances.families import FAMILIES, make_scenario

WINDY = ["uniform", "clustered", "ring", "corridor"]
"""Families with every option of wind and depots."""


def test_the_families_we_promise_are_there_and_say_what_they_take():
    plain = {"uniform", "clustered", "ring", "corridor", "square-wind"}
    changing = {"wind-turning", "wind-valley", "wind-front", "wind-drifting"}
    missions = {"wind-uniform", "wind-vortices", "wind-mountains"}
    assert set(FAMILIES.built_in) == plain | {"mixed-fleet", "dense-survey"} | missions | changing
    for name, (_, about) in FAMILIES.targets().items():
        assert about
        for parameter in FAMILIES.load(name).parameters:
            assert parameter.meaning
            assert parameter.checked(parameter.default) == parameter.default
            assert parameter.checked(str(parameter.default)) == parameter.default


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


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        ({"name": "unifrom"}, "unknown family 'unifrom'; did you mean 'uniform'"),
        ({"winds": "shear"}, "family uniform has no parameter 'winds'; did you mean 'wind'"),
        ({"wind": "sheer"}, "wind: 'sheer' is not one of none, uniform, shear, rotation; did you mean 'shear'"),
        ({"wind": 3}, "wind: 3 is not one of"),
        ({"airspeed": 0}, r"ground_speed: must be a number of at least 1e-09 \[m/s\], got 0"),
        ({"airspeed": "fast"}, "ground_speed: must be a number"),
        ({"airspeed": float("nan")}, "ground_speed: must be a number"),
        ({"airspeed": 10**400}, "ground_speed: must be a number"),
        ({"airspeed": True}, "ground_speed: must be a number"),
        ({"airspeed": [20]}, "ground_speed: must be a number"),
        ({"wind": "uniform", "wind_speed": 20}, "wind_speed: must be below the ground speed of 20 m/s, got 20 m/s"),
        ({"name": "clustered", "clusters": 2.5}, "clusters: must be a whole number of at least 1, got 2.5"),
        ({"name": "clustered", "clusters": 0}, "clusters: must be a whole number of at least 1, got 0"),
        ({"name": "ring", "radius": 9_500}, "radius ± width/2 must lie between 0 and size/2 = 10000 m"),
        ({"name": "corridor", "opening": 20_000}, "opening must be below size = 20000 m"),
        ({"name": "corridor", "walls": 100}, "100 walls of thickness 400 m fill the size"),
        ({"name": "square-wind", "wind": "shear"}, r"family square-wind has no parameter 'wind' \(it has none\)"),
        ({"n_tasks": 0}, "n_tasks must be a whole number of at least 1, got 0"),
        ({"n_tasks": 10**6}, "1000000 tasks and 2 depots are more than the 100000 nodes"),
        ({"n_depots": 1.0}, "n_depots must be a whole number of at least 1, got 1.0"),
        ({"seed": -1}, "seed must be a whole number of at least 0, got -1"),
    ],
)
def test_bad_names_and_values_in_one_sentence(call, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        make_scenario(**{"name": "uniform", "n_tasks": 5, "n_depots": 2, "seed": 0, **call})
    assert "\n" not in str(caught.value)


def test_the_table_of_best_known_values_is_consistent():
    rows = table()
    assert len(rows) > 150
    for digest, row in rows.items():
        assert len(digest) == 12
        assert row.source
        assert row.bound is None or row.bound <= row.best_known * (1 + 1e-9)
        assert row.proven == (row.bound is not None and row.bound >= row.best_known * (1 - 1e-6))
