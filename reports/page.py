"""Page: one self-contained HTML file about the runs of one or several stores. It runs nothing and needs no network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd

from instances import InputError
from instances.disk import write_aside
from reports import numbers
from reports.compare import Comparison, compare_stores
from reports.example import example_routes
from reports.figures import Drawn, study_figures
from reports.figures.svg import inline_svg
from reports.metrics import contradictions, with_gaps
from reports.payload import embedded, payload
from reports.sections import (
    against_section,
    environment_section,
    failure_table,
    group_tables,
    meanings,
    summary_notes,
    summary_table,
)
from reports.significance import significance
from reports.stores import Stores, read_stores

TITLE = "Solvers of the min-max multi-depot multiple TSP, compared"

MOST_CONTRADICTIONS = 200
MOST_WARNINGS = 50


@dataclass(frozen=True)
class Report:
    """What a page was made from: the frame, its contradictions, files left alone, and the comparison if asked for."""

    runs: pd.DataFrame
    contradictions: pd.DataFrame
    warnings: list[str]
    comparison: Comparison | None


def write_report(
    folders: Sequence[Path | str], path: Path | str, *, title: str = TITLE, against: Sequence[Path | str] = ()
) -> Report:
    """Write the page about every run below `folders` to `path`, compared with the runs below `against` if given.

    Raises InputError where a folder does not exist or holds no run that can be read, or the page cannot be written.
    """
    baseline = read_stores(*against) if against else None
    return write_page(read_stores(*folders), path, title=title, against=baseline)


def write_page(stores: Stores, path: Path | str, *, title: str = TITLE, against: Stores | None = None) -> Report:
    """Write the page about `stores` to `path`, compared with the baseline `against` if given; InputError as above."""
    _refuse_empty(stores)
    if against is not None:
        _refuse_empty(against)
    comparison = compare_stores(stores.runs, against.runs) if against is not None else None
    report = Report(stores.runs, contradictions(stores.runs), stores.warnings, comparison)
    write_aside(path, _html(stores, report, title))
    return report


def _refuse_empty(stores: Stores) -> None:
    if stores.runs.empty:
        first = f" ({stores.warnings[0]})" if stores.warnings else ""
        raise InputError(f"{', '.join(map(str, stores.folders))}: holds no run that can be read{first}")


def _html(stores: Stores, report: Report, title: str) -> str:
    runs = with_gaps(stores.runs)
    data = payload(runs, stores.instance_files)
    found = significance(runs)
    against = against_section(report.comparison) if report.comparison is not None else None
    return _template().render(
        title=title,
        about=_about(runs, stores),
        sections=_contents(against is not None),
        contradictions=report.contradictions.head(MOST_CONTRADICTIONS).to_dict("records"),
        n_contradictions=len(report.contradictions),
        checked=_checked(runs),
        warnings=report.warnings[:MOST_WARNINGS],
        n_warnings=len(report.warnings),
        n_failures=int(runs["status"].isin(["ERROR", "KILLED"]).sum()),
        failures=failure_table(runs),
        summary=summary_table(runs),
        summary_notes=summary_notes(runs),
        against=against,
        figures=[_shown(drawn) for drawn in study_figures(runs)],
        statistics={"lines": found.lines, "figures": [_shown(d) for d in found.figures], "tables": found.tables},
        groups=group_tables(runs),
        example=[_shown(drawn) for drawn in example_routes(runs, stores.instance_files)],
        embedded_note=_embedded_note(len(data["details"]), len(runs)),
        environments=environment_section(runs, stores),
        meanings=meanings(),
        version=_version(),
        data=embedded(data),
        css=_asset("report.css"),
        js=_asset("report.js"),
    )


def _contents(against: bool) -> list[dict[str, str]]:
    names = {"summary": "Methods"} | ({"against": "Baseline"} if against else {})
    names |= {"figures": "Quality and time", "statistics": "Significance", "groups": "By group"}
    names |= {"instances": "Instances", "runs": "Runs", "limits": "Limits and machine"}
    return [{"key": key, "title": name} for key, name in names.items()]


def _about(runs: pd.DataFrame, stores: Stores) -> str:
    counted = numbers.counted
    names = ", ".join(folder.resolve().name for folder in stores.folders)
    return (
        f"{counted(len(runs), 'run')} of {counted(runs['method'].nunique(), 'method')} on "
        f"{counted(runs['digest'].nunique(), 'instance')}, {counted(runs['seed'].nunique(), 'seed')}, from {names}."
    )


def _checked(runs: pd.DataFrame) -> str:
    return (
        f"No contradictions: {int(runs['recomputed'].notna().sum()):,} sets of routes were costed again and "
        f"{int(runs['bound'].notna().sum()):,} lower bounds held against them."
    )


def _embedded_note(held: int, runs: int) -> str:
    if held == runs:
        return "Every run is held whole in this page."
    return (
        f"To stay small, this page holds routes, trace and log of {held:,} of {runs:,} runs: failed ones and the "
        "best of each method and instance first; the others are in the store."
    )


def _shown(drawn: Drawn) -> dict[str, Any]:
    caption = drawn.caption.replace(" %", numbers.PER_CENT)
    return {"key": drawn.key, "title": drawn.title, "caption": caption, "svg": inline_svg(drawn)}


def _template() -> jinja2.Template:
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.ChainableUndefined, trim_blocks=True)
    return environment.from_string(_asset("report.html.j2"))


def _asset(name: str) -> str:
    return resources.files("reports").joinpath("templates", name).read_text(encoding="utf-8")


def _version() -> str:
    try:
        return f"mmmdmtsp-workbench {version('mmmdmtsp-workbench')}"
    except PackageNotFoundError:
        return "mmmdmtsp-workbench"
