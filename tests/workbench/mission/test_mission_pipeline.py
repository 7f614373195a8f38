"""The mission's stages: their products, skipped where up to date, run alone, continued after a kill."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import rasterio
import shapely
from geojson_pydantic import FeatureCollection
from rasterio.warp import transform_bounds

from formulations.selection.selection_files import check_selection
from instances.errors import InputError
from instances.files import read_instance, read_routes
from instances.formats.netcdf import read_grids
from instances.geodesy import TangentPlane
from instances.routes import check_routes, makespan
from workbench.mission import environment
from workbench.mission.file import mission_of, read_mission
from workbench.mission.pipeline import FOLDERS, NAMES, STAGES, run_mission
from workbench.mission.place import write_tasks

SMALL = """
airspeed = 50.0
size = [6000, 5000]
no_fly = "zones.geojson"
depots = [[500, 500], [5500, 500]]
tasks = 8
origin = [47.0, 8.0]

[wind]
kind = "rotation"
rate = 1e-3
centre = [3000, 2500]

[radio]
position = [3000, 2500]

[field]
model = "free-space"
shadowing_sd = 2.0
cells = 30

[place]
method = "greedy"
tests = [6, 6]
length_scale = 1500.0

[costs]
method = "dijkstra"

[routes]
solver = "greedy"
time_limit = 1.0
bound_time_limit = 0.0

[sensing]
period = 6.0

[map]
length_scale = 1500.0
refit_every = 50
cells = 20
frames = 4

[compare]
seeds = 2
time_limit = 0.5
"""
ZONE = {"type": "Polygon", "coordinates": [[[2600, 1800], [3400, 1800], [3400, 3000], [2600, 3000], [2600, 1800]]]}


@pytest.fixture(scope="module")
def mission_file(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("mission")
    (folder / "zones.geojson").write_text(json.dumps(ZONE))
    (folder / "small.toml").write_text(SMALL)
    return folder / "small.toml"


@pytest.fixture(scope="module")
def made(mission_file: Path, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("made") / "out"
    run_mission(read_mission(mission_file), out)
    return out


@pytest.fixture
def copied(made: Path, tmp_path: Path) -> Path:
    shutil.copytree(made, tmp_path / "copy")
    return tmp_path / "copy"


@pytest.fixture
def plain_page(monkeypatch) -> None:
    """A page without figures, for tests of which stages are made: they are most of a small mission's seconds."""

    def write(folders: dict[str, Path], path: Path, said: dict) -> list:
        path.write_text("plain")
        return []

    monkeypatch.setattr("workbench.mission.report.write_mission_page", write)


def again(mission_file: Path, out: Path, text: str = SMALL, **how: str) -> list[str]:
    """Run a mission and return the stages that were made, not skipped."""
    told: list[str] = []
    mission = mission_of(tomllib.loads(text), mission_file.parent, "small")
    run_mission(mission, out, tell=told.append, **how)
    return [name for name in NAMES if any(re.match(rf"{name}: .* \(\d+\.\d s\)$", line) for line in told)]


def test_every_stage_leaves_its_products(made: Path) -> None:
    instance = read_instance(made / "3-costs/instance.json")
    assert (instance.n_tasks, instance.n_depots) == (8, 2)
    assert check_routes(instance, read_routes(made / "4-routes/routes.sol", instance)) == []
    axes, maps = read_grids(made / "6-map/maps.nc")
    assert maps["mean"].values.shape == (len(axes["time"]), 17, 20)
    compared, draws = (pd.read_csv(made / f"7-compare/{name}.csv") for name in ("compare", "compare-draws"))
    assert list(compared["name"]) == ["mission", "lawnmower", "random", "greedy"]
    assert list(draws["draw"]) == [0] * 4 + [1] * 4
    np.testing.assert_allclose(compared["rmse"], draws.groupby("name", sort=False)["rmse"].mean())
    assert draws["information"][0] == pytest.approx(pd.read_csv(made / "6-map/ticks.csv")["information"].iloc[-1])
    bound = json.loads((made / "4-routes/bound.json").read_text())
    assert 0 < bound["bound"] <= bound["objective"]
    assert bound["gap"] == pytest.approx(1 - bound["bound"] / bound["objective"])
    assert not list(made.glob(".*"))


