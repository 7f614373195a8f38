"""The page about moving costs: wind and paths of each scenario, the methods compared, the paper's scaling claim."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from instances.paths import Paths
from instances.scenario import Scenario
from reports.columns import EXCESS, SCALING, shown
from reports.figures.paths import draw_claim, draw_methods, draw_paths
from reports.figures.wind import draw_wind
from reports.pages.blocks import Beside, Block, Section, table_of
from reports.pages.made import code_notes, environments_of, limits_and_machines
from reports.pages.page import Page, write_page


@dataclass(frozen=True, eq=False)
class Case:
    """One scenario of the page: its paths, its methods (`methods_table`), CPU times (`scaling_table`), a sentence."""

    scenario: Scenario
    paths: Paths
    methods: pd.DataFrame
    scaling: pd.DataFrame
    effect: str


def write_moving_cost_page(
    cases: Sequence[Case], runs: pd.DataFrame, stored: Iterable[Path], path: Path | str, title: str
) -> None:
    """Write the page about `cases` to `path`; runs : `moving_cost_frame`; stored : the files of the runs."""
    about = (
        f"{len(runs)} runs of {runs['method'].nunique()} methods on {len(cases)} scenarios. Every path of every method "
        "was re-evaluated outside the method: length, wind integral, collision."
    )
    several = len(cases) > 1
    blocks: list[Block] = [*code_notes(runs["code"])]
    for number, case in enumerate(cases, 1):
        blocks += _sections(case, str(number) if several else "")
    blocks.append(limits_and_machines(runs, environments_of(stored)))
    write_page(Page(title, about, blocks, "Lengths in metres, costs in seconds."), path)


def _sections(case: Case, number: str) -> list[Block]:
    scenario, n = case.scenario, case.paths.n_nodes
    size = (
        f"{scenario.name}: {scenario.n_tasks} tasks and {scenario.n_depots} depots, {n * (n - 1)} ordered pairs, "
        f"cost: {scenario.cost.described(scenario.speed)}."
    )
    wind = [] if scenario.wind is None else [draw_wind(scenario.wind, scenario.free)]
    compared = table_of(case.methods, shown(EXCESS, case.methods), key=f"methods{number}")
    of = f" of {scenario.name}" if number else ""
    found: list[Block] = [
        Section(f"Wind and paths{of}", [size, case.effect, Beside([*wind, draw_paths(scenario, case.paths)])],
                f"paths{number}"),
        Section(f"Methods{of}", [compared, draw_methods(case.methods)], f"compared{number}"),
    ]  # fmt: skip
    if len(case.scaling):
        scaled = table_of(case.scaling, shown(SCALING, case.scaling), key=f"scaling{number}")
        claim: list[Block] = [scaled, draw_claim(case.scaling)]
        found.append(Section("The paper's scaling claim", claim, f"claim{number}", "Scaling"))
    return found
