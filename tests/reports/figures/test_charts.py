"""Charts: both renderers show the same values, axes say what they are, toggles reach every method, lines are seen."""

import json
import re
from dataclasses import replace
from importlib import resources
from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from bokeh.document import Document
from bokeh.models.renderers import GlyphRenderer
from matplotlib.figure import Figure
from matplotlib.scale import SymmetricalLogTransform

from instances import InputError
from reports import load
from reports.figures import study_figures
from reports.figures.chart import Axis, Chart, Panel, Rule, Series, marks
from reports.figures.files import write_figures
from reports.figures.flight import DEPOT
from reports.figures.heights import draw_heights
from reports.figures.interactive import embedded
from reports.figures.mission import draw_comparison, draw_progress
from reports.figures.paths import draw_claim, draw_methods
from reports.figures.placement import draw_placement_convergence
from reports.figures.static import LINEAR_BELOW, LINEAR_SHARE, draw, transformed
from reports.figures.style import COLOURS, FAINT, INK, PAPER, styles
from reports.figures.svg import Drawn, inline_svg
from reports.metrics import with_gaps

LOOKS = list(styles("abc").values())


@pytest.fixture(scope="module")
def drawn(store_maker, tmp_path_factory):
    store = store_maker(tmp_path_factory.mktemp("charts"))
    return study_figures(with_gaps(load(store.study(count=2, sizes=((8, 2), (14, 3)), seeds=2))))


@pytest.fixture(scope="module")
def told(drawn):
    """What goes into the page: key → embedded, as JSON holds it."""
    return {d.key: json.loads(json.dumps(embedded(d.chart), allow_nan=False)) for d in drawn}


def table(told):
    """The table that charts.js makes of a chart, from Bokeh's sources."""
    document = Document.from_json(told["document"])
    rows = []
    for series in told["series"]:
        columns = document.get_model_by_id(series["source"]).data
        fields = {head: list(columns[field]) for head, field in series["fields"].items()}
        rows += [series["same"] | dict(zip(fields, of, strict=True)) for of in zip(*fields.values(), strict=True)]
    return pd.DataFrame(rows, columns=told["columns"])


def test_the_page_holds_the_same_values_as_the_table(drawn, told):
    for d in drawn:
        frame = d.chart.frame()
        assert len(frame) > 1
        pd.testing.assert_frame_equal(table(told[d.key]), frame, check_dtype=False)


def test_paper_shows_the_same_values_as_the_table(drawn):
    for d in drawn:
        for panel, axes in zip(d.chart.panels, d.figure.axes, strict=False):
            lines = [np.asarray(line.get_xydata()) for line in axes.lines]
            dots = [np.asarray(dots.get_offsets()) for dots in axes.collections]
            for series in panel.series:
                values = series.values
                shown = np.column_stack([values["x"] * series.aside, values["y"]])
                among = dots if series.kind == "points" else lines
                assert any(np.array_equal(shown, of, equal_nan=True) for of in among), (d.key, series.name)


TICKS = pd.DataFrame(
    {"time": [10.0, 20.0], "rmse": [2.0, 1.0], "mean_sd": [1.0, 0.5], "max_sd": [2.0, 1.0], "nlpd": [3.0, 2.0],
     "coverage": [0.5, 0.96], "information": [3.0, 4.0], "flown": [1e3, 2e3], "name": ["mission", "mission"]}
)  # fmt: skip
FLOWN = pd.DataFrame({"uav": [0, 0], "x": [0.0, 3e3], "y": [0.0, 4e3], "z": [300.0, 310.0]})
METHODS = pd.DataFrame(
    [("refined", "default", 0.5, 0.0, 0.0, 1e-6), ("fmt-star", "2 000", 0.1, 6e-2, 0.12, 1.5)],
    columns=["method", "options", "cpu", "mean", "p95", "largest"],
)
CLAIM = pd.DataFrame({"starts": [5, 10], "one query a pair": [1.0, 4.0], "one tree a start": [0.2, 0.4]})
TRACE = {"nlp": [(0.1, 20.0), (1.0, 22.0)], "grid": [(0.01, 18.0)]}