def test_polished_tours_promise_more_and_are_no_longer_than_the_longest(copied: Path, mission_file: Path) -> None:
    text = SMALL.replace("[place]", "[place]\npolish = true")
    assert again(mission_file, copied, text, only="flight") == ["flight"]
    said = json.loads((copied / "5-flight/polish.json").read_text())
    assert said["bound"] <= said["rms_sd_after"] < said["rms_sd_before"]
    assert max(said["costs_after"]) <= max(said["costs_before"]) == max(said["budgets"])
    checks = pd.read_csv(copied / "5-flight/flight-check.csv")
    assert (checks["in_no_fly"] == 0).all()
    assert (checks["margin"] > -0.02).all()
    assert (checks["least_radius"] > 49.9).all()
    assert (checks["task_distance"] < 11).all()
    again(mission_file, copied, only="place")  # tasks are placed as without polish


def test_chosen_tours_show_time_energy_and_calm_air_beside_each_other(made: Path) -> None:
    tours = pd.read_csv(made / "4-routes/tours.csv")
    run = json.loads((made / "4-routes/run.json").read_text())
    np.testing.assert_allclose(tours["energy"], run["tour_costs"], rtol=1e-6)
    assert (tours["flight_time"] > 0).all()
    np.testing.assert_allclose(tours["calm"], tours["length"] / 50.0)
    page = (made / "8-report/report.html").read_text()
    for words in ("Flight time", "Energy cost", "In calm air", "drag energy at a constant ground speed of 50 m/s"):
        assert words in page


def test_a_mission_in_wind_has_a_calm_twin(made: Path) -> None:
    cost = pd.read_csv(made / "7-compare/calm.csv").set_index("plan")["longest"]
    assert cost["better"] <= min(cost["calm"], cost["worse"])
    assert cost["wind"] == pytest.approx(json.loads((made / "4-routes/run.json").read_text())["objective"], rel=1e-6)
    assert "What planning in the wind is worth" in (made / "report.html").read_text()


def test_flights_keep_the_radius_pass_the_tasks_and_stay_out_of_the_zone(made: Path) -> None:
    checks = pd.read_csv(made / "5-flight/flight-check.csv")
    assert (checks["least_radius"] >= 50.0 - 1e-6).all()
    assert (checks["task_distance"] <= 0.1).all()
    assert (checks["closure"] <= 1e-6).all()
    assert (checks[["in_no_fly", "outside"]] == 0.0).all(axis=None)
    assert (checks["margin"] > 100.0).all()
    assert (checks["clearance"] == 3000.0).all()
    flown = pd.read_csv(made / "5-flight/flown.csv")
    assert (flown["z"] == 3000.0).all()
    inside = flown["x"].between(2600, 3400) & flown["y"].between(1800, 3000)
    assert not inside.any()


def test_maps_are_masked_outside_the_region_and_never_uncertain_below_zero(made: Path) -> None:
    _, maps = read_grids(made / "6-map/maps.nc")
    sd = maps["sd"].values
    assert (sd[np.isfinite(sd)] >= 0).all()
    samples = pd.read_csv(made / "6-map/samples.csv")
    assert len(samples) == pd.read_csv(made / "6-map/ticks.csv")["samples"].iloc[-1]
    np.testing.assert_allclose(samples["time"] % 6.0, 0.0, atol=1e-9)


