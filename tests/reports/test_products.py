"""A mission's products: whole ones are read, each damaged one is named in a sentence."""

import json

import numpy as np
import pandas as pd
import pytest

from instances import InputError
from instances.formats.netcdf import Variable, write_grids
from reports.product_tables import NAMED, NUMBERS
from reports.products import Products

STAGES = ("environment", "place", "costs", "routes", "flight", "map", "compare")
X, TIME = np.array([50.0, 150.0, 250.0]), np.array([1.0, 2.0])


def maps(mean, time=TIME, x=X):
    grid = np.zeros((3, 3))
    variables = {"mean": mean, "sd": np.ones((2, 3, 3)), "truth": grid}
    return time, x, {k: Variable(("time", "y", "x")[-v.ndim :], v) for k, v in variables.items()}


def write_maps(path, mean=None, time=TIME, x=X):
    time, x, variables = maps(np.zeros((2, 3, 3)) if mean is None else mean, time, x)
    write_grids(path, {"time": time, "y": X, "x": x}, variables)


@pytest.fixture
def products(tmp_path):
    """Every table with two rows, one map at each tick."""
    for stage in STAGES:
        (tmp_path / stage).mkdir()
    for file, columns in NUMBERS.items():
        frame = pd.DataFrame({name: [0, 1] for name in columns} | ({"time": [1, 2]} if "time" in columns else {}))
        if file in NAMED:
            frame["name"] = ["mission", "random"]
        frame.to_csv(tmp_path / stage_of(file) / file, index=False)
    placement = {"method": "m", "points": [[0, 0]], "mutual_information": 1.0, "status": "s"}
    (tmp_path / "place" / "placement.json").write_text(json.dumps(placement))
    write_maps(tmp_path / "map" / "maps.nc")
    return Products({stage: tmp_path / stage for stage in STAGES})


def stage_of(file):
    stages = {"tasks.csv": "place", "tours.csv": "routes", "samples.csv": "map", "ticks.csv": "map"}
    flown = ("reference.csv", "flown.csv", "flight-check.csv")
    return stages.get(file, "flight" if file in flown else "compare")


@pytest.mark.parametrize("file", list(NUMBERS))
def test_a_table_holds_its_columns_as_finite_numbers(products, file):
    stage, column = stage_of(file), NUMBERS[file][0]
    path = products.folders[stage] / file
    assert len(products.table(stage, file)) == 2
    good = pd.read_csv(path)
    for bad in ("x", "nan", "inf", "1e308", "-1" if column in ("uav", "draw") else "", "9" * 400):
        good.astype({column: object}).assign(**{column: [bad, "1"]}).to_csv(path, index=False)
        with pytest.raises(InputError, match=file):
            products.table(stage, file)
    for text in ("", "\0", good.drop(columns=column).to_csv(), good[:0].to_csv()):
        path.write_text(text)
        with pytest.raises(InputError, match=file):
            products.table(stage, file)


@pytest.mark.parametrize(
    "given",
    [
        {"mean": np.full((2, 3, 3), np.nan)}, {"mean": np.full((2, 3, 3), np.inf)}, {"mean": np.zeros((3, 3))},
        {"time": np.array([2.0, 1.0])}, {"x": np.array([0.0, np.nan, 1.0])}, {"x": X * 1e300},
    ],
)  # fmt: skip
def test_maps_fit_their_axes(products, given):
    path = products.folders["map"] / "maps.nc"
    write_maps(path, **given)
    with pytest.raises(InputError, match=r"maps\.nc"):
        _ = products.maps


def test_every_kept_map_has_its_tick(products):
    assert len(products.ticks) == 2
    write_maps(products.folders["map"] / "maps.nc", time=np.array([1.0, 3.0]))
    with pytest.raises(InputError, match=r"ticks\.csv"):
        _ = Products(products.folders).ticks


def test_plans_are_those_compared(products):
    path = products.folders["compare"] / "tracks.csv"
    pd.read_csv(path).assign(name=["mission", "other"]).to_csv(path, index=False)
    assert list(products.of_plans("tracks.csv")["name"]) == ["mission"]
    path = products.folders["compare"] / "compare.csv"
    pd.read_csv(path).assign(name=["random", "random"]).to_csv(path, index=False)
    with pytest.raises(InputError, match=r"compare\.csv"):
        _ = Products(products.folders).compared


@pytest.mark.parametrize(
    "said", [[], {}, {"method": []}, {"method": "m", "points": 3, "mutual_information": 1.0},
             {"method": "m", "points": [], "mutual_information": "x"},
             {"method": "m", "points": [], "mutual_information": 1.0, "certificate": "x", "ratio": None}],
)  # fmt: skip
def test_a_placement_is_what_it_says(products, said):
    assert products.placement["method"] == "m"
    path = products.folders["place"] / "placement.json"
    path.write_text(json.dumps(said))
    with pytest.raises(InputError, match=r"placement\.json"):
        _ = Products(products.folders).placement


@pytest.mark.parametrize("text", ["{", "[]", '{"schema": 1, "solver": "s"}'])
def test_damaged_routes_are_named(products, text):
    (products.folders["routes"] / "run.json").write_text(text)
    with pytest.raises(InputError, match=r"run\.json"):
        _ = products.routes


def test_every_plan_has_the_same_draws(products):
    path = products.folders["compare"] / "compare-draws.csv"
    whole = pd.read_csv(path).assign(draw=0, refused=["", "UAV 0 would …"])
    whole.to_csv(path, index=False)
    assert list(products.draws["refused"]) == ["", "UAV 0 would …"]
    for damaged in (whole[:1], whole.assign(draw=[0, 1]), whole.drop(columns="refused"), whole[::-1]):
        damaged.to_csv(path, index=False)
        with pytest.raises(InputError, match=r"compare-draws\.csv"):
            _ = Products(products.folders).draws


def test_what_the_draws_are_is_said(products):
    path = products.folders["compare"] / "compare.json"
    path.write_text('{"over": "3 noise seeds"}')
    assert products.over == "3 noise seeds"
    path.write_text("[]")
    with pytest.raises(InputError, match=r"compare\.json"):
        _ = Products(products.folders).over
