"""SVG: a matplotlib figure as markup that follows the page's light and dark colours, or as a file."""

from __future__ import annotations

import html
import io
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from instances import InputError
from instances.disk import write_aside
from reports.figures.chart import Chart
from reports.figures.style import FAINT, INK, PAPER, RC


@dataclass(frozen=True)
class Drawn:
    """A figure with its words: `title`, and `caption`, which says what is seen and how to read it.

    chart : what it was drawn from, None for a map or another drawing. It is drawn as SVG once, for page and file.
    """

    key: str
    title: str
    caption: str
    figure: Figure
    chart: Chart | None = None

    @property
    def name(self) -> str:
        """The key as a file's name, without an ending."""
        return re.sub(r"[^\w.-]", "-", self.key)

    @cached_property
    def svg(self) -> str:
        """The text of an SVG file."""
        return _svg(self.figure, self.name)


def _svg(figure: Figure, salt: str) -> str:
    """Return the text of an SVG file of `figure`; `salt` makes its ids. Two decimals are kept."""
    buffer = io.StringIO()
    with rc_context(RC | {"svg.hashsalt": salt}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return _printable(_ROUNDABLE.sub(_rounded, buffer.getvalue()))


def inline_svg(drawn: Drawn) -> str:
    """Return `drawn` as an ``<svg>`` element: ink follows the page, ids are the figure's own, no background."""
    svg = drawn.svg[drawn.svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    svg = _BACKGROUND.sub(r"\g<1>fill: none", svg, count=1)
    prefix = re.sub(r"[^\w-]", "-", drawn.key)
    svg = re.sub(r'(id="|url\(#|xlink:href="#)', rf"\g<1>{prefix}-", svg)
    svg = svg.replace(INK, "currentColor").replace(PAPER, "var(--paper)").replace(FAINT, "var(--faint)")
    for side in ("width", "height"):
        svg = re.sub(rf'(<svg[^>]*?) {side}="[^"]*"', r"\1", svg, count=1)
    label = html.escape(f"{drawn.title}. {drawn.caption}", quote=True)
    width = drawn.figure.get_figwidth() * 96
    return svg.replace("<svg", f'<svg role="img" aria-label="{label}" style="max-width:{width:.0f}px"', 1)


_BACKGROUND = re.compile(r'(<g id="patch_1">.*?style=")fill: [^;"]*', re.S)
"""The first patch of a figure, which is its paper, whatever its colour."""
_ROUNDABLE = re.compile(r'\b(?:d|x|y|transform|points)="[^"]*"')


def _rounded(attribute: re.Match[str]) -> str:
    """Keep two decimals of the coordinates in an attribute."""
    return re.sub(r"(\d\.\d{2})\d+", r"\1", attribute.group())


def save_figure(figure: Figure, path: Path | str) -> None:
    """Write `figure` to `path`, as SVG, PNG or PDF by its ending; InputError for any other or where it cannot be."""
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in (".svg", ".png", ".pdf"):
        raise InputError(f"{target}: a picture must end in .svg, .png or .pdf")
    if kind == ".svg":
        write_aside(target, _svg(figure, target.stem))
        return
    buffer = io.BytesIO()
    with rc_context(RC):
        figure.savefig(buffer, format=kind[1:], dpi=160)
    write_aside(target, buffer.getvalue())


def _printable(svg: str) -> str:
    """Return `svg` without the control characters that XML forbids; a name in a figure may hold them."""
    return _CONTROL.sub("\ufffd", svg)


_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ufffe\uffff]")