def test_the_page_is_self_contained_and_small(made: Path) -> None:
    page = (made / "report.html").read_text(encoding="utf-8")
    assert page == (made / "8-report/report.html").read_text(encoding="utf-8")
    assert len(page) < 5e6
    told = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)  # scripts hold addresses of what they may make
    linked = re.findall(r'(?:src|href)="(?!data:|#)([^"]+)"', told)
    assert {"5-flight/uav-0.plan", "5-flight/uav-1.waypoints", "2-place/tasks.geojson"} <= set(linked)
    assert all((made / address).is_file() for address in linked)
    for words in (
        "uav-0.plan",
        "RMSE",
        "NLPD",
        "lawnmower",
        "Initial and final stage",
        "Reference paths and flown paths",
        "Heights of the tours",
    ):
        assert words in page


def test_ground_control_files_hold_the_tour(made: Path) -> None:
    plan = json.loads((made / "5-flight/uav-0.plan").read_text())
    items = plan["mission"]["items"]
    assert [items[0]["command"], items[-1]["command"]] == [22, 20]
    assert plan["mission"]["plannedHomePosition"][2] == 0.0
    assert [fence["inclusion"] for fence in plan["geoFence"]["polygons"]] == [True, False]
    assert "home is put at 0 m" in (made / "report.html").read_text(encoding="utf-8")


def test_every_geojson_of_a_mission_is_in_degrees(made: Path) -> None:
    low, high = TangentPlane(47.0, 8.0).geographic([[-500.0, -500.0], [6500.0, 5500.0]])[:, ::-1]
    files = {path.relative_to(made).as_posix(): path for path in made.rglob("*.geojson")}
    assert {"2-place/tasks.geojson", "5-flight/area.geojson", "5-flight/flown.geojson"} < set(files)
    for path in files.values():
        features = FeatureCollection.model_validate_json(path.read_text()).features
        places = shapely.get_coordinates([shapely.geometry.shape(f.geometry.model_dump()) for f in features])
        assert ((low < places) & (places < high)).all()


@pytest.mark.parametrize("file", ["estimate.tif", "uncertainty.tif", "field.tif", "maps.nc"])
def test_maps_lie_where_the_mission_is(made: Path, file: str) -> None:
    path = made / "6-map" / file
    with rasterio.open(f"netcdf:{path}:mean" if path.suffix == ".nc" else path) as raster:
        low, high = TangentPlane(47.0, 8.0).geographic([[0.0, 0.0], [6000.0, 5000.0]])
        west, south, east, north = transform_bounds(raster.crs, "EPSG:4326", *raster.bounds)
        assert (south, west, north, east) == pytest.approx((*low, *high), abs=1e-4)
        assert raster.shape == (17, 20)


def test_tasks_without_an_origin_are_no_geojson(tmp_path: Path) -> None:
    write_tasks(np.array([[1.0, 2.0]]), tmp_path, {"method": "given"}, None)
    assert {path.name for path in tmp_path.iterdir()} == {"tasks.csv", "placement.json"}


def test_nothing_is_made_twice(mission_file: Path, copied: Path) -> None:
    assert again(mission_file, copied) == []


@pytest.mark.usefixtures("plain_page")
def test_a_change_is_made_from_its_stage_on(mission_file: Path, copied: Path) -> None:
    before = (copied / "6-map/samples.csv").read_bytes()
    changed = SMALL.replace("[compare]", '[compare]\nbaselines = ["lawnmower"]')
    assert again(mission_file, copied, changed) == ["compare", "report"]
    assert (copied / "6-map/samples.csv").read_bytes() == before
    assert list(pd.read_csv(copied / "7-compare/compare.csv")["name"]) == ["mission", "lawnmower"]


def test_a_changed_file_that_the_mission_names_is_noticed(mission_file: Path, copied: Path, tmp_path: Path) -> None:
    moved = tmp_path / "small.toml"
    moved.write_text(SMALL)
    zone = json.dumps(ZONE).replace("2600", "2500")
    (tmp_path / "zones.geojson").write_text(zone)
    assert again(moved, copied, only="environment") == ["environment"]


