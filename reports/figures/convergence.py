"""Convergence: the gap of each method over time, the median of all runs, and a panel a method with its quartiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from instances.arrays import Floats, Ints
from reports import numbers
from reports.figures.chart import Axis, Chart, Panel, Series
from reports.figures.static import drawn
from reports.figures.style import SOONEST, Style, styles
from reports.figures.svg import Drawn
from reports.metrics.integrals import finished_traces

POINTS = 160
"""Points of time at which the runs are compared."""
PANELS = 9
"""Methods with a panel of their own at most: those with the least gap in the end."""


def convergence(runs: pd.DataFrame) -> Drawn:
    """Draw the median gap to the best known or found over time, a line a method. runs : with gaps."""
    times, look = _times(runs), styles(runs["method"])
    medians = {method: 100 * middle for method, (_, middle, _) in _quartiles(runs, times).items()}
    series = [_line(method, times, middle[None], look[method]) for method, middle in medians.items()]
    top, cut = _top(medians)
    caption = (
        "Gap of the routes so far to the best known or found: the median of each method's runs over "
        f"{runs['digest'].nunique()} instances and all seeds. A line begins where half of the runs have routes. "
        f"Lower and further left is better; the scale is linear below 0.1 %.{cut}"
    )
    return drawn("convergence", "Convergence", caption, Chart([Panel(*_axes(times, top), series)]))


def convergence_panels(runs: pd.DataFrame) -> Drawn:
    """Draw median and quartiles of each method in a panel of its own, the other medians behind it."""
    times, look = _times(runs), styles(runs["method"])
    quartiles = {method: 100 * of for method, of in _quartiles(runs, times).items()}
    kept = sorted(sorted(quartiles, key=lambda m: (quartiles[m][1][-1], m))[:PANELS])
    x, y = _axes(times, _top({method: quartiles[method][1] for method in kept})[0])
    behind = _behind(times, [quartiles[method][1] for method in kept])
    panels = []
    for method in kept:
        own = _line(method, times, quartiles[method][[1, 0, 2]], look[method])
        panels.append(Panel(x, y, [behind, replace(own, size=0)], method))
    left_out = f" The {PANELS} methods with the least gap in the end are shown." if len(quartiles) > PANELS else ""
    caption = (
        "The same, a panel a method: line and band are the median run and the quartiles, which show how much "
        f"instances and seeds differ; the thin lines are the other methods' medians.{left_out}"
    )
    chart = Chart(panels, min(3, len(kept)), 1.45, shared=True)
    return drawn("convergence-panels", "Convergence with quartiles", caption, chart)


def _axes(times: Floats, top: float) -> tuple[Axis, Axis]:
    return (
        Axis("time", "s", "log", (float(times[0]), float(times[-1]))),
        Axis("gap to the best", "%", "gap", (-0.012, top)),
    )


def _top(medians: Mapping[str, Floats]) -> tuple[float, str]:
    """Return where the axis of gaps [%] ends, and a sentence where first routes lie beyond: they would flatten it."""
    finite = {method: of[np.isfinite(of)] for method, of in medians.items()}
    values = np.concatenate([*finite.values(), [0.1]])
    enough, most = 2 * float(np.quantile(values, 0.9)), float(values.max())
    if most <= 2 * enough:
        return 1.2 * most, ""
    beyond = sum(bool((of > enough).any()) for of in finite.values())
    return enough, (
        f" The axis ends at {enough:.3g} %: the first routes of {numbers.counted(beyond, 'method')} lie beyond, up to "
        f"{most:.3g} %."
    )


def _line(name: str, times: Floats, values: Floats, look: Style) -> Series:
    """Return the first of `values` (k, times) over time, and the others as the ends of its spread."""
    kept = _told(values)
    middle, *ends = values[:, kept]
    low, high = ends or (None, None)
    return Series(name, times[kept], middle, look, "step", low, high)


def _told(values: Floats) -> Ints:
    """Return at which times steps of `values` (k, times) are to be told: where one changes, and the last."""
    there: Ints = np.flatnonzero(np.isfinite(values[0]))
    of = values[:, there]
    changed = np.ones(len(there), dtype=bool)
    changed[1:-1] = (of[:, 1:-1] != of[:, :-2]).any(axis=0)
    return there[changed]


def _behind(times: Floats, lines: Sequence[Floats]) -> Series:
    """Return `lines` as scenery, one after the other with a break between."""
    kept = [_told(line[None]) for line in lines]
    x = np.concatenate([[*times[at], np.nan] for at in kept])
    y = np.concatenate([[*line[at], np.nan] for line, at in zip(lines, kept, strict=True)])
    return Series("", x, y, kind="step", width=0.6, size=0)


def _times(runs: pd.DataFrame) -> Floats:
    earliest = min((trace[0, 0] for trace in runs["trace"] if len(trace)), default=SOONEST)
    last = max(float(runs["time_limit"].max()), 2 * SOONEST)
    return np.geomspace(min(max(earliest, SOONEST), last / 2), last, POINTS)


def _quartiles(runs: pd.DataFrame, times: Floats) -> dict[str, Floats]:
    """Return lower quartile, median, upper quartile of the gap at each time, shape (3, times), for each method."""
    return {
        str(method): np.quantile(_gaps(group, times), [0.25, 0.5, 0.75], axis=0, method="nearest")
        for method, group in runs.groupby("method", sort=True)
    }


def _gaps(runs: pd.DataFrame, times: Floats) -> Floats:
    """Return the gap of each run at each time, shape (runs, times), infinite before the first routes."""
    gaps = np.full((len(runs), len(times)), np.inf)
    for i, (trace, best) in enumerate(zip(finished_traces(runs), runs["best"], strict=True)):
        if len(trace) and np.isfinite(best):
            z = np.minimum.accumulate(np.where(np.isnan(trace[:, 1]), np.inf, trace[:, 1]))
            latest = np.searchsorted(trace[:, 0], times, side="right") - 1
            value = np.where(latest >= 0, z[np.maximum(latest, 0)], np.inf)
            gaps[i] = np.maximum(0.0, (value - best) / best if best > 0 else np.where(value > best, np.inf, 0.0))
    return gaps
