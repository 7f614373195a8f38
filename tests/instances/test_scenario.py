import contextlib
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from instances import InputError
from instances.environment.region import Region
from instances.environment.wind import Rotation, Shear, Uniform
from instances.environment.wind_table import Sum
from instances.families import FAMILIES, make_scenario
from instances.moving_cost import CostKind
from instances.scenario import Scenario, read_scenario, write_scenario

AREA = {"type": "Polygon", "coordinates": [[[0, 0], [100, 0], [0, 100], [0, 0]]]}
ZONE = {"type": "Polygon", "coordinates": [[[10, 10], [20, 10], [20, 20], [10, 20], [10, 10]]]}


def read(folder, text):
    (folder / "mission.toml").write_text(text)
    return read_scenario(folder / "mission.toml")


GOOD = """
ground_speed = 20
size = [100, 50.5]
depots = [[0, 0], [100, 50.5]]
tasks = [[1, 2], [3.5, 4]]
"""


def test_the_plainest_file(tmp_path):
    scenario = read(tmp_path, GOOD)
    assert (scenario.name, scenario.speed, scenario.wind) == ("mission", 20.0, None)
    assert scenario.region.bounds == (0, 0, 100, 50.5)
    assert scenario.points.tolist() == [[1, 2], [3.5, 4], [0, 0], [100, 50.5]]
    assert (scenario.n_tasks, scenario.n_depots) == (2, 2)


def test_the_cost_says_which_speed_is_held_constant(tmp_path, caplog):
    assert read(tmp_path, GOOD).cost is CostKind.ENERGY
    timed = read(tmp_path, "cost = 'time'\n" + GOOD.replace("ground_speed", "airspeed"))
    assert (timed.cost, timed.speed) == (CostKind.TIME, 20.0)
    write_scenario(timed, tmp_path / "again.toml")
    assert read_scenario(tmp_path / "again.toml").cost is CostKind.TIME
    assert not caplog.messages


def test_an_energys_speed_is_read_under_its_old_key_with_a_notice(tmp_path, caplog):
    old = read(tmp_path, GOOD.replace("ground_speed", "airspeed"))
    assert (old.cost, old.speed) == (CostKind.ENERGY, 20.0)
    assert "mission.toml: airspeed is read as ground_speed" in caplog.text
    write_scenario(old, tmp_path / "again.toml")
    assert "\nground_speed = 20.0\n" in (tmp_path / "again.toml").read_text()


def test_everything_a_file_can_say(tmp_path):
    (tmp_path / "area.geojson").write_text(json.dumps(AREA))
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE))
    text = """
name = "survey"
ground_speed = 100.0
region = "area.geojson"
no_fly = "zones.geojson"
depots = [[1, 1]]
tasks = 40
terrain = "dem.tif"
[wind]
kind = "shear"
rate = 0.1
centre = [0, 50]
[radio]
frequency = 146e6
[provenance]
made_by = "hand"
"""
    scenario = read(tmp_path, text)
    assert scenario.name == "survey"
    assert scenario.n_tasks == 40
    assert scenario.tasks is None
    assert scenario.wind == Shear(0.1, (0.0, 50.0))
    assert scenario.terrain == tmp_path / "dem.tif"
    assert scenario.radio == {"frequency": 146e6}
    assert scenario.provenance == {"made_by": "hand"}
    assert scenario.free.area == 5000 - 100
    with pytest.raises(InputError, match="40 tasks are not placed yet"):
        _ = scenario.points


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (GOOD.replace("ground_speed", "airsped"), "unknown key 'airsped'; did you mean 'airspeed'"),
        (GOOD.replace("ground_speed = 20", ""), "the key 'ground_speed' is missing"),
        (GOOD.replace("ground_speed = 20", "cost = 'time'"), "the key 'airspeed' is missing"),
        ("cost = 'time'\n" + GOOD, "cost = 'time' is reckoned at a constant airspeed: give 'airspeed', not 'ground"),
        (GOOD + "airspeed = 20", "cost = 'energy' is reckoned at a constant ground_speed: give 'ground_speed' alone"),
        (GOOD + "cost = 'tmie'", "cost must be 'energy' or 'time', got 'tmie'"),
        (GOOD + "cost = [1]", r"cost must be 'energy' or 'time', got \[1\]"),
        (GOOD.replace("depots", "depot"), "unknown key 'depot'; did you mean 'depots'"),
        (GOOD.replace("= 20", "= 0"), r"ground_speed must be a positive number \[m/s\], got 0"),
        (GOOD.replace("= 20", "= nan"), "ground_speed .* got nan"),
        (GOOD.replace("= 20", '= "20"'), "ground_speed .* got '20'"),
        (GOOD.replace("= 20", f"= {10**400}"), "ground_speed"),
        (GOOD.replace("[100, 50.5]\n", "[100]\n", 1), "size must be two positive numbers"),
        (GOOD.replace("[100, 50.5]\n", "[100, -1]\n", 1), r"size must be two positive numbers \[m\], got \[100, -1\]"),
        (GOOD.replace("size = [100, 50.5]", ""), "the key 'size' or 'region' is missing"),
        (GOOD + 'region = "a.geojson"', "either 'size' or 'region' must be given, not both"),
        (GOOD.replace("[0, 0]", "[-1, 0]"), r"depots\[0\] = \[-1.0, 0.0\] lies outside the region"),
        (GOOD.replace("[0, 0]", "[0, 0, 0]"), r"depots\[0\] must be two numbers"),
        (GOOD.replace("[0, 0]", '["0", 0]'), r"depots\[0\] must be two numbers"),
        (GOOD.replace("[0, 0]", "[true, 0]"), r"depots\[0\] must be two numbers"),
        (GOOD.replace("[0, 0]", "[nan, 0]"), r"depots\[0\] = \[nan, 0.0\] is not finite"),
        (GOOD.replace("depots = [[0, 0], [100, 50.5]]", "depots = []"), "depots must be a list of at least one point"),
        (GOOD.replace("[3.5, 4]", "[3.5, 400]"), r"tasks\[1\] = \[3.5, 400.0\] lies outside the region"),
        (
            GOOD.replace("[[1, 2], [3.5, 4]]", "0"),
            "tasks must be points, or a file of them, or a whole .* of at least 1",
        ),
        (GOOD.replace("[[1, 2], [3.5, 4]]", "true"), "tasks must be a list of points|tasks must be"),
        (GOOD.replace("[[1, 2], [3.5, 4]]", '"many"'), "tasks"),
        (GOOD + 'no_fly = "missing.geojson"', "missing.geojson: cannot be read"),
        (GOOD + "no_fly = 3", "no_fly must be the name of a file, got 3"),
        (GOOD + "wind = 3", r"\[wind\] must be a table, got 3"),
        (GOOD + '[wind]\nkind = "unform"', r"\[wind\] kind must be one of .*, got 'unform'; did you mean 'uniform'"),
        (
            GOOD + '[wind]\nkind = "uniform"\nvelocty = [1, 2]',
            "unknown key 'velocty' of kind = 'uniform'; did you mean 'velocity'",
        ),
        (GOOD + "name = ''", "name must be a non-empty text, got ''"),
        (GOOD + "name = 'a/b'", "name is used in file names"),
        ("airspeed = ", "is not valid TOML"),
        ("a = " + "[" * 5000, "is not valid TOML"),
        ("\x00", "binary"),
    ],
)
def test_one_sentence_names_file_key_and_value(tmp_path, text, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        read(tmp_path, text)
    assert "mission.toml: " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_depot_in_a_no_fly_zone(tmp_path):
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE))
    with pytest.raises(InputError, match=r"tasks\[0\] = \[15.0, 15.0\] lies outside the region or in a no-fly zone"):
        read(tmp_path, GOOD.replace("[1, 2]", "[15, 15]") + 'no_fly = "zones.geojson"')


