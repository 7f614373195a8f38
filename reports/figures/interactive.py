"""Interactive: a chart drawn by Bokeh, for the page: values under the pointer, zoom and pan, methods hidden and shown.

Only this file imports Bokeh, and only what writes a page imports this file. The page's script (charts.js) does what is
left: it puts the panels in their places, hides methods, follows the page's colours, and saves.
"""

from __future__ import annotations

from importlib import resources
from typing import Any, Literal

import numpy as np
from bokeh.document import Document
from bokeh.models import (
    BoxZoomTool,
    ColumnDataSource,
    FixedTicker,
    HoverTool,
    Line,
    NoOverlap,
    PanTool,
    PrintfTickFormatter,
    Range1d,
    Scatter,
    Segment,
    Step,
    VArea,
    VAreaStep,
    WheelZoomTool,
)
from bokeh.models.annotations import Span, Title
from bokeh.models.glyph import Glyph
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure

from reports.figures.chart import Axis, Chart, Panel, Series, marks, named
from reports.figures.static import LINEAR_BELOW, transformed
from reports.figures.style import FAINT, INK, Style

MARKS = {
    "o": "circle", "s": "square", "^": "triangle", "D": "diamond", "v": "inverted_triangle", "P": "plus", "X": "star",
    "<": "triangle_pin", ">": "square_pin", "_": "dash",
}  # fmt: skip
"""What Bokeh has in place of matplotlib's markers."""
INCH = 96
"""Pixels of an inch."""
POINT = 4 / 3
"""Pixels of a point."""
REACH = 14
"""Width [pixel] of the invisible line that the pointer meets."""
OUTSIDE = 1e3
"""On the scale of gaps: beyond the end of any axis, where what is infinite is drawn."""
SHOWN = 8
"""Values shown at once where many lie under the pointer."""
TICK = 20
"""Pixels of an axis for each of its ticks at least."""
Side = Literal["x", "y"]


def library() -> str:
    """Return BokehJS, which draws in the page; it asks nothing of the network."""
    script = resources.files("bokeh").joinpath("server", "static", "js", "bokeh.min.js")
    return script.read_text(encoding="utf-8")


def embedded(chart: Chart) -> dict[str, Any]:
    """Return what charts.js needs of `chart`: document, roots, legend, and where the columns of its table are.

    The same chart gives the same: Bokeh's own ids count on from one document to the next.
    """
    sources = dict[int, ColumnDataSource]()
    plots = list[figure]()
    for panel in chart.panels:
        plots.append(_plot(chart, panel, plots[0] if chart.shared and plots else None, sources))
    document = Document(title="")
    with document.models.freeze():
        for plot in plots:
            document.add_root(plot)
    ids = dict[str, str]()
    told = _renumbered(document.to_json(deferred=False), ids)
    shown = [(panel, series) for panel in chart.panels for series in panel.series if series.name]
    return {
        "document": told,
        "roots": [ids[plot.id] for plot in plots],
        "across": chart.columns,
        "legend": [{"name": name, **_key(series)} for name, series in chart.looks.items()],
        "titled": chart.titled,
        "columns": list(chart.frame().columns),
        "series": [{"source": ids[sources[id(series)].id], **_fields(chart, panel, series)} for panel, series in shown],
    }


def data(panel: Panel, series: Series) -> dict[str, Any]:
    """Return the columns of a series' source: the true values, and with ``_`` before them the places they are drawn at.

    ``x named`` and ``y named`` hold names in place of numbers; ``_end`` is where a step ends.
    """
    values = series.values
    found = dict(values)
    found |= {f"{side} named": of for side, of in named(panel, values).items() if of is not values[side]}
    if series.aside != 1:
        found["_x"] = values["x"] * series.aside
    for name in values:
        axis = panel.x if name == "x" or (series.spread == "across" and name in ("low", "high")) else panel.y
        if name in ("x", "y", "low", "high") and axis.scale == "gap":
            found[f"_{name}"] = np.clip(transformed(axis, values[name]), -OUTSIDE, OUTSIDE)
    if series.kind == "step":
        x = found.get("_x", values["x"])
        found["_end"] = np.append(x[1:], np.nan)[: len(x)]
    return {name: list(of) if np.asarray(of).dtype.kind in "UO" else of for name, of in found.items()}


def _fields(chart: Chart, panel: Panel, series: Series) -> dict[str, dict[str, str]]:
    """Return the table's columns of a series: those that say the same in every row, and fields of its source."""
    heads = chart.headings
    same = {"panel": panel.title, "series": series.name}
    same |= {f"{side} is": getattr(panel, side).words for side, head in heads.items() if side == head}
    at = {heads[side]: f"{side} named" if getattr(panel, side).names else side for side in heads}
    return {"same": same, "fields": at | {name: name for name in series.values if name not in heads}}


