"""Mission files: the shipped one is read; what is wrong in others is said in one sentence, exit code 2."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from instances.errors import InputError
from instances.formats.mavlink_items import Vehicle
from workbench.mission.belief import known_tau
from workbench.mission.file import mission_of, read_mission, shipped_missions

TABLE = {
    "airspeed": 100.0,
    "size": [4000, 4000],
    "depots": [[500, 500], [3500, 500]],
    "tasks": 6,
    "radio": {"position": [2000, 2000]},
}


def changed(**changes: object) -> dict:
    return TABLE | changes


def test_the_shipped_mission_is_the_papers_example() -> None:
    mission = read_mission(shipped_missions()["paper"])
    assert mission.scenario.n_tasks == 40
    assert mission.scenario.n_depots == 3
    assert mission.scenario.region.bounds == (0.0, 0.0, 20000.0, 20000.0)
    assert (mission.speed, mission.flight.turning_radius, mission.flight.altitude) == (100.0, 50.0, 3000.0)
    assert (mission.sensing.period, mission.sensing.noise_sd) == (10.0, 1.0)
    assert (mission.map.signal_sd, mission.map.length_scale) == (30.0, 4000.0)


def test_the_second_shipped_mission_has_a_wind_of_vortices_below_its_speed() -> None:
    scenario = read_mission(shipped_missions()["lee"]).scenario
    assert scenario.wind is not None
    speeds = np.hypot(*scenario.wind(scenario.region.cell_centres(40, 40)).T)
    assert 9.0 < speeds.max() < 0.6 * scenario.speed


def test_a_shipped_mission_goes_by_its_name(cli) -> None:
    code, _, err = cli("mission", "lee", "--out", "made", "--stage", "flihgt")
    assert (code, "did you mean 'flight'" in err) == (2, True)


def test_speed_is_the_airspeed_and_clearance_two_radii_unless_given() -> None:
    mission = mission_of(TABLE, Path(), "m")
    assert (mission.speed, mission.clearance) == (100.0, 100.0)
    mission = mission_of(changed(flight={"speed": 30.0, "turning_radius": 40}, costs={"clearance": 5}), Path(), "m")
    assert (mission.speed, mission.clearance) == (30.0, 5)


def test_plans_are_for_px4_and_a_fixed_wing_unless_said() -> None:
    assert mission_of(TABLE, Path(), "m").vehicle == Vehicle("px4", "fixed-wing")
    said = {"firmware": "ardupilot", "vehicle": "multirotor"}
    assert mission_of(changed(export=said), Path(), "m").vehicle == Vehicle("ardupilot", "multirotor")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"airspede": 1.0}, r"unknown key 'airspede'; did you mean 'airspeed'\?"),
        ({"sensing": {"perod": 10}}, r"\[sensing\]: unknown key 'perod'; did you mean 'period'\?"),
        ({"sensing": {"period": "10 s"}}, r"\[sensing\] period must be a positive number \[s\], got '10 s'"),
        ({"sensing": {"period": -1}}, r"\[sensing\] period must be a positive number \[s\], got -1"),
        ({"sensing": {"period": True}}, r"\[sensing\] period must be a positive number"),
        ({"sensing": {"period": float("nan")}}, r"\[sensing\] period must be a positive number"),
        ({"sensing": {"period": 1e6}}, r"sensing\.period = 1e\+06 s is longer than any tour"),
        ({"sensing": 10}, r"\[sensing\] must be a table"),
        ({"service": 30}, r"a mission flies all UAVs at one speed, past its tasks without a stop"),
        ({"map": {"length_scale": 4}}, r"map\.length_scale = 4 m is at most a .*: lengths are in metres"),
        ({"place": {"length_scale": [4000, 0]}}, r"\[place\] length_scale\[1\] must be a positive number \[m\], got 0"),
        ({"place": {"tests": [0, 10]}}, r"\[place\] tests must be two whole numbers from 1 to 1000"),
        ({"place": {"method": "greddy"}}, r"unknown placement method 'greddy'; did you mean 'greedy'\?"),
        ({"costs": {"method": "fmtstar"}}, r"unknown moving-cost method 'fmtstar'; did you mean 'fmt-star'\?"),
        ({"routes": {"solver": "greddy"}}, r"unknown solver 'greddy'; did you mean 'greedy'\?"),
        (
            {"compare": {"baselines": ["lawnmover"]}},
            r"baselines\[0\] must .* got 'lawnmover'; did you mean 'lawnmower'\?",
        ),
        ({"flight": {"turning_radius": 0.05}}, r"turning_radius = 0\.05 m at 100 m/s would need .* g: lengths are in"),
        ({"flight": {"turning_radius": 3000}}, r"turning_radius = 3000 m is more than a quarter of the region"),
        (
            {"field": {"model": "difraction"}},
            r"\[field\] model must .* got 'difraction'; did you mean 'diffraction'\?",
        ),
        (
            {"export": {"firmware": "cleanflight"}},
            r"\[export\] firmware must be .* or 'px4', got 'cleanflight'",
        ),
        ({"export": {"vehicle": 1}}, r"\[export\] vehicle must be 'fixed-wing' or 'multirotor', got 1"),
        ({"tasks": 1}, r"more UAVs \(2 depots\) than tasks \(1\)"),
        ({"depots": [[-5, 0], [1, 1]]}, r"depots\[0\] = \[-5\.0, 0\.0\] lies outside the region or in a no-fly zone"),
        ({"origin": [36.0]}, r"origin must be \[latitude, longitude\] in degrees"),
        ({"origin": [128.0, 36.0]}, r"origin must be \[latitude, longitude\] in degrees, at most 89"),
        ({"scenario": "other.toml"}, r"'airspeed' belongs into the scenario file"),
    ],
)
def test_what_is_wrong_is_one_sentence(changes: dict, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as raised:
        mission_of(changed(**changes), Path(), "m")
    assert "\n" not in str(raised.value)


def test_nothing_to_measure() -> None:
    with pytest.raises(InputError, match="nothing to measure"):
        mission_of({key: value for key, value in TABLE.items() if key != "radio"}, Path(), "m")


def test_a_depot_in_a_no_fly_zone_is_exit_code_2_and_leaves_nothing(cli, tmp_path: Path) -> None:
    zone = '{"type": "Polygon", "coordinates": [[[0, 0], [1000, 0], [1000, 1000], [0, 1000], [0, 0]]]}'
    (tmp_path / "zones.geojson").write_text(zone)
    (tmp_path / "m.toml").write_text(
        'airspeed = 100\nsize = [4000, 4000]\nno_fly = "zones.geojson"\ndepots = [[500, 500]]\ntasks = 5\n'
        "[radio]\nposition = [2000, 2000]\n"
    )
    code, out, err = cli("mission", "m.toml", "--out", "made")
    assert code == 2
    assert err.strip().count("\n") == 0
    assert "m.toml: depots[0] = [500.0, 500.0] lies outside the region or in a no-fly zone" in err
    assert out == ""
    assert not (tmp_path / "made").exists()


def test_a_scenario_of_its_own_may_be_named(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(
        "airspeed = 50\nsize = [4000, 4000]\ndepots = [[1, 1]]\ntasks = 3\n[radio]\nposition = [2000, 2000]\n"
    )
    (tmp_path / "m.toml").write_text('scenario = "s.toml"\n[sensing]\nperiod = 2\n')
    assert read_mission(tmp_path / "m.toml").scenario.speed == 50


@pytest.mark.parametrize("text", ["airspeed = ", "\0", "a = 1\na = 2"])
def test_files_that_are_no_toml(tmp_path: Path, text: str) -> None:
    (tmp_path / "m.toml").write_text(text)
    with pytest.raises(InputError, match=r"m\.toml"):
        read_mission(tmp_path / "m.toml")


@pytest.mark.parametrize(
    ("field", "words"),
    [
        (
            {"tau": 600.0, "shadowing_sd": 0.0},
            r"field\.tau is of the shadowing that drifts, and field\.shadowing_sd is 0",
        ),
        ({"tau": 600.0, "file": "field.csv"}, r"field\.tau is of the shadowing that drifts, and the field is a file"),
        ({"tau": 0.0}, r"\[field\] tau must be a positive number \[s\]"),
    ],
)
def test_only_shadowing_drifts(tmp_path: Path, field: dict, words: str) -> None:
    (tmp_path / "field.csv").touch()
    with pytest.raises(InputError, match=words):
        mission_of(changed(field=field), tmp_path, "m")


@pytest.mark.parametrize("tau", ["never", 0, -3.0])
def test_the_maps_tau_is_auto_or_positive(tau: object) -> None:
    with pytest.raises(InputError, match=r"\[map\] tau must be a positive number \[s\] or 'auto'"):
        mission_of(changed(map={"tau": tau}), Path(), "m")
    assert known_tau(mission_of(changed(map={"tau": 600}), Path(), "m")) == 600.0
    assert known_tau(mission_of(changed(map={"tau": "auto"}), Path(), "m")) == math.inf
