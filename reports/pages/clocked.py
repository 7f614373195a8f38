"""A wind that changes: what planning by the clock is worth, and the wind while it is flown."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from instances.environment.wind_changing import ChangingWind
from reports import numbers
from reports.columns import Column
from reports.figures.svg import Drawn
from reports.figures.wind_frames import draw_wind_frames
from reports.pages.blocks import Block, table_of
from reports.products import Products

NAMES = {
    "clocked": "planned by the clock",
    "promised": "planned for the wind of take-off: what its planner expects",
    "taken": "the same, flown as planned",
    "directed": "the same, each tour the better way round",
}
"""Key of static.json → what it is."""
RISKS = {"mean": "their mean", "cvar": "the mean of the worst fifth", "worst": "the worst"}
"""Risk that routes are chosen by → what it is."""
COLUMNS = [
    Column("name", "Plan"),
    Column("longest", "Longest tour", "s", numbers.cost, "flight time of the longest tour along reference paths"),
    Column("more", "Against planned by the clock", "", "{:+.1%}".format, "of the longest tour"),
]


def clocked_plan(products: Products, flown: pd.DataFrame) -> tuple[list[Block], list[Drawn]]:
    """Return the blocks about planning by the clock, and their figure; nothing where the wind stays."""
    said, wind = products.static_plan, products.scenario.wind
    if said is None or not isinstance(wind, ChangingWind):
        return [], []
    table = pd.DataFrame({"name": list(NAMES.values()), "longest": [said[key] for key in NAMES]})
    more = [said[key] / said["clocked"] - 1 if key not in ("clocked", "promised") else np.nan for key in NAMES]
    figure = draw_wind_frames(products.scenario, wind, flown)
    words = [verdict(said), *held(wind, float(flown["time"].max()))]
    if products.ensemble is not None:
        words.append(over_members(products.ensemble))
    return [" ".join(words), table_of(table.assign(more=more), COLUMNS, key="clocked"), figure], [figure]


def verdict(said: dict[str, float]) -> str:
    """Return in words what planning by the clock is worth. said : as of `Products.static_plan` [s]."""
    shares = said["taken"] / said["promised"], *(said[key] / said["clocked"] for key in ("taken", "directed"))
    wrong, lost, directed = (f"{share - 1:+.1%}".replace("-", "−") for share in shares)
    promised, taken, better, own = (f"{said[key]:.1f} s" for key in ("promised", "taken", "directed", "clocked"))
    return (
        f"Planned for the wind of take-off, as if it stayed, the longest tour is expected to take {promised}; in the "
        f"wind as it changes it takes {taken} ({wrong}), and {better} with each tour the better way round. By the "
        f"clock it is planned to take {own}: the static plan takes {lost} against that, {directed} in its "
        "better directions."
    )


def over_members(said: dict[str, Any]) -> str:
    """Return in words what the mission's tours take over an ensemble. said : as of `Products.ensemble` [s]."""
    words = (
        f"Flown along the same paths in each of {len(said['members'])} members of the ensemble, the longest tour takes "
        f"{_over(said)}."
    )
    if "risk" not in said:
        return words
    return (
        f"{words} The routes were chosen by {RISKS[said['risk']]}; chosen by the forecast planned with alone, of the "
        f"same solver's first routes, they would take {_over(said['without'])}."
    )


def _over(spread: dict[str, Any]) -> str:
    return (
        f"{min(spread['members']):.1f} to {spread['worst']:.1f} s, {spread['mean']:.1f} s on average and "
        f"{spread['cvar']:.1f} s over the worst fifth, against {spread['planned']:.1f} s in the forecast planned with"
    )


def held(wind: ChangingWind, duration: float) -> list[str]:
    """Return a sentence where flights of `duration` [s] outlast a forecast."""
    lasts = getattr(wind, "lasts", np.inf)
    if duration <= lasts:
        return []
    return [
        f"The forecast ends {lasts:.0f} s after take-off and the last UAV lands after {duration:.0f} s: from there on "
        "the wind of the last frame was taken to stay."
    ]
