"""Mission page: the verdict is honest, pictures keep the region's shape, figures are drawn from frames alone."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread
from shapely.geometry import Polygon

from instances.environment.region import Region
from instances.environment.terrain import Terrain
from instances.errors import InputError
from reports.figures.heights import draw_heights
from reports.figures.map import draw_judged, draw_stages
from reports.figures.mission import draw_comparison, draw_progress
from reports.pages.exported import exported
from reports.pages.mission import _picture
from reports.products import Maps


def test_a_picture_has_a_pixel_a_cell_north_up_and_nothing_outside() -> None:
    values = np.array([[0.0, 1.0], [np.nan, 0.5]])  # the first row is the southern one
    picture = _picture(values, 0.0, 1.0, "viridis")
    pixels = imread(io.BytesIO(base64.b64decode(picture.split(",")[1])))
    assert pixels.shape == (2, 2, 4)
    assert pixels[0, 0, 3] == 0.0
    assert (pixels[[0, 1, 1], [1, 0, 1], 3] == 1.0).all()
    assert pixels[1, 1, 0] > pixels[1, 0, 0]  # yellow is redder than violet


@pytest.fixture
def maps() -> Maps:
    rng = np.random.default_rng(0)
    x, y = np.arange(50.0, 1000.0, 100.0), np.arange(50.0, 800.0, 100.0)
    shape = (len(y), len(x))
    mean, sd = rng.normal(size=(4, *shape)), rng.uniform(1, 2, (4, *shape))
    mean[:, 0, 0] = sd[:, 0, 0] = np.nan
    return Maps(np.array([10.0, 20.0, 30.0, 40.0]), x, y, mean, sd, rng.normal(size=shape))


def test_cells_reach_to_the_border(maps: Maps) -> None:
    assert maps.extent == (0.0, 1.0, 0.0, 0.8)


def test_figures_of_a_region_that_is_no_square(maps: Maps) -> None:
    region = Region(Polygon([(0, 0), (1000, 0), (1000, 800), (0, 800)], [[(400, 300), (600, 300), (500, 500)]]))
    flown = pd.DataFrame({"uav": 0, "time": [0.0, 20.0, 40.0], "x": [0.0, 900.0, 0.0], "y": [0.0, 700.0, 0.0]})
    samples = pd.DataFrame({"time": [10.0, 40.0], "uav": 0, "x": [10.0, 20.0], "y": [5.0, 6.0], "value": [1.0, 2.0]})
    stages = draw_stages(maps, region, np.array([[0.0, 0.0]]), flown, samples, "dBm")
    titles = [axes.get_title() for axes in stages.figure.axes]
    assert "(a) initial stage\n10 s, 1 samples" in titles
    assert "(b) final stage\n40 s, 2 samples" in titles
    assert len(draw_judged(maps, region, "dBm").figure.axes) == 8


def test_curves_of_a_single_tick() -> None:
    ticks = pd.DataFrame(
        {"time": [10.0], "rmse": [1.0], "mean_sd": [1.0], "max_sd": [2.0], "nlpd": [1.0], "coverage": [1.0],
         "information": [3.0], "flown": [1e3], "name": ["mission"]}
    )  # fmt: skip
    assert len(draw_progress(ticks, "dBm").figure.axes) == 4
    assert len(draw_comparison(ticks, "dBm").figure.axes) == 2


@pytest.mark.parametrize("known", [True, False])
def test_profiles_say_the_least_height_above_the_ground(known: bool) -> None:
    s = np.linspace(0.0, 4000.0, 2001)
    flown = pd.concat([pd.DataFrame({"uav": k, "x": s, "y": 0.0, "z": 300.0}) for k in (0, 2)])
    ridge = np.zeros((2, 5))
    ridge[:, 3] = 210.0
    drawn = draw_heights(flown, Terrain((0.0, -500.0), (1000.0, 1000.0), ridge) if known else None)
    assert [axes.get_title(loc="left") for axes in drawn.figure.axes] == [
        f"UAV {k}, at least {90 if known else 300} m above the ground" for k in (0, 2)
    ]
    assert ("flat at 0 m" in drawn.caption) == (not known)


def test_files_of_a_mission_are_linked_and_their_names_escaped(tmp_path: Path) -> None:
    folders = {stage: tmp_path / f"{stage}" for stage in ("environment", "place", "flight", "map")}
    for folder in folders.values():
        folder.mkdir()
    assert "Without an origin" in str(exported(folders)[0])
    (folders["flight"] / 'uav-"><b>.plan').write_text("{}")
    (folders["map"] / "field.tif").write_text("")
    (folders["flight"] / "exports.json").write_text('{"heights": {"UAV 0": "home <is> at 0 m"}}')
    links, heights = exported(folders)
    assert '<a href="map/field.tif">field.tif</a>' in links
    assert '"><b>' not in links
    assert heights == "UAV 0: home <is> at 0 m"
    (folders["flight"] / "exports.json").write_text('{"heights": 1}')
    with pytest.raises(InputError, match=r"exports\.json: does not describe exports"):
        exported(folders)
