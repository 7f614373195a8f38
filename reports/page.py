"""Page: one self-contained HTML file about the runs of one or several stores. It runs nothing and needs no network."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd

from instances import InputError
from instances.disk import write_aside
from reports.figures.convergence import convergence
from reports.figures.svg import Drawn, inline_svg
from reports.metrics import contradictions, with_gaps
from reports.payload import embedded, payload
from reports.sections import environment_section, group_tables, meanings, summary_table
from reports.stores import Stores, read_stores

TITLE = "Solvers of the min-max multi-depot multiple TSP, compared"


def write_report(folders: Sequence[Path | str], path: Path | str, *, title: str = TITLE) -> pd.DataFrame:
    """Write the page about every run below `folders` to `path` and return the frame it was made from.

    Raises InputError where a folder does not exist or holds no run, or the page cannot be written.
    """
    stores = read_stores(*folders)
    write_page(stores, path, title=title)
    return stores.runs


def write_page(stores: Stores, path: Path | str, *, title: str = TITLE) -> None:
    """Write the page about `stores` to `path`; InputError as `write_report`."""
    if stores.runs.empty:
        first = f" ({stores.warnings[0]})" if stores.warnings else ""
        raise InputError(f"{', '.join(map(str, stores.folders))}: holds no run that can be read{first}")
    write_aside(path, _html(stores, title))


def _html(stores: Stores, title: str) -> str:
    runs = with_gaps(stores.runs)
    data = payload(runs, stores.instance_files)
    lies = contradictions(stores.runs)
    return _template().render(
        title=title,
        about=_about(runs, stores),
        sections=[
            {"key": key, "title": name}
            for key, name in (
                ("summary", "Methods"),
                ("figures", "Quality and time"),
                ("groups", "By group"),
                ("instances", "Instances"),
                ("runs", "Runs"),
                ("limits", "Limits and machine"),
            )
        ],
        contradictions=lies.to_dict("records"),
        checked=_checked(runs),
        warnings=stores.warnings,
        summary=summary_table(runs),
        figures=[_shown(drawn) for drawn in (convergence(runs),)],
        groups=group_tables(runs),
        embedded_note=f"{len(data['details']):,} of {len(runs):,} runs are embedded whole.",
        environments=environment_section(runs, stores),
        meanings=meanings(),
        version=_version(),
        data=embedded(data),
        css=_asset("report.css"),
        js=_asset("report.js"),
    )


def _about(runs: pd.DataFrame, stores: Stores) -> str:
    names = ", ".join(folder.name for folder in stores.folders)
    return (
        f"{len(runs):,} runs of {runs['method'].nunique()} methods on {runs['digest'].nunique():,} instances, "
        f"{runs['seed'].nunique()} seeds, from {names}."
    )


def _checked(runs: pd.DataFrame) -> str:
    return (
        f"No contradictions: {int(runs['recomputed'].notna().sum()):,} sets of routes were costed again and "
        f"{int(runs['bound'].notna().sum()):,} lower bounds held against them."
    )


def _shown(drawn: Drawn) -> dict[str, Any]:
    return {"key": drawn.key, "title": drawn.title, "caption": drawn.caption, "svg": inline_svg(drawn)}


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
