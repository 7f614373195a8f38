"""One self-contained page about moving costs: the wind, the paths, the methods compared, the paper's scaling claim."""

from __future__ import annotations

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


def write_moving_cost_page(
    scenario: Scenario, paths: Paths, methods: pd.DataFrame, scaling: pd.DataFrame, effect: str, path: Path | str
) -> None:
    """Write the page to `path`.

    methods : see `draw_methods`; scaling : see `draw_claim`; effect : a sentence on how much the wind matters.
    """
    wind = [] if scenario.wind is None else [draw_wind(scenario.wind, scenario.free)]
    title = f"Moving costs of {scenario.name}"
    n = paths.n_nodes
    about = (
        f"{scenario.n_tasks} tasks and {scenario.n_depots} depots, {n * (n - 1)} ordered pairs, airspeed "
        f"{scenario.airspeed:g} m/s. Every path of every method was re-evaluated outside the method: length, wind "
        "integral, collision."
    )
    css = resources.files("reports").joinpath("templates", "report.css").read_text(encoding="utf-8")
    write_aside(
        path,
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(title)}</title>"
        f"<meta name='viewport' content='width=device-width, initial-scale=1'><style>{css}</style></head><body><main>"
        f"<h1>{escape(title)}</h1><p>{escape(about)}</p><p>{escape(effect)}</p>"
        f"<h2>Wind and paths</h2>{''.join(map(_figure, [*wind, draw_paths(scenario, paths)]))}"
        f"<h2>Methods</h2>{_table(methods)}{_figure(draw_methods(methods))}"
        f"<h2>The paper's scaling claim</h2>{_table(scaling)}{_figure(draw_claim(scaling))}</main></body></html>\n",
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