def _plot(chart: Chart, panel: Panel, first: figure | None, sources: dict[int, ColumnDataSource]) -> figure:
    """Return one panel; `first` gives its ranges where they are shared."""
    x, y = (_range(panel, "x"), _range(panel, "y")) if first is None else (first.x_range, first.y_range)
    given: dict[str, Any] = {
        "x_range": x, "y_range": y, "x_axis_type": _type(panel.x), "y_axis_type": _type(panel.y), "tools": "",
        "toolbar_location": None, "height": round(INCH * chart.height), "sizing_mode": "stretch_width", "min_border": 4,
        "background_fill_color": None, "border_fill_color": None, "outline_line_color": None,
    }  # fmt: skip
    plot = figure(**given)
    zoom, wheel = BoxZoomTool(), WheelZoomTool(modifiers="ctrl")
    plot.add_tools(zoom, PanTool(), wheel)
    plot.toolbar.active_drag, plot.toolbar.active_scroll = zoom, wheel
    if panel.title:
        plot.title = Title(text=panel.title, text_color=INK, text_font_size="12px", text_font=FONT)
    for side in ("x", "y"):
        _axis(plot, panel, side)
    for rule in panel.rules:
        pen: dict[str, Any] = {"line_color": rule.look.colour, "line_dash": dashes(rule.look)}
        pen["dimension"] = "height" if rule.axis == "x" else "width"
        plot.add_layout(Span(location=float(transformed(getattr(panel, rule.axis), rule.at)), **pen))
    for rank, series in enumerate(panel.series):
        if id(series) not in sources:
            sources[id(series)] = ColumnDataSource(data(panel, series))
        _draw(plot, panel, series, sources[id(series)], rank)
    return plot


FONT = "system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif"


def _type(axis: Axis) -> Literal["log", "linear"]:
    return "log" if axis.scale == "log" else "linear"


def _range(panel: Panel, side: Side) -> Range1d:
    axis: Axis = getattr(panel, side)
    start, end = (float(place) for place in transformed(axis, np.array(panel.span(side))))
    return Range1d(start=end, end=start) if axis.names and side == "y" else Range1d(start=start, end=end)


