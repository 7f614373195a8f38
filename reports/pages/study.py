"""The page about the runs of one or several stores: solvers of the routing problem, compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from instances import InputError
from reports import numbers
from reports.columns import INSTANCES, listed_runs, shown
from reports.compare import Comparison, compare_stores
from reports.example import example_routes
from reports.figures import study_figures
from reports.figures.files import write_figures
from reports.foreign import foreign_notes
from reports.metrics import contradictions, instance_table, with_gaps
from reports.pages.blocks import Beside, Block, Folded, Lines, Note, Section, column_help, figures_in
from reports.pages.listing import listing
from reports.pages.made import code_notes, limits_and_machines
from reports.pages.page import Page, write_page
from reports.pages.payload import payload
from reports.pages.significance import significance
from reports.pages.study_sections import against, alarms, by_clock, groups, methods, over_members
from reports.stores import Stores, read_stores

TITLE = "Solvers of the min-max multi-depot multiple TSP, compared"
UNITS = "Costs in seconds. Costs were computed again from the stored routes and instances; no solver grades itself."


@dataclass(frozen=True)
class Report:
    """What a page was made from: the stores, what contradicts itself in them, and the comparison if asked for."""

    stores: Stores
    contradictions: pd.DataFrame
    comparison: Comparison | None

    @property
    def runs(self) -> pd.DataFrame:
        """The frame of the runs."""
        return self.stores.runs

    @property
    def warnings(self) -> list[str]:
        """What was not as it should be in the stores, a sentence each."""
        return self.stores.warnings


def write_report(
    folders: Sequence[Path | str],
    path: Path | str | None,
    *,
    title: str = TITLE,
    against: Sequence[Path | str] = (),
    figures: Path | None = None,
) -> Report:
    """Write the page about every run below `folders` to `path`, compared with the runs below `against` if given.

    path : None writes no page. figures : folder for its figures as files (`write_figures`), None for none. Raises
    InputError where a folder does not exist or holds no run that can be read, or the page cannot be written.
    """
    baseline = _read(against) if against else None
    stores = _read(folders)
    comparison = compare_stores(stores.runs, baseline.runs) if baseline is not None else None
    report = Report(stores, contradictions(stores.runs), comparison)
    runs = with_gaps(stores.runs)
    instances = instance_table(runs)
    lists = (
        listing("instance-list", shown(INSTANCES, instances), instances),
        listing("run-list", listed_runs(runs), runs),
    )
    data = payload(runs, instances, stores.instance_files, sum(map(len, lists)))
    blocks = _blocks(runs, lists, report, len(data["details"]))
    if path is not None:
        write_page(Page(title, _about(runs, stores), blocks, UNITS, "study.js", data), path)
    if figures is not None:
        write_figures(figures_in(blocks), figures)
    return report


def _read(folders: Sequence[Path | str]) -> Stores:
    stores = read_stores(*folders)
    if stores.runs.empty:
        first = f" ({stores.warnings[0]})" if stores.warnings else ""
        raise InputError(f"{', '.join(map(str, stores.folders))}: holds no run that can be read{first}")
    return stores


def _blocks(runs: pd.DataFrame, lists: tuple[Block, Block], report: Report, embedded: int) -> list[Block]:
    of_instances, of_runs = lists
    opens = "A row opens the instance: its runs, its best routes, and how each method got there."
    example = example_routes(runs, report.stores.instance_files)
    return [
        *alarms(runs, report.contradictions, report.warnings),
        *code_notes(runs.loc[~runs["foreign"], "code"]),
        *_foreign(runs, report.stores.claims),
        methods(runs),
        *([against(report.comparison)] if report.comparison is not None else []),
        Section("Quality and time", [Beside(study_figures(runs))], "figures"),
        significance(runs),
        *by_clock(runs),
        *over_members(runs),
        groups(runs),
        Section("Instances", [Note(opens), of_instances, *column_help(INSTANCES), *example], "instances"),
        Section("Runs", [Note(_held(embedded, len(runs))), of_runs, *column_help(listed_runs(runs))], "runs"),
        limits_and_machines(runs, report.stores.environments),
    ]


def _foreign(runs: pd.DataFrame, claims: list[str]) -> list[Block]:
    """Return what must be known to read imported runs; nothing where there are none."""
    blocks: list[Block] = [Note(sentence) for sentence in foreign_notes(runs, claims)]
    return [*blocks, Folded("What others claim without routes", [Lines(claims)])] if claims else blocks


def _about(runs: pd.DataFrame, stores: Stores) -> str:
    counted = numbers.counted
    names = ", ".join(folder.resolve().name for folder in stores.folders)
    return (
        f"{counted(len(runs), 'run')} of {counted(runs['method'].nunique(), 'method')} on "
        f"{counted(runs['digest'].nunique(), 'instance')}, {counted(runs['seed'].nunique(), 'seed')}, from {names}."
    )


def _held(embedded: int, runs: int) -> str:
    held = (
        "Every run is held whole in this page."
        if embedded == runs
        else f"To stay small, this page holds routes, trace and log of {embedded:,} of {runs:,} runs: failed ones and "
        "the best of each method and instance first; the others are in the store."
    )
    return f"A row opens the run: routes, trace, options and log. {held}"
