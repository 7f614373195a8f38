"""What path polish did to a mission's tours: what stays unknown, what each UAV flies, paths before and after."""

from __future__ import annotations

import pandas as pd

from instances.arrays import Floats
from reports import numbers
from reports.columns import Column
from reports.figures.polish import draw_polish
from reports.figures.svg import Drawn
from reports.pages.blocks import Block, table_of
from reports.products import Products

COLUMNS = [
    Column("uav", "UAV"),
    Column("length_before", "Flown before", "km", numbers.fixed(2, 1e-3), "turns included"),
    Column("length_after", "after", "km", numbers.fixed(2, 1e-3)),
    Column("cost_before", "Cost before", "s", numbers.cost, "of the flight, turns included"),
    Column("cost_after", "after", "s", numbers.cost),
    Column(
        "budget", "Allowed", "s", numbers.cost, "flight.endurance, or the dearest flight before where none is given"
    ),
    Column("used", "Used", "", numbers.fixed(1, 100, numbers.PER_CENT), "cost after of what is allowed"),
]
"""Of ``polish.json``, a row a UAV."""


def path_polish(products: Products, tasks: Floats) -> tuple[list[Block], list[Drawn]]:
    """Return the blocks about path polish, and its figure, which is one of them; nothing where tours were not moved."""
    said = products.polish
    if said is None:
        return [], []
    before, after, bound = said["rms_sd_before"], said["rms_sd_after"], said["bound"]
    unit = products.unit
    kept = "limited by endurance" if all(said["endurance_given"]) else "no tour dearer than the dearest before"
    worth = f"{after / before - 1:+.0%}" if after < before else "nothing better was found within what is allowed"
    words = (
        f"Path polish moved the waypoints for what is sensed along the paths, the order of visits fixed, {kept}: the "
        f"root mean square sd √J promised at the test points went from {before:.3g} to {after:.3g} {unit} ({worth}). "
        f"No tours from these depots, none longer than the longest of these, can leave less than {bound:.3g} {unit}."
    )
    rows = pd.DataFrame({
        "uav": [f"UAV {k}" for k in range(len(said["budgets"]))],
        "length_before": said["lengths_before"],
        "length_after": said["lengths_after"],
        "cost_before": said["costs_before"],
        "cost_after": said["costs_after"],
        "budget": said["budgets"],
    })  # fmt: skip
    rows["used"] = rows["cost_after"] / rows["budget"]
    paths = [products.table("flight", file) for file in ("unpolished.csv", "polished.csv")]
    figure = draw_polish(products.scenario, tasks, *paths)
    return [words, table_of(rows, COLUMNS, key="polish"), figure], [figure]
