"""Figures: what they show is computed right, each has words, and none depends on the network or on chance."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pandas as pd
import pytest

from formulations.moving_cost.families import generate
from instances import InputError, Instance
from instances.paths import Paths
from reports import load
from reports.figures import study_figures
from reports.figures.ablation import ablated_solvers, worth
from reports.figures.profiles import ratios
from reports.figures.routes import draw_routes, surroundings
from reports.figures.steps import cumulative
from reports.figures.style import COLOURS, DASHES, styles
from reports.figures.svg import inline_svg, save_figure
from reports.figures.turns import loss_against_spacing
from reports.metrics import with_gaps


@pytest.fixture
def runs(make_store):
    return with_gaps(load(make_store().study(count=4, sizes=((8, 2), (14, 3)), seeds=2)))


def test_every_figure_is_there_with_title_caption_and_units(runs):
    drawn = study_figures(runs)
    assert [d.key for d in drawn] == [
        "convergence", "convergence-panels", "profile-quality", "profile-time", "profile-proof",
        "time-to-target", "ecdf", "gap-n", "tradeoff", "ablation-milp",
    ]  # fmt: skip
    for d in drawn:
        assert d.caption.endswith(".")
        assert len(d.caption) > 100
        for panel in d.chart.panels:
            assert re.search(r"\[|τ|tasks n|times the", panel.x.words), (d.key, panel.x)


def test_loss_against_spacing_is_the_mean_gap_of_each_method(runs):
    assert loss_against_spacing(runs) is None
    digests = sorted(runs["digest"].unique())
    spaced = runs.assign(spacing=runs["digest"].map({digest: 2.0 + 4.0 * (i % 2) for i, digest in enumerate(digests)}))
    figure = loss_against_spacing(spaced)
    for series in figure.chart.panels[0].series:
        mine = spaced[spaced["method"] == series.name].groupby(["spacing", "digest"])["gap_best"].median()
        expected = 100 * mine.groupby(level="spacing").mean()
        np.testing.assert_allclose(series.y, expected)
        assert np.asarray(series.x).tolist() == [2.0, 6.0]
        assert (np.asarray(series.low) <= expected + 1e-12).all()
        assert (np.asarray(series.high) >= expected - 1e-12).all()
    assert inline_svg(figure).startswith("<svg")


def test_inline_svg_is_well_formed_self_contained_and_repeatable(runs):
    first, again = (inline_svg(study_figures(runs)[0]) for _ in range(2))
    assert first == again
    root = ET.fromstring(first)
    assert root.attrib["role"] == "img"
    assert root.attrib["aria-label"].startswith("Convergence.")
    ids = [e.attrib["id"] for e in root.iter() if "id" in e.attrib]
    assert len(ids) == len(set(ids))
    assert all(name.startswith("convergence-") for name in ids)
    assert "currentColor" in first
    links = re.findall(r'(?:href|src)="([^"]*)"', first)
    assert all(link.startswith(("#", "data:")) for link in links)


def test_profile_ratios_by_hand():
    times = pd.DataFrame({"a": [1.0, 4.0, np.inf, np.inf], "b": [2.0, 2.0, 3.0, np.inf]})
    np.testing.assert_array_equal(ratios(times).to_numpy(), [[1, 2], [2, 1], [np.inf, 1]])


def test_cumulative_counts_what_never_came():
    x, share = cumulative([3.0, 1.0, np.inf, np.inf])
    assert x.tolist() == [1, 3]
    assert share.tolist() == [0.25, 0.5]


def test_ablation_by_hand(runs):
    assert ablated_solvers(runs) == ["milp"]
    default, without = worth(runs, "milp")
    assert (default.method, default.ratio, default.gap) == ("milp", (1, 1, 1), (0, 0, 0))
    # small ones: 1.2/0.8 s against 1.2/0.7 s until the proof, shifted by 1 s; large ones never: no difference
    expected = np.sqrt((1 + 1.2 / 0.7) / (1 + 1.2 / 0.8))
    assert without.ratio[0] == pytest.approx(expected)
    assert without.gap[0] == pytest.approx(0.5 * 0.1)  # bounds of 80 % and 70 % on half of the instances


def test_methods_differ_without_colour():
    look = list(styles(map(str, range(12))).values())
    assert len({(s.dash, s.marker) for s in look}) == 12
    assert len(COLOURS) * len(DASHES) == len(set(styles(f"{i:02}" for i in range(28)).values()))


def instance(coordinates=True):
    xy = np.array([[0, 0], [10e3, 0], [10e3, 10e3], [0, 10e3], [5e3, 5e3], [5e3, 5e3]], dtype=float)
    cost = np.hypot(*(xy[:, None] - xy[None]).T).T / 20
    return Instance("square", cost, 4, 2, xy if coordinates else None)


@pytest.mark.parametrize("ending", ["svg", "png", "pdf"])
def test_routes_are_drawn_and_written(tmp_path, ending):
    target = tmp_path / f"routes.{ending}"
    save_figure(draw_routes(generate("corridor", 4, 2, 0, wind="rotation"), ((0, 1, 2), (3,))), target)
    start = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}[ending]
    assert target.read_bytes().startswith(start)
    assert list(tmp_path.iterdir()) == [target]


def test_a_bar_a_uav_with_its_cost():
    figure = draw_routes(instance(), ((0, 1, 2), ()))
    plan, bars = figure.axes
    widths = [patch.get_width() for patch in bars.patches]
    half = np.hypot(5e3, 5e3) / 20
    assert widths == pytest.approx([2 * half + 2 * 500, 0.0])
    assert "stays home" in [t.get_text() for t in bars.texts]
    assert plan.get_xlabel() == "x, east [km]"
    assert "[s]" in bars.get_xlabel()


def test_without_coordinates_only_bars_are_drawn():
    assert len(draw_routes(instance(coordinates=False), ((0, 1), (2, 3))).axes) == 1


def test_a_picture_of_unknown_ending_is_refused(tmp_path):
    with pytest.raises(InputError, match="must end in"):
        save_figure(draw_routes(instance(), ((0, 1), (2, 3))), tmp_path / "routes.txt")
    assert not list(tmp_path.iterdir())


def test_legs_are_drawn_along_given_paths_else_straight():
    around = np.array([[0.0, 0.0], [1e3, -4e3], [10e3, 0.0]])
    xy = instance().coordinates
    paths = Paths.of(
        6, [around if (i, j) == (0, 1) else xy[[i, j]] if i != j else xy[:0] for i in range(6) for j in range(6)]
    )
    bent, straight = (
        draw_routes(instance(), ((0, 1), (2, 3)), given).axes[0].lines[0].get_xydata() * 1e3 for given in (paths, None)
    )
    assert [*around[1]] in bent.tolist()
    np.testing.assert_allclose(straight, xy[[4, 0, 0, 1, 1, 4]])


def test_regions_and_winds_are_those_an_instance_states():
    walls = generate("corridor", 3, 1, 0, wind="rotation")
    region, wind = surroundings(walls)
    assert region.area == pytest.approx(20_000**2 - 3 * 400 * 16_000)
    assert wind.rate > 0
    open_country = generate("uniform", 5, 2, 0, wind="uniform")
    region, wind = surroundings(open_country)
    assert region is None
    assert wind is not None
    assert surroundings(instance()) == (None, None)