@pytest.mark.parametrize(
    ("made", "last"),
    [
        (draw_progress(TICKS, "dBm"), {"series": "information gathered", "time [s]": 20.0, "y": 4.0}),
        (draw_comparison(TICKS, "dBm"), {"series": "mission", "flown by all UAVs [km]": 2.0, "y": 2.0}),
        (draw_heights(FLOWN, None), {"series": "nearest to the ground", "flown [km]": 0.0, "height [m]": 300.0}),
        (draw_methods(METHODS), {"series": "fmt-star", "options": "2 000", "CPU time, all pairs [s]": 0.1}),
        (draw_claim(CLAIM), {"series": "one tree a start", "number of starts n": 10.0, "CPU time [s]": 0.4}),
        (draw_placement_convergence(TRACE, 25.0, "t", styles(TRACE)),
         {"series": "nlp", "wall clock [s]": 1.4, "gap to the certificate [%]": 12.0}),
    ],
)  # fmt: skip
def test_other_pages_hold_the_same_values_as_the_table(made, last):
    frame = made.chart.frame()
    assert frame.iloc[-1][list(last)].to_dict() == pytest.approx(last)
    told = json.loads(json.dumps(embedded(made.chart), allow_nan=False))
    pd.testing.assert_frame_equal(table(told), frame, check_dtype=False)
    assert {entry["name"] for entry in told["legend"]} == set(frame["series"])


def test_every_axis_says_what_it_is(drawn):
    for d in drawn:
        for panel in d.chart.panels:
            for axis in (panel.x, panel.y):
                assert axis.names or re.search(r"\[.+\]|τ|number of tasks|times the default", axis.words), axis
        words = [axes.get_xlabel() for axes in d.figure.axes] + [axes.get_ylabel() for axes in d.figure.axes]
        assert {panel.x.words for panel in d.chart.panels} <= set(words)
        assert {panel.y.words for panel in d.chart.panels} <= {*words, d.figure.get_supylabel()}


def test_toggles_reach_every_method_in_every_panel(drawn, told):
    methods = {name for d in drawn for name in d.chart.looks}
    assert methods == {"greedy", "ga", "memetic", "milp", "milp (cuts=false)"}
    for d in drawn:
        plots = Document.from_json(told[d.key]["document"]).roots
        assert [plot.id for plot in plots] == told[d.key]["roots"]
        assert {entry["name"] for entry in told[d.key]["legend"]} == set(d.chart.looks)
        for panel, plot in zip(d.chart.panels, plots, strict=True):
            renderers = [model for model in plot.renderers if isinstance(model, GlyphRenderer)]
            assert {model.name for model in renderers} == {series.name for series in panel.series}


def test_the_same_chart_is_embedded_the_same(drawn):
    assert embedded(drawn[0].chart) == embedded(drawn[0].chart)


def test_names_of_places_do_not_become_ids():
    series = Series("p1001", [1.0], [2.0], LOOKS[0], "points", more={"id": np.array(["p1002"])})
    found = table(embedded(Chart([Panel(Axis("x", "m"), Axis("y", "m"), [series])])))
    assert found.to_dict("records") == [{"series": "p1001", "x [m]": 1.0, "y [m]": 2.0, "id": "p1002"}]


def test_first_routes_do_not_flatten_the_axis(drawn):
    """Half of the height is for gaps below a tenth of the greatest: the scale is logarithmic."""
    panel = next(d for d in drawn if d.key == "convergence").chart.panels[0]
    low, high = panel.span("y")
    below, top = transformed(panel.y, np.array([high / 10, high]))
    assert (below - transformed(panel.y, low)) > 0.5 * (top - transformed(panel.y, low))


def test_gaps_lie_where_matplotlib_puts_them():
    values = np.array([-30.0, -0.05, 0.0, 0.1, 0.2, 500.0])
    expected = SymmetricalLogTransform(10, LINEAR_BELOW, LINEAR_SHARE).transform(values)
    np.testing.assert_allclose(transformed(Axis("gap", "%", "gap"), values), expected)


def test_the_panel_above_a_hole_has_ticks_and_words():
    panels = [
        Panel(Axis("time", "s"), Axis("gap", "%"), [Series("a", [0, 1], [1, 0], LOOKS[0])], str(i)) for i in "1234"
    ]
    figure = draw(Chart(panels, 3, shared=True))
    lowest = [axes for axes in figure.axes if axes.get_visible() and axes.get_xlabel()]
    assert [axes.get_title(loc="left") for axes in lowest] == ["2", "3", "4"]
    assert all(axes.xaxis.get_tick_params()["labelbottom"] for axes in lowest)


