"""The page about moving costs: the wind, the paths, the methods compared, the paper's scaling claim."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from instances.paths import Paths
from instances.scenario import Scenario
from reports.columns import EXCESS, SCALING, shown
from reports.figures.paths import draw_claim, draw_methods, draw_paths
from reports.figures.wind import draw_wind
from reports.pages.blocks import Beside, Block, Section, table_of
from reports.pages.made import machine
from reports.pages.page import Page, write_page


def write_moving_cost_page(
    scenario: Scenario,
    paths: Paths,
    methods: pd.DataFrame,
    scaling: pd.DataFrame,
    effect: str,
    path: Path | str,
    environment: Mapping[str, Any],
) -> None:
    """Write the page to `path`.

    methods : see `draw_methods`; scaling : see `draw_claim`; effect : a sentence on how much the wind matters;
    environment : machine and versions it was measured with.
    """
    n = paths.n_nodes
    about = (
        f"{scenario.n_tasks} tasks and {scenario.n_depots} depots, {n * (n - 1)} ordered pairs, airspeed "
        f"{scenario.airspeed:g} m/s. Every path of every method was re-evaluated outside the method: length, wind "
        "integral, collision."
    )
    wind = [] if scenario.wind is None else [draw_wind(scenario.wind, scenario.free)]
    compared = table_of(methods, shown(EXCESS, methods), key="methods")
    scaled = table_of(scaling, shown(SCALING, scaling), key="scaling")
    blocks: list[Block] = [
        effect,
        Section("Wind and paths", [Beside([*wind, draw_paths(scenario, paths)])], "paths"),
        Section("Methods", [compared, draw_methods(methods)], "methods"),
        Section("The paper's scaling claim", [scaled, draw_claim(scaling)], "scaling", "Scaling"),
        replace(machine(environment), key="limits"),
    ]
    write_page(Page(f"Moving costs of {scenario.name}", about, blocks, "Lengths in metres, costs in seconds."), path)
