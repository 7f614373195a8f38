"""One self-contained page about moving costs: the wind, the paths, the methods compared, the paper's scaling claim."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from pathlib import Path

import pandas as pd

from instances.disk import write_aside
from instances.paths import Paths
from instances.scenario import Scenario
from reports.figures.paths import draw_claim, draw_methods, draw_paths
from reports.figures.svg import Drawn, inline_svg
from reports.figures.wind import draw_wind


@dataclass(frozen=True, eq=False)
class Case:
    """One scenario of the page: its paths, its methods (`methods_table`), CPU times (`scaling_table`), a sentence."""

    scenario: Scenario
    paths: Paths
    methods: pd.DataFrame
    scaling: pd.DataFrame
    effect: str


def write_moving_cost_page(cases: Sequence[Case], path: Path | str, title: str) -> None:
    """Write the page about `cases` to `path`."""
    css = resources.files("reports").joinpath("templates", "report.css").read_text(encoding="utf-8")
    write_aside(
        path,
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(title)}</title>"
        f"<meta name='viewport' content='width=device-width, initial-scale=1'><style>{css}</style></head><body><main>"
        f"<h1>{escape(title)}</h1>{''.join(map(_case, cases))}</main></body></html>\n",
    )


def _case(case: Case) -> str:
    scenario, n = case.scenario, case.paths.n_nodes
    about = (
        f"{scenario.n_tasks} tasks and {scenario.n_depots} depots, {n * (n - 1)} ordered pairs, airspeed "
        f"{scenario.airspeed:g} m/s. Every path of every method was re-evaluated outside the method: length, wind "
        "integral, collision."
    )
    wind = [] if scenario.wind is None else [draw_wind(scenario.wind, scenario.free)]
    claim = (
        ""
        if case.scaling.empty
        else (f"<h2>The paper's scaling claim</h2>{_table(case.scaling)}{_figure(draw_claim(case.scaling))}")
    )
    return (
        f"<p>{escape(about)}</p><p>{escape(case.effect)}</p>"
        f"<h2>Wind and paths</h2>{''.join(map(_figure, [*wind, draw_paths(scenario, case.paths)]))}"
        f"<h2>Methods</h2>{_table(case.methods)}{_figure(draw_methods(case.methods))}{claim}"
    )


def _figure(drawn: Drawn) -> str:
    words = f"<figcaption><b>{escape(drawn.title)}.</b> {escape(drawn.caption)}</figcaption>"
    return f"<figure>{inline_svg(drawn)}{words}</figure>"


def _table(frame: pd.DataFrame) -> str:
    head = "".join(f"<th scope='col'>{escape(str(name))}</th>" for name in frame.columns)
    rows = "".join(
        "<tr>"
        + "".join(f"<td>{v:.3g}</td>" if isinstance(v, float) else f"<td>{escape(str(v))}</td>" for v in row)
        + "</tr>"
        for row in frame.itertuples(index=False)
    )
    return f"<div class='scroll'><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