def test_spans_hold_every_value_and_names_have_rows():
    across = Series("a", [2.0], [0], LOOKS[0], "points", [1.0], [8.0], "across")
    panel = Panel(Axis("time", "s", "log"), Axis("row", names=["one"]), [across], rules=[Rule("x", 16.0)])
    low, high = panel.span("x")
    assert 0.5 < low < 1 < 16 < high < 32
    assert panel.span("y") == (-0.6, 0.6)
    assert Chart([panel]).frame().to_dict("records") == [
        {"series": "a", "time [s]": 2.0, "row": "one", "low": 1.0, "high": 8.0}
    ]


def test_marks_of_lines_that_coincide_stand_apart():
    step = Series("a", [0.0, 4.0, 10.0], [0.0, 1.0, 1.0], LOOKS[0], "step")
    panel = Panel(Axis("time", "s", span=(0.0, 10.0)), Axis("share", "%"), [step])
    (x, y), (beside, _) = marks(panel, step, 0), marks(panel, step, 1)
    assert not set(x) & set(beside)
    assert y.tolist() == [float(place >= 4) for place in x]


def test_labels_do_not_overprint_each_other():
    cpu = np.array([1.0, 1.01, 1.02, 9.0])
    words = np.array(["samples=2000", "radius_factor=2.0", "default", "candidates=12, samples=10000"])
    points = Series("a", cpu, [0.1] * 4, LOOKS[0], "points", more={"options": words}, labels="options")
    figure = draw(Chart([Panel(Axis("CPU time", "s", "log"), Axis("excess", scale="log"), [points])]))
    figure.canvas.draw()
    (axes,) = figure.axes
    boxes = [text.get_window_extent() for text in axes.texts]
    assert [text.get_text() for text in axes.texts] == words.tolist()
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert all(axes.bbox.x0 <= box.x0 and box.x1 <= axes.bbox.x1 for box in boxes)


def test_files_for_papers(drawn, tmp_path):
    few = [d for d in drawn if d.key in ("gap-n", "ecdf")]
    write_figures([*few, replace(few[0], key="a map", chart=None)], tmp_path / "new" / "folder")
    written = sorted(path.name for path in (tmp_path / "new" / "folder").iterdir())
    chart = [f"{key}{ending}" for key in ("ecdf", "gap-n") for ending in (".csv", ".pdf", ".svg")]
    assert written == ["a-map.pdf", "a-map.svg", *chart]
    told = pd.read_csv(tmp_path / "new" / "folder" / "ecdf.csv")
    pd.testing.assert_frame_equal(told, few[0].chart.frame(), check_dtype=False)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be made"):
        write_figures(few, tmp_path / "file")


def test_a_page_and_its_file_show_one_drawing(drawn, tmp_path, monkeypatch):
    ecdf = replace(next(d for d in drawn if d.key == "ecdf"), key="ecdf.of all")
    inline = inline_svg(ecdf)
    monkeypatch.setattr(type(ecdf.figure), "savefig", None)  # whoever draws it again fails
    write_figures([ecdf], tmp_path, (".svg",))
    text = (tmp_path / "ecdf.of-all.svg").read_text()
    lines = [re.findall(r' d="([^"]*)"', svg) for svg in (text, inline)]
    assert lines[0] == lines[1]
    assert [svg.count(f"fill: {PAPER}") for svg in (text, inline)] == [1, 0]
    assert "var(--paper)" not in inline


def test_a_page_shows_through_a_figure_of_any_paper():
    assert "fill: #123456" not in inline_svg(Drawn("blue", "Blue", "Drawn elsewhere.", Figure(facecolor="#123456")))


def luminance(colour):
    """Relative luminance (WCAG 2.2) of #rrggbb."""
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return float(np.dot([0.2126, 0.7152, 0.0722], linear))


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.fixture(scope="module")
def inks():
    """The page's colours: name → light, dark."""
    css = resources.files("reports.pages").joinpath("templates", "page.css").read_text(encoding="utf-8")
    return {name: of for name, *of in re.findall(r"--([\w-]+): light-dark\((#\w+), (#\w+)\)", css)}


def test_lines_and_text_are_seen_on_both_papers(inks):
    assert inks["paper"][0] == PAPER
    assert inks["ink"][0] == INK
    assert inks["faint"][0] == FAINT
    for paper, ink, soft, faint in zip(*(inks[name] for name in ("paper", "ink", "soft", "faint")), strict=True):
        assert min(contrast(paper, line) for line in (*COLOURS, DEPOT, faint)) >= 3.0
        assert min(contrast(paper, text) for text in (ink, soft)) >= 4.5
