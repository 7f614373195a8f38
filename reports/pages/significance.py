"""Significance section: ranks, pairs and intervals as the page shows them, and a plain word where data are too few."""

from __future__ import annotations

import pandas as pd

from reports import numbers
from reports.columns import Column
from reports.figures.ranks import critical_difference_diagram
from reports.figures.style import styles
from reports.figures.svg import Drawn
from reports.metrics import penalised, time_to_target
from reports.pages.blocks import Section, Table, table_of
from reports.statistics import ALPHA, blocks, bootstrap_interval, friedman, pairwise
from reports.statistics.friedman import Friedman
from reports.statistics.pairwise import enough

FEWEST_SEEDS = 3
"""With fewer seeds nothing is said about luck."""
MOST_METHODS = 8
"""With more methods than this, only these many, the best by mean rank, are compared pair by pair."""


def significance(runs: pd.DataFrame) -> Section:
    """Return the section about `runs` (with gaps): quality first, then time to within 1 % of the best."""
    lines, figures, tables = [_seeds(runs)], list[Drawn](), list[Table]()
    if runs["method"].nunique() < 2:
        lines.append("There is one method only, so there is nothing to compare.")
    else:
        methods = sorted(runs["method"].unique())
        target = penalised(time_to_target(runs, [0.01])[0.01], runs["time_limit"])
        quality, times = blocks(runs, "gap_best"), blocks(runs.assign(_target=target), "_target")
        for values, key, about in ((quality, "quality", "gap to the best"), (times, "time", "time to within 1 %")):
            ranked = _ranked(values, about, lines)
            figures += [critical_difference_diagram(test, styles(methods), f"ranks-{key}", about) for test in ranked]
            tables.append(_pairs(values, methods, key, about, lines))
            if key == "quality":
                tables.append(_intervals(values, methods))
    return Section("Is the difference real?", [*lines, *figures, *tables], "statistics", "Significance")


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


def _ranked(values: pd.DataFrame, about: str, lines: list[str]) -> list[Friedman]:
    """Return Friedman's test of `values` (instances × methods), none where they are too few; add what to say of it."""
    rare = values.notna().mean() < 0.5
    if rare.any():
        lines.append(
            f"Left out of the ranks by {about}, having run on fewer than half of the instances: "
            f"{', '.join(map(str, values.columns[rare]))}."
        )
    often = values.loc[:, ~rare]
    test = friedman(often)
    complete = int(often.notna().all(axis=1).sum())
    if test is None:
        if often.shape[1] > 2:
            lines.append(f"Too few instances ({complete}) that every method ran on to rank methods by {about}.")
        return []
    if test.p >= ALPHA:
        lines.append(
            f"By {about}, Friedman's test finds no difference between the methods as a whole (p = {test.p:.3f}); "
            "single pairs below should be read with that in mind."
        )
    if complete < 10:
        lines.append(
            f"The ranks by {about} rest on {complete} instances that every ranked method ran on; below about "
            "ten, Friedman's test and the critical difference are rough (Demšar 2006)."
        )
    return [test]


def _pairs(values: pd.DataFrame, methods: list[str], key: str, about: str, lines: list[str]) -> Table:
    """Return the table of pairs of methods; add to `lines` what limits it."""
    kept = values.rank(axis=1).mean().sort_values(kind="stable").index[:MOST_METHODS]
    if len(kept) < values.shape[1]:
        lines.append(f"By {about}, the {MOST_METHODS} best of {values.shape[1]} methods are compared in pairs.")
    pairs = pairwise(values[list(kept)])
    differing = int((pairs["wins"] + pairs["losses"]).max())
    if not enough(differing, len(pairs)):
        lines.append(
            f"By {about}, there are too few instances to conclude anything: with {len(pairs)} comparisons and at "
            f"most {differing} instances that differ, no p-value can be below {ALPHA:g} after Holm's correction."
        )
    write, unit = (numbers.gap, "") if key == "quality" else (numbers.signed_seconds, "s")
    rows = list(pairs.itertuples())
    shown = pairs.assign(
        record=[f"{row.wins} / {row.ties} / {row.losses}" for row in rows],
        interval=[numbers.interval(write, row.low, row.high) for row in rows],
    )
    columns = [
        Column("first", "First"), Column("second", "Second"), Column("record", "Wins / ties / losses"),
        Column("mean", "Mean difference", unit, write), Column("interval", "95 % interval", unit),
        Column("p", "p", "", numbers.p_value), Column("p_holm", "p (Holm)", "", numbers.p_value),
        Column("verdict", "Verdict"),
    ]  # fmt: skip
    caption = (
        f"Pairs by {about}: wins, ties and losses of the first method over instances; mean of first minus second "
        "over the instances both solved (negative: the first is better) with a bootstrap interval; Wilcoxon's "
        f"signed-rank test, two-sided, corrected over all pairs by Holm's method; level {ALPHA:g}."
    )
    return table_of(shown, columns, caption=caption, key=f"pairs-{key}", methods=methods)


def _intervals(values: pd.DataFrame, methods: list[str]) -> Table:
    rows = []
    for method in values.mean().sort_values(kind="stable").index:
        mine = values[method].dropna()
        solved = mine[mine < float("inf")]
        interval = numbers.interval(numbers.gap, *bootstrap_interval(solved))
        mean = solved.mean() if len(solved) else None
        rows.append((str(method), f"{len(solved)} of {len(mine)}", mean, interval))
    columns = [
        Column("method", "Method"), Column("solved", "Instances solved"),
        Column("mean", "Mean gap to the best", "", numbers.gap), Column("interval", "95 % interval"),
    ]  # fmt: skip
    caption = "Mean gap to the best over the instances a method solved, with a bootstrap interval over instances."
    frame = pd.DataFrame(rows, columns=[c.key for c in columns])
    return table_of(frame, columns, caption=caption, key="intervals", methods=methods)
