"""Mission page: the verdict is honest, pictures keep the region's shape, figures are drawn from frames alone."""

from __future__ import annotations

import base64
import io
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.image import imread
from matplotlib.quiver import QuiverKey
from shapely.geometry import Polygon

from instances.environment.region import Region
from instances.environment.terrain import Terrain
from instances.environment.wind import Uniform
from instances.errors import InputError
from instances.scenario import Scenario
from reports.figures.flight import draw_flight, draw_plans
from reports.figures.heights import draw_heights
from reports.figures.map import draw_judged, draw_stages
from reports.figures.mission import draw_comparison, draw_progress
from reports.figures.wind import draw_wind, round_below
from reports.pages.calm import verdict as worth
from reports.pages.exported import exported
from reports.pages.film import _picture, film, player
from reports.products import Maps, Products


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


SQUARE = Region(Polygon([(0, 0), (1000, 0), (1000, 800), (0, 800)]))
FLOWN = pd.DataFrame({"uav": [0, 0, 2, 2], "time": [0.0, 40.0] * 2, "x": [0.0, 900.0] * 2, "y": [0.0, 700.0] * 2})


def test_the_growing_map_has_axes_a_scale_and_a_legend(maps: Maps) -> None:
    scenario = Scenario("s", SQUARE, np.array([[100.0, 100.0]]), 10.0, n_tasks=1)
    products = Products({})
    vars(products).update(maps=maps, scenario=scenario, unit="dBm")  # as if they had been read
    ticks = pd.DataFrame({"time": maps.time, "rmse": 1.0, "samples": 1})
    samples = pd.DataFrame({"time": [10.0], "x": [10.0], "y": [5.0]})
    data = film(products, FLOWN, samples, ticks)
    root = ET.fromstring(f"<page>{re.sub(r'<input[^>]*>', '', player(products, data))}</page>".replace('alt="">', "/>"))
    pictures = [svg for svg in root.iter("svg") if svg.get("id")]
    assert [svg.get("id") for svg in pictures] == ["film-mean", "film-sd"]
    for svg in pictures:
        texts = [text.text for text in svg.iter("text")]
        assert {"x, east [km]", "y, north [km]", "0", "0.4", "0.8"} <= set(texts)
        x, y, width, height = map(float, svg.get("viewBox", "").split())
        assert x < 0.0 < 1.0 < x + width  # room for the axes
        assert y < -0.8 < 0.0 < y + height
    said = "".join(root.itertext())
    assert "UAV 0UAV 2depotsample" in said
    ends = [span.text for span in root.iter("span") if not len(span)]
    assert {"Estimated field [dBm]", "0"} <= set(ends)


def wind_key(axes: Axes) -> QuiverKey:
    (key,) = [artist for artist in axes.artists if isinstance(artist, QuiverKey)]
    return key


def test_arrows_of_the_wind_have_heads_and_a_key_with_its_speed() -> None:
    axes = draw_wind(Uniform((-7.0, 0.0)), SQUARE).figure.axes[0]
    key = wind_key(axes)
    assert key.text.get_text() == "5 m/s"
    assert key.U == 5.0
    arrows = key.Q
    assert arrows.headwidth > 3
    longest = 7.0 / arrows.scale  # in kilometres
    assert 0.5 * 1.0 / 15 < longest < 1.0 / 15
    assert not draw_wind(Uniform((0.0, 0.0)), SQUARE).figure.axes[0].artists


@pytest.mark.parametrize(("speed", "key"), [(10.0, 10.0), (9.99, 5.0), (0.37, 0.2), (1.0, 1.0), (123.0, 100.0)])
def test_the_key_is_a_round_speed_that_the_wind_reaches(speed: float, key: float) -> None:
    assert round_below(speed) == pytest.approx(key)


def test_tours_have_a_legend_of_uavs(maps: Maps) -> None:
    scenario = Scenario("s", SQUARE, np.array([[100.0, 100.0]]), 10.0, wind=Uniform((1.0, 0.0)), n_tasks=1)
    samples = pd.DataFrame({"time": [10.0], "x": [10.0], "y": [5.0]})
    table = pd.DataFrame({"name": ["mission"], "length": [1e3], "rmse": [1.0], "verdict": [""]})
    drawn = [
        draw_flight(scenario, np.array([[500.0, 500.0]]), FLOWN, FLOWN),
        draw_stages(maps, SQUARE, scenario.depots, FLOWN, samples, "dBm"),
        draw_plans(SQUARE, scenario.depots, FLOWN.assign(name="mission"), table, "dBm"),
    ]
    for each in drawn:
        (legend,) = each.figure.legends
        texts = [text.get_text() for text in legend.get_texts()]
        assert texts[:2] == ["UAV 0", "UAV 2"]
        assert texts[-1] == "depot"
    assert wind_key(drawn[0].figure.axes[0]).text.get_text() == "1 m/s"


@pytest.mark.parametrize(
    ("better", "words"),
    [
        (250.0, r"costs 260\.0 s\. Planning in the wind saves 23\.1% of it, 20\.0% where .* better way .*, 33\.3% the"),
        (200.2, r"This wind is hardly worth planning for: planning in it saves 0\.1% where"),
    ],
)
def test_what_planning_in_the_wind_is_worth(better: float, words: str) -> None:
    longest = pd.Series({"wind": 200.0, "calm": 260.0, "better": better, "worse": 300.0, "promised": 240.0})
    assert pd.Series([worth(longest)]).str.contains(words)[0]


def test_tours_that_cost_nothing_save_nothing() -> None:
    assert "saves 0.0% where" in worth(pd.Series(dict.fromkeys(["wind", "calm", "better", "worse", "promised"], 0.0)))
