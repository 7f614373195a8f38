"""Figures and page of moving costs: everything is drawn, and the page is one file with its words."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from instances.families import make_scenario
from instances.paths import Paths
from instances.scenario import Scenario
from reports.figures.paths import draw_claim, draw_methods, draw_paths
from reports.figures.svg import save_figure
from reports.figures.wind import draw_wind
from reports.moving_costs import scaling_table
from reports.pages.moving_cost import Case, write_moving_cost_page

METHODS = pd.DataFrame(
    [("refined", "default", 0.5, 0.0, 0.0, 1e-6), ("fmt-star", "2 000", 0.1, 6e-2, 0.12, 1.5)],
    columns=["method", "options", "cpu", "mean", "p95", "largest"],
)
CLAIM = pd.DataFrame({"starts": [5, 10], "one query a pair": [1.0, 4.0], "one tree a start": [0.2, 0.4]})


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return make_scenario("wind-vortices", 4, 2, 1)


@pytest.fixture(scope="module")
def paths(scenario: Scenario) -> Paths:
    p = scenario.points
    return Paths.of(6, [np.empty((0, 2)) if i == j else p[[i, j]] for i in range(6) for j in range(6)])


def test_the_papers_figure_draws_every_path_from_and_to_one_node(
    scenario: Scenario, paths: Paths, tmp_path: Path
) -> None:
    figure = draw_paths(scenario, paths).figure
    outward, back = figure.axes
    for axes, ends in ((outward, (0, -1)), (back, (-1, 0))):
        lines = [line.get_xydata() * 1e3 for line in axes.lines if len(line.get_xydata()) == 2]
        assert len(lines) == 5
        for line in lines:
            np.testing.assert_allclose(line[ends[0]], scenario.points[-scenario.n_depots])
    save_figure(figure, tmp_path / "p.svg")
    assert (tmp_path / "p.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_paths_between_the_first_nodes_alone_are_drawn(scenario: Scenario) -> None:
    p = scenario.points[:3]
    paths = Paths.of(3, [np.empty((0, 2)) if i == j else p[[i, j]] for i in range(3) for j in range(3)])
    outward, _ = draw_paths(scenario, paths).figure.axes
    assert sum(len(line.get_xydata()) == 2 for line in outward.lines) == 2


def test_environment_and_comparison_figures_name_their_units(scenario: Scenario) -> None:
    words = {
        drawn.key: " ".join(a.get_xlabel() + a.get_ylabel() for a in drawn.figure.axes)
        for drawn in (
            draw_wind(scenario.wind, scenario.free),
            draw_methods(METHODS),
            draw_claim(CLAIM),
        )
    }
    expected = {"wind": "speed [m/s]", "methods": "all pairs [s]", "claim": "of starts"}
    for key, label in expected.items():
        assert label in words[key]


def test_the_page_is_one_file(scenario: Scenario, paths: Paths, tmp_path: Path) -> None:
    made = {"machine": {"processor": "a & b", "memory": 8e9}, "versions": {"python": "3.11"}}
    (tmp_path / "environments").mkdir()
    (tmp_path / "environments" / "e1.json").write_text(json.dumps(made))
    rows = {"method": "refined", "time_limit": 60.0, "threads": 1, "created": "", "environment": "e1"}
    runs = pd.DataFrame([rows | {"code": "0" * 12, "revision": "abc"}])
    case = Case(scenario, paths, METHODS, CLAIM, "wind: <much>")
    stored = [tmp_path / "survey-123" / "refined-default-s0-t60.json"]
    write_moving_cost_page([case], runs, stored, tmp_path / "page.html", "Moving costs: survey")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.count("<figure ") == 4
    for words in ("wind: &lt;much&gt;", "30 ordered pairs", "a &amp; b", "8.00 GB", "000000000000 (abc)"):
        assert words in page
    assert "1 of 1 runs were made by other code than today" in page


def test_the_scaling_claim_compares_what_differs_in_sharing_alone() -> None:
    rows = [
        (starts, method, 1.0, seconds * starts)
        for starts in (2, 4)
        for method, seconds in (("fmt-star", 9.0), ("fmt-star (samples=3000)", 0.5), ("refined", 0.7),
                                ("fmt-star (samples=3000, share=false)", 1.0))
    ]  # fmt: skip
    frame = pd.DataFrame(rows, columns=["starts", "method", "mean_cost", "cpu_seconds"])
    table = scaling_table(frame)
    assert table.to_dict("records") == [
        {"starts": 4, "one query a pair": 12.0, "one tree a start": 4.0, "shared edges": 2.0, "refined": 2.8}
    ]
    assert scaling_table(frame[frame["method"] != "refined"]).empty
