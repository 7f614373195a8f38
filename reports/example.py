"""Example: one instance of the store drawn at full size, with the best routes found for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from instances import InputError, as_routes
from instances.files import read_instance
from reports.figures.routes import draw_routes
from reports.figures.svg import Drawn
from reports.record import read_run

LARGEST = 120
"""Tasks of an example at most: more cannot be followed by eye."""


def example_routes(runs: pd.DataFrame, instance_files: dict[str, Path]) -> list[Drawn]:
    """Return one drawing of the best routes on the largest instance of at most `LARGEST` tasks; none without one."""
    solved = runs[runs["value"].notna() & (runs["n_tasks"] <= LARGEST) & runs["digest"].isin(list(instance_files))]
    order = solved.sort_values(["n_tasks", "n_depots", "instance", "value", "elapsed"], kind="stable")
    order = order[::-1].drop_duplicates("digest", keep="last")
    for run in order.itertuples():
        try:
            instance = read_instance(instance_files[str(run.digest)])
            routes = as_routes(read_run(Path(str(run.path))).own["routes"])
        except InputError:
            continue
        if instance.coordinates is None:
            continue
        share = np.asarray(run.tour_costs, dtype=float)
        balance = f"{100 * share.min() / share.max():.0f} %" if share.max() > 0 else "–"
        caption = (
            f"The best routes found for {run.instance} ({run.method}, seed {run.seed}): squares are depots, dots are "
            "tasks, arrows give the direction of flight. Bars: cost of each UAV's tour; the dashed line is the "
            f"longest, which the problem minimises; the shortest is {balance} of it."
        )
        return [Drawn("example", "An example", caption, draw_routes(instance, routes))]
    return []
