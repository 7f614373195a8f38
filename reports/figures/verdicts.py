"""Who wins: how much worse every other way to fly maps than the mission, draw by draw and as an interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from reports.figures.chart import Axis, Chart, Panel, Rule, Series
from reports.figures.mission import look_of
from reports.figures.static import drawn
from reports.figures.style import INK, Style
from reports.figures.svg import Drawn
from reports.verdicts import MISSION, Verdict, named


def draw_verdicts(draws: pd.DataFrame, verdicts: Sequence[Verdict], unit: str) -> Drawn:
    """Return the RMSE of each baseline less the mission's over the same draw, and the mean's interval.

    draws : a row a plan and draw: name, draw, rmse, refused.
    """
    own = draws[draws["name"] == MISSION].set_index("draw")["rmse"]
    series = []
    for row, verdict in enumerate(verdicts):
        mine = draws[draws["name"] == verdict.name]
        above = mine["rmse"].to_numpy() - own.loc[mine["draw"]].to_numpy()
        flyable, look = (mine["refused"] == "").to_numpy(), look_of(row + 1)._replace(marker="o")
        for shown, word in ((flyable, "flown"), (~flyable, "nobody may fly it")):
            more = {"draw": mine["draw"].to_numpy(str)[shown], "value": np.full(shown.sum(), word)}
            rows = np.full(shown.sum(), float(row))
            dots = Series(verdict.name, above[shown], rows, look, "points", more=more, size=4.5, opacity=0.75)
            series.append(replace(dots, hollow=word != "flown"))
        if verdict.rmse.pairs > 1 and not verdict.refused:
            mean, ends = [verdict.turned.mean], ([verdict.turned.low], [verdict.turned.high])
            more = {"value": np.array(["mean and its 95 % interval"])}
            look = Style(INK, "-", "D")
            series.append(Series(verdict.name, mean, [row + 0.28], look, "points", *ends, "across", more, size=4.5))
    names = [f"{named(v.name)}: {_word(v)}" for v in verdicts]
    x = Axis("RMSE less the mission's; right of 0 the mission is better", unit)
    panel = Panel(x, Axis("plan", names=names), series, rules=[Rule("x", 0.0)])
    caption = (
        "A dot a draw of field and noise, flown by both; hollow where nobody may fly the draw's tours. Below the dots "
        "the mean and its 95 % interval (Student's t of the paired differences): the mission wins where all of it lies "
        "right of 0, loses where it lies left, and else draws."
    )
    chart = Chart([panel], height=0.7 + 0.5 * len(verdicts))
    return drawn("verdicts", "Wins, draws and losses", caption, chart)


def _word(verdict: Verdict) -> str:
    return {"wins": "mission wins", "loses": "mission loses", "draws": "draw"}.get(verdict.outcome, verdict.outcome)
