"""The one builder of pages: blocks in, one self-contained HTML file out. It runs nothing and needs no network.

What a page shows comes from files that others may have written, so it carries a Content-Security-Policy: the browser
runs the page's own scripts, known by their digests, and nothing else, and asks nothing of the network (W3C, CSP Level
3).
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from instances.disk import write_aside
from reports import numbers
from reports.figures.chart import Chart
from reports.figures.svg import inline_svg
from reports.pages.blocks import Block, Section, figures_in

REFRESH = 5
"""Seconds after which a live page is loaded again where scripts are off."""


@dataclass(frozen=True)
class Page:
    """One page.

    about : what it is about, in a sentence or two. units : what the footer says. script : file of what is interactive
    here alone; it reads `data`. live : it is served by this machine and asks it for what is new; without scripts it is
    loaded again every REFRESH seconds.
    """

    title: str
    about: str
    blocks: Sequence[Block]
    units: str
    script: str = ""
    data: Any = None
    live: bool = False

    @property
    def contents(self) -> list[Section]:
        """The sections that the navigation names."""
        return [block for block in self.blocks if isinstance(block, Section) and not block.tone]


def write_page(page: Page, path: Path | str) -> None:
    """Write `page` to `path`; InputError where it cannot be written."""
    write_aside(path, page_text(page).encode("utf-8", "backslashreplace"))  # a file's name may hold what is no text


def page_text(page: Page) -> Markup:
    """Return `page` as one HTML text."""
    scripts = _scripts(page)
    given = {"page": page, "scripts": scripts, "policy": policy(page, scripts), "refresh": REFRESH}
    return fragment("page.html.j2", **given, version=_version())


def blocks_text(blocks: Sequence[Block]) -> Markup:
    """Return `blocks` as they stand in a page."""
    return Markup(_templates().get_template("blocks.html.j2").module.blocks(blocks))  # type: ignore[attr-defined]


def fragment(name: str, **given: Any) -> Markup:
    """Return the template `name` filled with `given`, text being escaped."""
    return Markup(_templates().get_template(name).render(**given))


def embedded(data: Any) -> Markup:
    """Return `data` as JSON that may stand inside a ``<script>`` element: in ASCII, and with nothing HTML reads."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return Markup(text.translate(_READ_BY_HTML))


_READ_BY_HTML = {ord(character): f"\\u{ord(character):04x}" for character in "<>&"}


def _script(*own: str) -> Markup:
    """Return the page's script: what every page does, then what the files `own` add, in a scope of its own."""
    parts = [_asset(name) for name in ("page.js", *own) if name]
    return Markup("\n").join([Markup('\n"use strict";\n{'), *parts, Markup("}\n")])


def _scripts(page: Page) -> list[Markup]:
    """Return the scripts of `page`, the charts' library only where there are charts."""
    scripts = [_script("charts.js", page.script)]
    if any(drawn.chart for drawn in figures_in(page.blocks)):
        from reports.figures.interactive import library  # here: Bokeh takes its time

        scripts.insert(0, Markup(library()))
    return scripts


def policy(page: Page, scripts: Sequence[str] | None = None) -> str:
    """Return the page's Content-Security-Policy; figures and markers style themselves, pictures are data."""
    told = _scripts(page) if scripts is None else scripts
    digests = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in told]
    sources = " ".join(f"'sha256-{digest}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {sources}; style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'" + ("; connect-src 'self'" if page.live else "")
    )


@cache
def _templates() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("reports.pages"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "kind": lambda block: type(block).__name__,
        "svg": lambda drawn: Markup(inline_svg(drawn)),
        "chart": _chart,
        "embedded": embedded,
        "asset": _asset,
        "joined": lambda text: text.replace(" %", numbers.PER_CENT),
    }
    return environment


def _chart(chart: Chart) -> dict[str, Any]:
    from reports.figures.interactive import embedded as interactive  # here: Bokeh takes its time

    return interactive(chart)


def _asset(name: str) -> Markup:
    return Markup(resources.files("reports.pages").joinpath("templates", name).read_text(encoding="utf-8"))


def _version() -> str:
    try:
        return f"mmmdmtsp-workbench {version('mmmdmtsp-workbench')}"
    except PackageNotFoundError:
        return "mmmdmtsp-workbench"