def test_a_file_that_the_scenario_file_names_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE))
    scenario, own = tmp_path / "scenario.toml", tmp_path / "mission.toml"
    keys, rest = SMALL.split("origin = [47.0, 8.0]")
    wind, _, others = rest.partition("[radio]")
    radio, _, others = others.partition("[field]")
    scenario.write_text(f"{keys}{wind}[radio]{radio}")
    own.write_text(f'scenario = "scenario.toml"\n[field]{others}')
    before = environment.settings(read_mission(own))
    assert environment.settings(read_mission(own)) == before
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE).replace("2600", "2500"))
    assert environment.settings(read_mission(own)) != before


def test_one_stage_alone(mission_file: Path, copied: Path) -> None:
    shutil.rmtree(copied / "7-compare")
    shutil.rmtree(copied / "6-map")
    assert again(mission_file, copied, only="map") == ["map"]
    assert not (copied / "7-compare").exists()


@pytest.mark.usefixtures("plain_page")
def test_a_stage_can_be_forced(mission_file: Path, copied: Path) -> None:
    assert again(mission_file, copied, force_from="report") == ["report"]


def test_a_stage_without_what_it_starts_from(mission_file: Path, copied: Path) -> None:
    shutil.rmtree(copied / "4-routes")
    with pytest.raises(InputError, match="stage 'flight' starts from the products of 'routes', which are not there"):
        again(mission_file, copied, only="flight")


def test_a_product_that_was_changed_is_noticed(mission_file: Path, copied: Path) -> None:
    (copied / "2-place/tasks.csv").write_text("x,y\n1,1\n")
    with pytest.raises(InputError, match="products of stage 'place' are missing or were changed"):
        again(mission_file, copied, only="costs")


def test_a_failing_stage_leaves_the_old_products(mission_file: Path, copied: Path) -> None:
    before = (copied / "5-flight/flown.csv").read_bytes()
    with pytest.raises(InputError, match=r"sensing\.period = 1000 s is longer than the longest tour"):
        again(mission_file, copied, SMALL.replace("period = 6.0", "period = 1000.0"))
    assert (copied / "5-flight/flown.csv").read_bytes() == before
    assert not list(copied.glob(".*.part"))


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (
            "border_clearance = 600.0",
            r"^UAV 0 would come within 3\d\d\.\d m of the region's border or a no-fly zone at .*",
        ),
        ("altitude = 20.0", r"^UAV 0 would come within 20\.0 m of the ground at .* \(flight\.clearance = 50 m\)"),
    ],
)
def test_a_flight_that_is_refused_leaves_no_plan(mission_file: Path, copied: Path, table: str, words: str) -> None:
    shutil.rmtree(copied / "5-flight")
    with pytest.raises(InputError, match=words):
        again(mission_file, copied, SMALL.replace("[sensing]", f"[flight]\n{table}\n\n[sensing]"), only="flight")
    assert not (copied / "5-flight").exists()
    assert not list(copied.rglob("*.plan"))


@pytest.mark.usefixtures("plain_page")
@pytest.mark.slow
def test_a_killed_mission_continues_where_it_was(mission_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    short = SMALL.replace("[compare]", '[compare]\nbaselines = ["lawnmower"]')
    slow = short.replace('solver = "greedy"\ntime_limit = 1.0', 'solver = "ruin-recreate"\ntime_limit = 60.0')
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONE))
    (tmp_path / "slow.toml").write_text(slow)
    command = [sys.executable, "-c", "from workbench.cli import main; main()", "mission", "slow.toml", "--out", "out"]
    child = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 120
    while not (out / "3-costs").exists() and time.monotonic() < deadline and child.poll() is None:
        time.sleep(0.05)
    child.send_signal(signal.SIGKILL)
    child.wait()
    assert (out / "3-costs").exists()
    assert not (out / "4-routes").exists()
    made_now = again(mission_file, out, short)
    assert made_now == [name for name in NAMES if name not in ("environment", "place", "costs")]
    assert not list(out.glob(".*.part"))


def test_folders_are_numbered_in_order() -> None:
    assert list(FOLDERS) == [stage.name for stage in STAGES]
    assert FOLDERS["flight"] == "5-flight"


