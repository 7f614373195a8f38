"""The page about moving costs: wind and paths of each scenario, the methods compared, the paper's scaling claim."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from instances.paths import Paths
from instances.scenario import Scenario
from reports.columns import EXCESS, SCALING, shown
from reports.figures.files import write_figures
from reports.figures.paths import draw_claim, draw_methods, draw_paths
from reports.figures.svg import Drawn
from reports.figures.wind import draw_wind
from reports.pages.blocks import Beside, Block, Section, figures_in, table_of
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
    cases: Sequence[Case],
    runs: pd.DataFrame,
    stored: Iterable[Path],
    path: Path | str | None,
    title: str,
    figures: Path | None = None,
) -> None:
    """Write the page about `cases` to `path`, if given; runs : `moving_cost_frame`; stored : the files of the runs.

    figures : folder for its figures as files (`write_figures`), None for none.
    """
    about = (
        f"{len(runs)} runs of {runs['method'].nunique()} methods on {len(cases)} scenarios. Every path of every method "
        "was re-evaluated outside the method: length, wind integral, collision."
    )
    several = len(cases) > 1
    blocks: list[Block] = [*code_notes(runs["code"])]
    for number, case in enumerate(cases, 1):
        blocks += _sections(case, str(number) if several else "")
    blocks.append(limits_and_machines(runs, environments_of(stored)))
    if path is not None:
        write_page(Page(title, about, blocks, "Lengths in metres, costs in seconds."), path)
    if figures is not None:
        write_figures(figures_in(blocks), figures)


def _sections(case: Case, number: str) -> list[Block]:
    scenario, n = case.scenario, case.paths.n_nodes
    size = (
        f"{scenario.name}: {scenario.n_tasks} tasks and {scenario.n_depots} depots, {n * (n - 1)} ordered pairs, "
        f"cost: {scenario.cost.described(scenario.speed)}."
    )
    wind = [] if scenario.wind is None else [_of(draw_wind(scenario.wind, scenario.free), number)]
    paths, methods = _of(draw_paths(scenario, case.paths), number), _of(draw_methods(case.methods), number)
    compared = table_of(case.methods, shown(EXCESS, case.methods), key=f"methods{number}")
    of = f" of {scenario.name}" if number else ""
    found: list[Block] = [
        Section(f"Wind and paths{of}", [size, case.effect, Beside([*wind, paths])],
                f"paths{number}"),
        Section(f"Methods{of}", [compared, methods], f"compared{number}"),
    ]  # fmt: skip
    if len(case.scaling):
        scaled = table_of(case.scaling, shown(SCALING, case.scaling), key=f"scaling{number}")
        claim: list[Block] = [scaled, _of(draw_claim(case.scaling), number)]
        found.append(Section("The paper's scaling claim", claim, f"claim{number}", "Scaling"))
    return found


def _of(drawn: Drawn, number: str) -> Drawn:
    """Return a figure under the name of its case."""
    return replace(drawn, key=f"{drawn.key}{number}")
