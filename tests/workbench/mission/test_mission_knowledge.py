"""Missions told how much places count and how little of them is known: placing, belief, products, refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from shapely.geometry import box, mapping

from formulations.kernel import SquaredExponential
from formulations.task_location.variance_reduction import VarianceReduction
from instances.errors import InputError
from instances.scenario_folder import kept_value_map
from reports.figures.value_maps import draw_value_maps
from workbench.mission import environment, place
from workbench.mission.belief import belief_of
from workbench.mission.file import mission_of
from workbench.mission.place import criterion_of
from workbench.mission.settings import Mission

TABLE: dict[str, Any] = {
    "airspeed": 100.0,
    "size": [20_000, 20_000],
    "depots": [[500, 500], [3500, 500]],
    "tasks": 6,
    "radio": {"position": [2000, 2000]},
    "field": {"cells": 20, "shadowing_sd": 0.0},
}
PLACE: dict[str, Any] = {"criterion": "j", "weights": "w.geojson", "method": "l-bfgs-b", "tests": [8, 8]}


def mission(folder: Path, value: float = 40, **tables: Any) -> Mission:
    west = {"type": "Feature", "properties": {"value": value}, "geometry": mapping(box(0, 0, 8000, 20_000))}
    (folder / "w.geojson").write_text(json.dumps(west))
    return mission_of(TABLE | tables, folder, "m")


def test_weights_and_prior_sd_are_placed_by_kept_and_drawn(tmp_path):
    told = mission(tmp_path, place=PLACE | {"prior_sd": "w.geojson"})
    folders = {name: tmp_path / name for name in ("environment", "place")}
    for name, stage in (("environment", environment), ("place", place)):
        folders[name].mkdir()
        words = stage.make(told, folders, folders[name], lambda _: None)
    assert "weighted rms sd of" in words
    assert isinstance(criterion_of(told, told.scenario.region), VarianceReduction)
    said = json.loads((folders["place"] / "placement.json").read_text())
    assert said["maximised"] == "j"
    assert 0 < said["average_variance_bound"] <= said["average_variance"] < 1600
    assert sum(x < 9000 for x, _ in said["points"]) >= 4
    maps = {name: kept_value_map(name, folders["place"]) for name in ("weights", "prior_sd")}
    assert maps["weights"]([[1000, 1000], [15_000, 1000]]) == pytest.approx([40, 1])
    assert maps["prior_sd"]([[1000, 1000], [15_000, 1000]]) == pytest.approx([40, 30])
    drawn = draw_value_maps(maps, told.scenario.region, criterion_of(told, told.scenario.region).tests, "dBm")
    assert drawn is not None
    assert len(drawn.figure.axes) == 4  # two maps, two bars


def test_the_map_believes_what_placing_does_unless_told(tmp_path):
    told = mission(tmp_path, place={"prior_sd": "w.geojson"}, map={"length_scale": 5000.0})
    folder = tmp_path / "environment"
    folder.mkdir()
    environment.make(told, {}, folder, lambda _: None)
    believed, inside = belief_of(told, folder), [[1000.0, 1000.0]]
    assert believed.model.kernel.variance(inside) == pytest.approx([1600])
    assert believed.planning.variance(inside) == pytest.approx([1600])
    assert believed.model.kernel.length_scales == (5000.0, 5000.0)
    (tmp_path / "own.csv").write_text("x,y,value\n100,100,7\n")
    own = mission(tmp_path, place={"prior_sd": "w.geojson"}, map={"prior_sd": "own.csv"})
    assert belief_of(own, folder).model.kernel.variance(inside) == pytest.approx([49])
    plain = mission(tmp_path, place={"weights": "w.geojson"})
    assert belief_of(plain, folder).model.kernel == SquaredExponential()


def test_a_changed_map_is_noticed(tmp_path):
    before = place.settings(mission(tmp_path, place=PLACE))
    assert place.settings(mission(tmp_path, place=PLACE)) == before
    assert place.settings(mission(tmp_path, 41, place=PLACE)) != before


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"place": {"weights": "none.csv"}}, "place.weights: .*none.csv: cannot be read"),
        ({"place": {"prior_sd": "none.tif"}}, "place.prior_sd: .*none.tif"),
        ({"map": {"prior_sd": "none.tif"}}, "map.prior_sd: .*none.tif"),
        ({"place": {"criterion": "ig", "weights": "w.geojson"}}, "place.weights: criterion ig"),
    ],
)
def test_maps_that_cannot_be_used_are_refused_before_anything_is_made(tmp_path, tables, words):
    with pytest.raises(InputError, match=words):
        mission(tmp_path, **tables)


def test_a_negative_value_names_key_file_and_value(tmp_path):
    with pytest.raises(InputError, match=r"place.weights: .*w.geojson: polygon 0: its property 'value' .* got -3"):
        mission(tmp_path, -3, place=PLACE)


def test_a_prior_sd_of_0_at_all_test_points_is_refused_in_a_sentence(tmp_path):
    (tmp_path / "known.csv").write_text(
        "x,y,value\n100,100,0\n19900,100,0\n100,19900,0\n19000,19000,0\n20000,20000,5\n"
    )
    own = {"criterion": "j", "prior_sd": "known.csv", "tests": [2, 2]}
    told = mission(tmp_path, place=own)
    with pytest.raises(InputError, match="prior_sd: 0 at every test point that counts"):
        place.place_tasks(told, told.scenario.region, 3, "greedy", {})
