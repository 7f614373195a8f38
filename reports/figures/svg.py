"""SVG: a matplotlib figure as markup that follows the page's light and dark colours, or as a file."""

from __future__ import annotations

import html
import io
import re
from dataclasses import dataclass
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

    chart : what it was drawn from, None for a map or another drawing.
    """

    key: str
    title: str
    caption: str
    figure: Figure
    chart: Chart | None = None


def inline_svg(drawn: Drawn) -> str:
    """Return `drawn` as an ``<svg>`` element: ink follows the page, ids are the figure's own, two decimals are kept."""
    buffer = io.StringIO()
    with rc_context(RC | {"svg.hashsalt": drawn.key}):
        drawn.figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    svg = buffer.getvalue()
    svg = _printable(svg[svg.index("<svg") :])
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    svg = _ROUNDABLE.sub(_rounded, svg)
    prefix = re.sub(r"[^\w-]", "-", drawn.key)
    svg = re.sub(r'(id="|url\(#|xlink:href="#)', rf"\g<1>{prefix}-", svg)
    svg = svg.replace(INK, "currentColor").replace(PAPER, "var(--paper)").replace(FAINT, "var(--faint)")
    for side in ("width", "height"):
        svg = re.sub(rf'(<svg[^>]*?) {side}="[^"]*"', r"\1", svg, count=1)
    label = html.escape(f"{drawn.title}. {drawn.caption}", quote=True)
    width = drawn.figure.get_figwidth() * 96
    return svg.replace("<svg", f'<svg role="img" aria-label="{label}" style="max-width:{width:.0f}px"', 1)


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
    buffer = io.BytesIO()
    with rc_context(RC | {"svg.hashsalt": target.stem}):
        figure.savefig(buffer, format=kind[1:], dpi=160, metadata={"Date": None} if kind == ".svg" else None)
    data = buffer.getvalue()
    write_aside(target, _printable(_ROUNDABLE.sub(_rounded, data.decode())) if kind == ".svg" else data)


def _printable(svg: str) -> str:
    """Return `svg` without the control characters that XML forbids; a name in a figure may hold them."""
    return _CONTROL.sub("\ufffd", svg)


_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ufffe\uffff]")