def _axis(plot: figure, panel: Panel, side: Side) -> None:
    """Give an axis its words, ticks and ink."""
    axis: Axis = getattr(panel, side)
    (drawn,), (grid,) = getattr(plot, f"{side}axis"), getattr(plot, f"{side}grid")
    drawn.axis_label, drawn.axis_label_text_color, drawn.major_label_text_color = axis.words, INK, INK
    drawn.axis_label_text_font = drawn.major_label_text_font = FONT
    drawn.axis_label_text_font_style, drawn.axis_label_text_font_size = "normal", "12px"
    drawn.axis_line_color = drawn.major_tick_line_color = INK
    drawn.minor_tick_line_color = INK if axis.scale == "log" and not axis.ticks else None
    drawn.major_label_policy = NoOverlap(min_distance=4)
    grid.grid_line_color, grid.grid_line_alpha = FAINT, 0.35
    if axis.names:
        drawn.ticker, labels = FixedTicker(ticks=list(range(len(axis.names)))), dict(enumerate(axis.names))
        drawn.major_label_overrides = labels
        drawn.major_label_policy, grid.visible = NoOverlap(min_distance=0), False
    elif axis.scale == "gap":
        ticks = _gap_ticks(*panel.span(side), most=int(plot.height or 0) // TICK)
        places = {float(transformed(axis, tick)): f"{tick:g}" for tick in ticks}
        drawn.ticker, drawn.major_label_overrides = FixedTicker(ticks=list(places)), places
        grid.ticker = drawn.ticker
    elif axis.ticks:
        drawn.ticker = grid.ticker = FixedTicker(ticks=list(axis.ticks))
        drawn.formatter = PrintfTickFormatter(format="%.6g")
    elif axis.scale == "log":
        low, high = panel.span(side)
        if high / low < 200:
            decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
            steps = (1, 2, 5) if high / low > 20 else range(1, 10)
            drawn.ticker = grid.ticker = FixedTicker(ticks=[step * 10.0**power for power in decades for step in steps])
        drawn.formatter = PrintfTickFormatter(format="%.0e" if low < 1e-4 else "%.6g")


def _gap_ticks(low: float, high: float, most: int) -> list[float]:
    """Return 0 and the decades of a scale of gaps from `low` to `high`, 2 and 5 between them where `most` fit."""
    decades = np.arange(np.log10(LINEAR_BELOW), np.log10(max(abs(low), abs(high), LINEAR_BELOW)) + 1)
    steps = (1.0, 2.0, 5.0) if 3 * len(decades) <= most else (1.0,)
    above = sorted({float(f"{step * 10.0**power:.1g}") for power in decades for step in steps})
    return [*(-tick for tick in reversed(above) if -tick >= low), 0.0, *(tick for tick in above if tick <= high)]


def _draw(plot: figure, panel: Panel, series: Series, source: ColumnDataSource, rank: int) -> None:
    """Draw one series: its spread, its line or points, its marks, and what the pointer meets."""
    look, columns = series.look, source.data
    at = {name: f"_{name}" if f"_{name}" in columns else name for name in ("x", "y", "low", "high")}
    x, y, low, high = at.values()
    if series.low is not None:
        _add(plot, series, source, _spread(series, x, y, low, high))
    if series.kind == "points":
        fill = None if series.hollow else look.colour
        glyph = Scatter(
            x=x, y=y, size=POINT * series.size, marker=MARKS[look.marker], line_color=look.colour, fill_color=fill,
            line_alpha=series.opacity, fill_alpha=series.opacity,
        )  # fmt: skip
        met = _add(plot, series, source, glyph)
    else:
        pen: dict[str, Any] = {"line_color": look.colour, "line_width": POINT * series.width, "line_dash": dashes(look)}
        pen["line_alpha"] = series.opacity
        stepped = series.kind == "step"
        _add(plot, series, source, Step(x=x, y=y, mode="after", **pen) if stepped else Line(x=x, y=y, **pen))
        places, heights = marks(panel, series, rank)
        if len(places):
            own = ColumnDataSource({"x": transformed(panel.x, places), "y": transformed(panel.y, heights)})
            size = POINT * series.size * 1.3
            dot = Scatter(x="x", y="y", size=size, marker=MARKS[look.marker], line_color=None, fill_color=look.colour)
            _add(plot, series, own, dot)
        if not series.name:
            return
        unseen: dict[str, Any] = {"line_alpha": 0.0, "line_width": REACH}
        reach: Glyph = Segment(x0=x, y0=y, x1="_end", y1=y, **unseen) if stepped else Line(x=x, y=y, **unseen)
        met = _add(plot, series, source, reach)
    if series.name:
        _tell(plot, panel, series, met)


def _spread(series: Series, x: str, y: str, low: str, high: str) -> Glyph:
    colour = series.look.colour
    if series.spread == "band":
        fill: dict[str, Any] = {"fill_color": colour, "fill_alpha": 0.22}
        if series.kind == "step":
            return VAreaStep(x=x, y1=low, y2=high, step_mode="after", **fill)
        return VArea(x=x, y1=low, y2=high, **fill)
    if series.spread == "bars":
        return Segment(x0=x, y0=low, x1=x, y1=high, line_color=colour, line_width=1.3)
    return Segment(x0=low, y0=y, x1=high, y1=y, line_color=colour, line_width=2.5)


def _add(plot: figure, series: Series, source: ColumnDataSource, glyph: Glyph) -> GlyphRenderer[Any]:
    renderer: GlyphRenderer[Any] = plot.add_glyph(source, glyph)
    renderer.name = series.name
    return renderer


def _tell(plot: figure, panel: Panel, series: Series, met: GlyphRenderer[Any]) -> None:
    """Tell the values of a series under the pointer, with their units."""
    rows, formats = [("", "$name")], dict[str, Any]()
    told = [("x", panel.x), ("y", panel.y)]
    if series.low is not None:
        told += [(name, panel.x if series.spread == "across" else panel.y) for name in ("low", "high")]
    for name, axis in told:
        if name in ("x", "y") and axis.names:
            rows.append(("", f"@{{{name} named}}"))
            continue
        formats[f"@{name}"] = "printf"
        rows.append((axis.label if name in ("x", "y") else name, f"@{name}{{%.4g}} {axis.unit}".strip()))
    rows += [(heading, f"@{{{heading}}}") for heading in series.more]
    for tool in plot.toolbar.tools:
        if isinstance(tool, HoverTool) and tool.tooltips == rows:
            tool.renderers = [*tool.renderers, met]
            return
    plot.add_tools(HoverTool(renderers=[met], tooltips=rows, formatters=formats, limit=SHOWN, mode="mouse"))


def dashes(look: Style) -> list[int]:
    """Return the dashes of a look [pixel], none for a full line."""
    return [] if isinstance(look.dash, str) else [round(2 * length) for length in look.dash[1]]


def _key(series: Series) -> dict[str, Any]:
    """Return how charts.js draws the key of a series."""
    line = series.kind != "points"
    return {"colour": series.look.colour, "dashes": dashes(series.look), "line": line, "hollow": series.hollow}


def _renumbered(told: Any, ids: dict[str, str]) -> Any:
    """Return a document as JSON with ids that count from 1, which `ids` then holds by Bokeh's."""
    if isinstance(told, list):
        return [_renumbered(part, ids) for part in told]
    if not isinstance(told, dict):
        return told
    found = {name: _renumbered(of, ids) for name, of in told.items()}
    if isinstance(told.get("id"), str):
        found["id"] = ids.setdefault(told["id"], str(len(ids) + 1))
    return found
