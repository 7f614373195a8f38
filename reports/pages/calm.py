"""What planning in the wind is worth: the mission's tours beside those of its calm twin, flown in the same wind."""

from __future__ import annotations

import pandas as pd

from instances.arrays import Floats
from reports import numbers
from reports.columns import Column
from reports.damage import reading
from reports.figures.calm import draw_calm_twin
from reports.figures.svg import Drawn
from reports.pages.blocks import Block, table_of
from reports.products import Products

NAMES = {
    "wind": "planned in the wind",
    "paths": "routes planned for calm air, paths between tasks in the wind",
    "calm": "planned for calm air, as it came out",
    "better": "the same, each tour the better way round",
    "worse": "the same, each tour the worse way round",
    "promised": "the same in calm air: what its planner expects",
}
"""Plan of calm.csv → what it is."""
COLUMNS = [
    Column("name", "Plan"),
    Column("longest", "Longest tour", "s", numbers.cost, "cost in the wind of the dearest reference path"),
    Column("more", "Against planned in the wind", "", "{:+.1%}".format, "of the longest tour"),
    Column("total", "All tours", "s", numbers.cost, "sum of their costs in the wind"),
]
NO_MATTER = 0.005
"""Planning in the wind is said to matter where it saves more than this share of the longest tour."""


def calm_twin(products: Products, tasks: Floats) -> tuple[list[Block], list[Drawn]]:
    """Return the blocks about the twin, and its figure, which is one of them; nothing where the mission has none."""
    path = products.folders["compare"] / "calm.csv"
    if not path.is_file():
        return [], []
    with reading(path, "a calm twin"):
        table = products.table("compare", "calm.csv").set_index("plan").loc[list(NAMES)]
    longest = table["longest"]
    plans = [
        (f"planned in the wind: longest {longest['wind']:.0f} s", products.table("flight", "reference.csv")),
        (f"planned for calm air: longest {longest['calm']:.0f} s", products.table("compare", "calm-paths.csv")),
    ]
    figure = draw_calm_twin(products.scenario, tasks, plans)
    own = float(longest["wind"])
    more = (longest / own - 1 if own > 0 else longest * 0).drop(["wind", "promised"])
    shown = table.assign(name=table.index.map(NAMES), more=more)
    return [verdict(longest), table_of(shown, COLUMNS, key="calm"), figure], [figure]


def verdict(longest: pd.Series) -> str:
    """Return in words what planning in the wind is worth. longest : cost of the longest tour [s], by plan."""
    share = {plan: 1 - longest["wind"] / cost if cost > 0 else 0.0 for plan, cost in longest.items()}
    saved = f"{share['better']:.1%} where each tour is flown the better way round, {share['worse']:.1%} the worse"
    judged = (
        f"Planning in the wind saves {share['calm']:.1%} of it, {saved}"
        if share["better"] > NO_MATTER
        else f"This wind is hardly worth planning for: planning in it saves {saved}"
    )
    return (
        f"Planned for calm air the longest tour is expected to cost {longest['promised']:.1f} s; flown in the wind it "
        f"costs {longest['calm']:.1f} s. {judged}. In calm air a tour costs the same either way round, so its planner "
        "has no reason to choose."
    )
