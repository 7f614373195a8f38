"""Significance section: ranks, pairs and intervals as the page shows them, and a plain word where data are too few."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from reports import numbers
from reports.cells import cell, method_cell, number_cell
from reports.figures.ranks import critical_difference_diagram
from reports.figures.style import styles
from reports.figures.svg import Drawn
from reports.metrics import penalised, time_to_target
from reports.statistics import ALPHA, blocks, bootstrap_interval, friedman, pairwise
from reports.statistics.pairwise import enough

FEWEST_SEEDS = 3
"""With fewer seeds nothing is said about luck."""
MOST_METHODS = 8
"""With more methods than this, only these many, the best by mean rank, are compared pair by pair."""


@dataclass
class Significance:
    """What the section says: sentences, figures with captions, tables."""

    lines: list[str] = field(default_factory=list)
    figures: list[Drawn] = field(default_factory=list)
    tables: list[dict[str, Any]] = field(default_factory=list)


def significance(runs: pd.DataFrame) -> Significance:
    """Return the section about `runs` (with gaps): quality first, then time to within 1 % of the best."""
    section = Significance([_seeds(runs)])
    if runs["method"].nunique() < 2:
        section.lines.append("There is one method only, so there is nothing to compare.")
        return section
    target = penalised(time_to_target(runs, [0.01])[0.01], runs["time_limit"])
    measured = runs.assign(_target=target)
    for measure, key, about in (("gap_best", "quality", "gap to the best"), ("_target", "time", "time to within 1 %")):
        _measure(section, measured, measure, key, about)
    return section


def _measure(section: Significance, runs: pd.DataFrame, measure: str, key: str, about: str) -> None:
    table = blocks(runs, measure)
    rare = table.notna().mean() < 0.5
    if rare.any():
        section.lines.append(
            f"Left out of the ranks by {about}, having run on fewer than half of the instances: "
            f"{', '.join(map(str, table.columns[rare]))}."
        )
    often = table.loc[:, ~rare]
    test = friedman(often)
    complete = int(often.notna().all(axis=1).sum())
    if test is not None:
        section.figures.append(critical_difference_diagram(test, styles(runs["method"]), f"ranks-{key}", about))
        if test.p >= ALPHA:
            section.lines.append(
                f"By {about}, Friedman's test finds no difference between the methods as a whole (p = {test.p:.3f}); "
                "single pairs below should be read with that in mind."
            )
        if complete < 10:
            section.lines.append(
                f"The ranks by {about} rest on {complete} instances that every ranked method ran on; below about "
                "ten, Friedman's test and the critical difference are rough (Demšar 2006)."
            )
    elif often.shape[1] > 2:
        section.lines.append(f"Too few instances ({complete}) that every method ran on to rank methods by {about}.")
    kept = table.rank(axis=1).mean().sort_values(kind="stable").index[:MOST_METHODS]
    if len(kept) < table.shape[1]:
        section.lines.append(f"By {about}, the {MOST_METHODS} best of {table.shape[1]} methods are compared in pairs.")
    pairs = pairwise(table[list(kept)])
    differing = int((pairs["wins"] + pairs["losses"]).max())
    if not enough(differing, len(pairs)):
        section.lines.append(
            f"By {about}, there are too few instances to conclude anything: with {len(pairs)} comparisons and at "
            f"most {differing} instances that differ, no p-value can be below {ALPHA:g} after Holm's correction."
        )
    section.tables.append(_pairs_table(pairs, runs, key, about))
    if key == "quality":
        section.tables.append(_interval_table(table, runs))


def _seeds(runs: pd.DataFrame) -> str:
    seeds = runs.groupby(["digest", "method"])["seed"].nunique()
    searching = runs.loc[~runs["proves"]].groupby(["digest", "method"])["seed"].nunique()
    fewest = int((searching if len(searching) else seeds).min())
    instances = runs["digest"].nunique()
    said = f"The unit is the instance ({instances} here): medians over seeds are compared on the same instances."
    if fewest < FEWEST_SEEDS:
        said += (
            f" Some methods that search ran with {fewest} seed{'s' if fewest > 1 else ''} only: how much of a "
            "difference on one instance is luck cannot be told from that."
        )
    return said


def _pairs_table(pairs: pd.DataFrame, runs: pd.DataFrame, key: str, about: str) -> dict[str, Any]:
    methods = sorted(runs["method"].unique())
    write = numbers.gap if key == "quality" else numbers.signed_seconds
    rows = [
        [
            method_cell(str(row.first), methods),
            method_cell(str(row.second), methods),
            cell(f"{row.wins} / {row.ties} / {row.losses}", float(str(row.wins))),
            number_cell(write, row.mean),
            cell(numbers.interval(write, row.low, row.high)),
            number_cell(numbers.p_value, row.p),
            number_cell(numbers.p_value, row.p_holm),
            cell(row.verdict),
        ]
        for row in pairs.itertuples()
    ]
    unit = "" if key == "quality" else " [s]"
    headings = [
        "First",
        "Second",
        "Wins / ties / losses",
        f"Mean difference{unit}",
        "95 % interval",
        "p",
        "p (Holm)",
        "Verdict",
    ]
    caption = (
        f"Pairs by {about}: wins, ties and losses of the first method over instances; mean of first minus second "
        "over the instances both solved (negative: the first is better) with a bootstrap interval; Wilcoxon's "
        f"signed-rank test, two-sided, corrected over all pairs by Holm's method; level {ALPHA:g}."
    )
    return {
        "key": f"pairs-{key}",
        "headings": headings,
        "texts": 2,
        "last_text": True,
        "rows": rows,
        "caption": caption,
    }


def _interval_table(table: pd.DataFrame, runs: pd.DataFrame) -> dict[str, Any]:
    methods = sorted(runs["method"].unique())
    rows = []
    for method in table.mean().sort_values(kind="stable").index:
        values = table[method].dropna()
        solved = values[values < float("inf")]
        interval = numbers.interval(numbers.gap, *bootstrap_interval(solved))
        mean = number_cell(numbers.gap, solved.mean() if len(solved) else None)
        rows.append([method_cell(str(method), methods), cell(f"{len(solved)} of {len(values)}"), mean, cell(interval)])
    caption = "Mean gap to the best over the instances a method solved, with a bootstrap interval over instances."
    headings = ["Method", "Instances solved", "Mean gap to the best", "95 % interval"]
    return {"key": "intervals", "headings": headings, "texts": 1, "rows": rows, "caption": caption}
