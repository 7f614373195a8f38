"""The page about a study of surveys: who wins, error against endurance, where they fly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from instances.arrays import Floats
from instances.environment.radio import RadioMap
from instances.environment.region import Region
from reports.columns import SURVEYS
from reports.figures.files import write_figures
from reports.figures.survey import FlownPlan, draw_endurance, draw_tours
from reports.numbers import counted
from reports.pages.blocks import Block, Facts, Folded, Lines, Section, figures_in, table_of
from reports.pages.made import code_notes, environments_of, limits_and_machines
from reports.pages.page import Page, write_page
from reports.surveys import Verdicts, survey_summary
from reports.verdicts import sentence


@dataclass(frozen=True, eq=False)
class SurveyCase:
    """One survey of the page and the plans flown over it."""

    name: str
    field: RadioMap
    region: Region
    depots: Floats
    plans: Sequence[FlownPlan]


WORDS = [
    ("RMSE", "root mean square error of the map: one Gaussian process, its kernel chosen by likelihood, fitted to "
     "every reading of the plan, in the same way for all plans"),
    ("reading", "every plan's readings carry the noise of (seed, UAV, number of the reading), so that plans differ by "
     "where they measure alone"),
    ("wins, loses, draws", "the reference's, from the paired differences of RMSE over the same fields: it wins where "
     "the whole 95 % interval is on its side of 0"),
]  # fmt: skip


def write_survey_page(
    cases: Sequence[SurveyCase],
    frame: pd.DataFrame,
    judged: Verdicts,
    stored: Iterable[Path],
    path: Path | None,
    title: str,
    figures: Path | None = None,
) -> None:
    """Write the page about `frame` (`survey_frame`) to `path`, if given; stored : the files of the runs.

    figures : folder for its figures as files (`write_figures`), None for none.
    """
    blocks = _blocks(cases, frame, judged, stored)
    if figures is not None:
        write_figures(figures_in(blocks), figures)
    if path is not None:
        about = (
            f"{counted(len(frame), 'run')} of {counted(frame['method'].nunique(), 'plan')} on "
            f"{counted(frame['digest'].nunique(), 'survey')}. Outside the planner, every tour was checked (from its "
            "depot and back, within endurance, inside the region, readings at the period), measured and mapped."
        )
        write_page(Page(title, about, blocks, "Lengths in kilometres, endurance in seconds."), path)


def _blocks(cases: Sequence[SurveyCase], frame: pd.DataFrame, judged: Verdicts, stored: Iterable[Path]) -> list[Block]:
    told, declined = _sentences(frame, judged), _declined(frame)
    plans = table_of(survey_summary(frame, judged), SURVEYS, key="plans", methods=frame["method"])
    drawn = [
        replace(draw_tours(case.name, case.field, case.region, case.depots, case.plans), key=f"tours{number}")
        for number, case in enumerate(cases, 1)
    ]
    seen = frame["rmse"].notna().any()
    return [
        *code_notes(frame["code"]),
        Section(
            "Who wins",
            [
                plans,
                *([Lines(declined)] if declined else []),
                *([Folded("The same in sentences", [Lines(told)])] if told else []),
            ],
            "plans",
        ),
        *([Section("Error against endurance", [draw_endurance(frame)], "endurance")] if seen else []),
        *([Section("Where they fly", list(drawn), "tours")] if drawn else []),
        Section("What the words mean", [Facts(WORDS)], "words"),
        limits_and_machines(frame, environments_of(stored)),
    ]


def _sentences(frame: pd.DataFrame, judged: Verdicts) -> list[str]:
    """Return a sentence a verdict."""
    told = []
    for (family, endurance), verdicts in judged.items():
        rows = frame[(frame["family"] == family) & (frame["endurance"] == endurance)]
        over = f"{counted(rows['digest'].nunique(), 'field')} of {family} at {endurance:g} s"
        told += [sentence(verdict, str(rows["unit"].iloc[0]), over) for verdict in verdicts]
    return told


def _declined(frame: pd.DataFrame) -> list[str]:
    """Return a sentence a plan that does not take some surveys, and a reason."""
    declined = frame[frame["stopped_by"] == "declined"]
    told = []
    for (method, why), rows in declined.groupby(["method", "message"], sort=False):
        reach = " and ".join(f"{value:g} s" for value in sorted(rows["endurance"].unique()))
        told.append(f"{method} {why} ({counted(rows['digest'].nunique(), 'survey')}, {reach}).")
    return told
