"""What the stages of a mission leave: products of every stage, files for other software, the page."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import rasterio
import shapely
from geojson_pydantic import FeatureCollection
from rasterio.warp import transform_bounds

from instances.files import read_instance, read_routes
from instances.formats.netcdf import read_grids
from instances.geodesy import TangentPlane
from instances.routes import check_routes, makespan
from tests.workbench.mission.small import SMALL, again
from workbench.mission.check import _routes, check_products
from workbench.mission.file import read_mission
from workbench.mission.pipeline import run_mission
from workbench.mission.place import write_tasks
from workbench.mission.stamp import products_of, read_stamp


def test_check_reads_a_missions_folder_as_one(cli, copied: Path) -> None:
    code, out, _ = cli("check", copied)
    instance = read_instance(copied / "3-costs/instance.json")
    longest = makespan(instance, read_routes(copied / "4-routes/routes.sol", instance))
    assert (code, f"routes of 8 tasks, longest tour {longest!r} s: all right" in out) == (0, True)
    (copied / "6-map/ticks.csv").unlink()
    (copied / "4-routes/bound.json").write_text("{}")
    stamp = json.loads((copied / "5-flight/stamp.json").read_text())
    stamp["inputs"]["costs"] = "0" * 16
    (copied / "5-flight/stamp.json").write_text(json.dumps(stamp))
    (copied / "7-compare/stamp.json").unlink()
    code, out, _ = cli("check", copied)
    assert code == 1
    for words in (
        "ticks.csv: is missing since stage 'map' wrote it",
        "bound.json: was changed since stage 'routes' wrote it",
        "5-flight: was made from other products of stage 'costs' than those there",
        "7-compare/stamp.json: is missing or cannot be read",
        "4 problem(s) found",
    ):
        assert words in out


def test_routes_that_cost_something_else_are_refuted(copied: Path) -> None:
    """Even where all digests fit."""
    folder = copied / "4-routes"
    said = json.loads((folder / "bound.json").read_text())
    for wrong, words in (
        ({"objective": 1.0}, "claimed a longest tour of 1.0 s"),
        ({"bound": 1e9}, "no tours are below"),
    ):
        (folder / "bound.json").write_text(json.dumps(said | wrong))
        stamp = read_stamp(folder)
        assert stamp is not None
        replace(stamp, products=products_of(folder)).write(folder)
        _, problems = check_products(copied)
        assert any("made from other products of stage 'routes'" in problem for problem in problems)
        assert words in _routes(copied / "3-costs", folder)[1][0]


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


@pytest.mark.parametrize("drift", ["", pytest.param("tau = 100.0", marks=pytest.mark.slow)])
def test_polished_tours_promise_more_and_are_no_longer_than_the_longest(
    copied: Path, mission_file: Path, drift: str
) -> None:
    text = SMALL.replace("[place]", "[place]\npolish = true").replace("[map]", f"[map]\n{drift}")
    assert again(mission_file, copied, text, only="flight") == ["flight"]
    said = json.loads((copied / "5-flight/polish.json").read_text())
    assert said["bound"] <= said["rms_sd_after"] < said["rms_sd_before"]
    assert max(said["costs_after"]) <= max(said["costs_before"]) == max(said["budgets"])
    checks = pd.read_csv(copied / "5-flight/flight-check.csv")
    assert (checks["in_no_fly"] == 0).all()
    assert (checks["margin"] > -0.02).all()
    assert (checks["least_radius"] > 49.9).all()
    assert (checks["task_distance"] < 20).all()  # waypoints within 0.2 radii of a chord are flown by, not over
    promised, worth = said["rms_sd_after"], json.loads((copied / "5-flight/laps.json").read_text()) if drift else None
    assert worth is None or promised < worth["sd"]  # what the map's model says of the tours before
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


def test_without_the_extra_geo_a_mission_says_that_it_writes_no_geotiff(
    mission_file: Path, copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("workbench.mission.map.find_spec", lambda _: None)
    told: list[str] = []
    run_mission(read_mission(mission_file), copied, force_from="map", only="map", tell=told.append)
    assert "map: no GeoTIFFs: they need the extra 'geo'" in told
    assert {"maps.nc", "map.csv"} <= {path.name for path in (copied / "6-map").iterdir()}
    assert not list((copied / "6-map").glob("*.tif"))
