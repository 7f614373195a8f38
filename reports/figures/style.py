"""Style of every figure: sizes, ink, and one colour, dash and marker a method that tell methods apart without colour.

Colours: the hues of M. Okabe and K. Ito, Color Universal Design (2008), safe for the colour-blind, in shades that hold
3 : 1 against the page's light and its dark paper (WCAG 2.2, 1.4.11); their yellow is left out, being too pale on white,
and their black is the ink. Dashes and markers repeat the distinction for print in grey.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

INK = "#1b1c1e"
"""Text, axes and marks: becomes the page's text colour."""
PAPER = "#fefefd"
"""Background: becomes the page's."""
FAINT = "#8a8c91"
"""Grid, secondary marks."""
COLOURS = ("#0069b4", "#c8500a", "#009e73", "#cf74aa", "#ab8a00", "#4999d6", "#84549f")
DASHES = ("-", (0, (5, 1.6)), (0, (1.2, 1.4)), (0, (5, 1.4, 1.2, 1.4)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")

SOONEST = 1e-3
"""Times below this [s] are drawn as this: shorter ones are not resolved."""
WIDTH = 7.2
"""Width of a full figure [inch]."""

RC: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "axes.titlesize": 9.5,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": FAINT,
    "grid.alpha": 0.35,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.6,
    "figure.facecolor": PAPER,
    "svg.fonttype": "none",
    "text.parse_math": False,  # names are shown as they are: "$x_{" is no formula
    **dict.fromkeys(("font.size", "axes.labelsize"), 9.0),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 8.0),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **dict.fromkeys(("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"), INK),
}


class Style(NamedTuple):
    """How one method is drawn in every figure."""

    colour: str
    dash: str | tuple[int, tuple[float, ...]]
    marker: str


def styles(methods: Iterable[str]) -> dict[str, Style]:
    """Return a style for each of `methods`, the same for the same set of names; 7 colours × 4 dashes × 9 markers."""
    return {
        method: Style(COLOURS[i % len(COLOURS)], DASHES[i % len(DASHES)], MARKERS[i % len(MARKERS)])
        for i, method in enumerate(sorted(set(methods)))
    }


def new_figure(width: float = WIDTH, height: float = 3.4) -> Figure:
    """Return an empty figure of `width` × `height` [inch] in this style."""
    with rc_context(RC):
        return Figure(figsize=(width, height), layout="constrained")


def plain(axis: Axis) -> None:
    """Write the numbers of a logarithmic axis as people do: 0.01, 0.1, 1, 10."""
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def gap_scale(axes: Axes, least: float) -> None:
    """Make y a gap [%]: logarithmic, linear below 0.1 %, from 0 or from `least` where that is below."""
    axes.set_yscale("symlog", linthresh=0.1, linscale=0.5)
    plain(axes.yaxis)
    axes.set_ylabel("gap to the best [%]")
    axes.set_ylim(bottom=1.3 * least if least < 0 else -0.012)


def legend_below(figure: Figure, axes: Axes, columns: int = 4) -> None:
    """Put one legend below the figure, for the lines of `axes`."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        widest = max(len(label) for label in labels)
        fitting = max(1, min(columns, len(labels), int(112 / (widest + 9))))
        figure.legend(handles, labels, loc="outside lower center", ncols=fitting, handlelength=3.2)