def test_an_unknown_stage(cli) -> None:
    code, _, err = cli("mission", "--out", "made", "--stage", "flihgt")
    assert code == 2
    assert "unknown stage 'flihgt'; did you mean 'flight'?" in err


def test_stage_and_from_exclude_each_other(cli) -> None:
    code, _, err = cli("mission", "--out", "made", "--stage", "map", "--from", "map")
    assert code == 2
    assert "give one of them" in err


@pytest.mark.usefixtures("plain_page")
def test_a_mission_that_another_process_works_on_is_left_alone(mission_file: Path, copied: Path) -> None:
    other = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    try:
        (copied / f".8-report.{other.pid}.part").mkdir()
        with pytest.raises(InputError, match=f"process {other.pid} is working on this mission"):
            again(mission_file, copied, force_from="report")
    finally:
        other.communicate(b"\n")
    assert again(mission_file, copied, force_from="report") == ["report"]


@pytest.mark.usefixtures("plain_page")
@pytest.mark.slow
def test_stages_that_other_code_made_are_made_again(mission_file: Path, copied: Path, monkeypatch) -> None:
    assert again(mission_file, copied) == []
    stamp = json.loads((copied / "4-routes" / "stamp.json").read_text())
    assert len(stamp["code"]) == 12
    (copied / "4-routes" / "stamp.json").write_text(json.dumps(stamp | {"code": "0" * 12}))
    assert again(mission_file, copied)[0] == "routes"
    assert again(mission_file, copied) == []


def test_without_the_extra_geo_a_mission_says_that_it_writes_no_geotiff(
    mission_file: Path, copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("workbench.mission.map.find_spec", lambda _: None)
    told: list[str] = []
    run_mission(read_mission(mission_file), copied, force_from="map", only="map", tell=told.append)
    assert "map: no GeoTIFFs: they need the extra 'geo'" in told
    assert {"maps.nc", "map.csv"} <= {path.name for path in (copied / "6-map").iterdir()}
    assert not list((copied / "6-map").glob("*.tif"))


@pytest.mark.slow
def test_where_endurance_does_not_suffice_the_tasks_that_tell_most_are_flown(mission_file: Path, copied: Path) -> None:
    instance = read_instance(copied / "3-costs/instance.json")
    all_of_them = makespan(instance, read_routes(copied / "4-routes/routes.sol", instance))
    text = SMALL.replace("[sensing]", f"[flight]\nendurance = {0.7 * all_of_them}\n\n[sensing]")
    assert again(mission_file, copied, text, only="routes") == ["routes"]
    found = json.loads((copied / "4-routes/selection.json").read_text())
    assert 0 < len(found["tasks"]) < instance.n_tasks
    assert check_selection(copied / "4-routes/selection.json", instance)[1] == []
    routes = read_routes(copied / "4-routes/routes.sol", instance, all_tasks=False)
    assert sorted(task for route in routes for task in route) == found["tasks"]
    assert makespan(instance, routes) <= 0.7 * all_of_them * (1 + 1e-9)
    assert again(mission_file, copied, text, only="flight") == ["flight"]
    assert again(mission_file, copied, text, only="report") == ["report"]
    assert "Endurance does not suffice for all tasks" in (copied / "8-report/report.html").read_text()
    enough = SMALL.replace("[sensing]", f"[flight]\nendurance = {1.1 * all_of_them}\n\n[sensing]")
    assert again(mission_file, copied, enough, only="routes") == ["routes"]
    assert not (copied / "4-routes/selection.json").exists()


def test_an_endurance_in_which_nothing_can_be_flown(mission_file: Path, copied: Path) -> None:
    text = SMALL.replace("[sensing]", "[flight]\nendurance = 1.0\n\n[sensing]")
    with pytest.raises(InputError, match=r"flight\.endurance: no task can be flown within the endurance"):
        again(mission_file, copied, text, only="routes")
