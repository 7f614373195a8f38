"""Who wins: how much worse every other way to fly maps than the mission, draw by draw and as an interval."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib import rc_context

from reports.figures.style import COLOURS, FAINT, INK, MARKERS, PAPER, RC, WIDTH, new_figure
from reports.figures.svg import Drawn
from reports.verdicts import MISSION, Verdict, named


@rc_context(RC)
def draw_verdicts(draws: pd.DataFrame, verdicts: Sequence[Verdict], unit: str) -> Drawn:
    """Return the RMSE of each baseline less the mission's over the same draw, and the mean's interval.

    draws : a row a plan and draw: name, draw, rmse, refused.
    """
    figure = new_figure(WIDTH, 0.9 + 0.5 * len(verdicts))
    axes = figure.subplots()
    own = draws[draws["name"] == MISSION].set_index("draw")["rmse"]
    for row, verdict in enumerate(verdicts):
        mine = draws[draws["name"] == verdict.name]
        above = mine["rmse"].to_numpy() - own.loc[mine["draw"]].to_numpy()
        flyable = (mine["refused"] == "").to_numpy()
        colour = COLOURS[(row + 1) % len(COLOURS)]
        for shown, filled in ((flyable, True), (~flyable, False)):
            face = colour if filled else "none"
            axes.scatter(above[shown], np.full(shown.sum(), row), s=22, alpha=0.75, facecolors=face, edgecolors=colour)
        if verdict.rmse.pairs > 1 and not verdict.refused:
            ends = [verdict.turned.low, verdict.turned.high]
            axes.plot(ends, [row + 0.28] * 2, color=INK, linewidth=1.6, marker="|", markersize=7)
            axes.plot(verdict.turned.mean, row + 0.28, color=INK, marker=MARKERS[3], markersize=4.5, mec=PAPER, mew=0.4)
    axes.axvline(0.0, color=FAINT, linewidth=1.0)
    axes.set_yticks(range(len(verdicts)), [f"{named(v.name)}: {_word(v)}" for v in verdicts])
    axes.set_ylim(len(verdicts) - 0.4, -0.6)
    axes.set_xlabel(f"RMSE less the mission's [{unit}]; right of 0 the mission is better")
    caption = (
        "A dot a draw of field and noise, flown by both; hollow where nobody may fly the draw's tours. Below the dots "
        "the mean and its 95 % interval (Student's t of the paired differences): the mission wins where all of it lies "
        "right of 0, loses where it lies left, and else draws."
    )
    return Drawn("verdicts", "Wins, draws and losses", caption, figure)


def _word(verdict: Verdict) -> str:
    return {"wins": "mission wins", "loses": "mission loses", "draws": "draw"}.get(verdict.outcome, verdict.outcome)