def same(a, b):
    assert (a.name, a.speed, a.wind, a.n_tasks, a.provenance) == (
        b.name,
        b.speed,
        b.wind,
        b.n_tasks,
        b.provenance,
    )
    assert a.depots.tobytes() == b.depots.tobytes()
    assert (a.tasks is None) == (b.tasks is None)
    assert a.tasks is None or a.tasks.tobytes() == b.tasks.tobytes()
    assert [r.tolist() for r in a.region.rings] == [r.tolist() for r in b.region.rings]
    assert [z.wkb for z in a.no_fly] == [z.wkb for z in b.no_fly]


@pytest.mark.parametrize("name", [name for name in FAMILIES.built_in if name != "wind-mountains"])
def test_a_familys_mission_round_trips(tmp_path, name):
    scenario = make_scenario(name, 6, 2, seed=4)
    write_scenario(scenario, tmp_path / "a.toml")
    same(scenario, read_scenario(tmp_path / "a.toml"))


def test_a_region_left_of_the_origin_round_trips(tmp_path):
    region = Region(Polygon([(-9, -9), (-1, -9), (-1, -1), (-9, -1)]))
    scenario = Scenario("west", region, np.array([[-5.0, -5.0]]), 20.0, n_tasks=3)
    write_scenario(scenario, tmp_path / "a.toml")
    same(scenario, read_scenario(tmp_path / "a.toml"))
    assert (tmp_path / "a-region.geojson").exists()


numbers = st.floats(0, 1000).map(lambda x: x + 0.0)
any_wind = st.none() | st.one_of(
    st.builds(Uniform, st.tuples(numbers, numbers)),
    st.builds(Shear, numbers, st.tuples(numbers, numbers)),
    st.just(Sum((Uniform((1.0, 2.0)), Rotation(1e-4, (3.0, 4.0))))),
)


@settings(deadline=None, max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.text(min_size=1).filter(lambda t: t.strip() and t.isprintable() and not set(t) & set("./\\")),
    st.lists(st.tuples(numbers, numbers), min_size=1, max_size=4),
    st.integers(1, 9) | st.lists(st.tuples(numbers, numbers), min_size=1, max_size=4),
    any_wind,
    st.booleans(),
    st.booleans(),
)
def test_any_mission_round_trips(tmp_path, name, depots, tasks, wind, notched, zoned):
    outline = [(0, 0), (1000, 0), (1000, 1000), (0, 1000)] + ([(-1 / 3, 500)] if notched else [])
    scenario = Scenario(
        name=name,
        region=Region(Polygon(outline)) if notched else Region.rectangle(1000, 1000),
        depots=np.array(depots),
        speed=1 / 3,
        wind=wind,
        tasks=None if isinstance(tasks, int) else np.array(tasks),
        n_tasks=tasks if isinstance(tasks, int) else 0,
        no_fly=[Polygon([(1001, 0), (1002, 0), (1002, 1)])] if zoned else [],
        provenance={"family": "x", "parameters": {"a b": 1, "c": 'ä"\\'}, "seed": 3},
    )
    write_scenario(scenario, tmp_path / "a.toml")
    same(scenario, read_scenario(tmp_path / "a.toml"))


@settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, len(GOOD)), st.integers(0, 8), st.text('019.-"[]{}=,\n nasizewd', max_size=5))
def test_damaged_files_are_read_or_refused_in_a_sentence(tmp_path, start, length, instead):
    with contextlib.suppress(InputError):  # any other exception fails
        read(tmp_path, GOOD[:start] + instead + GOOD[start + length :])
