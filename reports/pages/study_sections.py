"""The sections of the study's page that are made of tables: alarms, methods, the baseline, groups."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pandas as pd

from instances.arrays import Bools
from reports import numbers
from reports.columns import SUMMARY, Column, least, shown
from reports.compare import Comparison
from reports.metrics import contributions, shifted_geometric_mean, summary, virtual_best
from reports.metrics.gaps import relative_gap
from reports.metrics.means import PENALTY, SHIFT
from reports.metrics.scores import GROUPINGS, banded, scores
from reports.pages.blocks import Block, Cell, Lines, Note, Section, Table, cell, table_of
from reports.record import ENSEMBLE

MOST_CONTRADICTIONS = 200
MOST_WARNINGS = 50
LONGEST_MESSAGE = 240
MOST_FAILURES = 20
GROUPED = Column("gap_found", "Gap to best found", "", numbers.gap, mark=least)
"""What the tables by group hold, a column a method."""
MOST_CHANGES = 40
"""Changed instances listed at most."""


def alarms(runs: pd.DataFrame, contradictions: pd.DataFrame, warnings: list[str]) -> list[Block]:
    """Return what must be known before anything is read: contradictions, failed runs, remarks on the store."""
    blocks: list[Block] = [_contradictions(runs, contradictions)]
    failed = runs[runs["status"].isin(["ERROR", "KILLED"])]
    if len(failed):
        blocks.append(Section(f"{numbers.counted(len(failed), 'run')} failed", [_failures(failed)], "failures",
                              tone="alarm"))  # fmt: skip
    if warnings:
        more = [f"… and {len(warnings) - MOST_WARNINGS} more."] if len(warnings) > MOST_WARNINGS else []
        title = f"{numbers.counted(len(warnings), 'remark')} on the store"
        blocks.append(Section(title, [Lines(warnings[:MOST_WARNINGS]), *more], "warnings", tone="alarm quiet"))
    return blocks


def _contradictions(runs: pd.DataFrame, found: pd.DataFrame) -> Block:
    if found.empty:
        costed, bounds = int(runs["recomputed"].notna().sum()), int(runs["bound"].notna().sum())
        said = f"{costed:,} sets of routes were costed again and {bounds:,} lower bounds held against them."
        return Note(f"No contradictions: {said}", "calm", "contradictions")
    columns = [
        Column("kind", "Kind"), Column("instance", "Instance"), Column("method", "Method"),
        Column("seed", "Seed", "", "{}".format), Column("sentence", "What is wrong"),
    ]  # fmt: skip
    first = found.head(MOST_CONTRADICTIONS)
    more = [f"The first {len(first)} are shown; workbench check lists all."] if len(found) > len(first) else []
    why = "These claims cannot all be true. Until they are explained, trust nothing below that rests on them."
    return Section(
        numbers.counted(len(found), "contradiction"), [why, table_of(first, columns), *more], "contradictions",
        tone="alarm",
    )  # fmt: skip


def _failures(failed: pd.DataFrame) -> Table:
    """Return the runs that were killed or ended in error, grouped by what they said."""
    said = failed.assign(message=failed["message"].str.slice(0, LONGEST_MESSAGE))
    kinds = said.groupby(["method", "status", "message"]).agg(runs=("seed", "size"), instance=("instance", "first"))
    kinds = kinds.sort_values("runs", ascending=False, kind="stable").reset_index()
    columns = [
        Column("method", "Method"), Column("status", "Status"), Column("runs", "Runs", "", numbers.count),
        Column("instance", "For example on"), Column("message", "Message"),
    ]  # fmt: skip
    more = len(kinds) - MOST_FAILURES
    caption = f"{more} more kinds of failure are in the list of runs." if more > 0 else ""
    return table_of(kinds.head(MOST_FAILURES), columns, caption=caption, key="failures")


def methods(runs: pd.DataFrame) -> Section:
    """Return the table of methods, the best of each column marked, and what must be known to read it."""
    found = summary(runs).reset_index()
    held = runs.groupby("method")["digest"].agg(frozenset)
    rivals, ranked = rivals_of(held[found["method"]]), held.nunique() == 1
    best = (
        "The best of each column is shaded."
        if ranked
        else "The best of each column is shaded among the methods that ran on every instance."
        if rivals.any()
        else "None is shaded, as no two methods ran on every instance."
    )
    caption = (
        f"One row a method over {numbers.counted(runs['digest'].nunique(), 'instance')} and "
        f"{numbers.counted(runs['seed'].nunique(), 'seed')}. Times are shifted geometric means (shift {SHIFT:g} s); "
        f"a run that failed counts {PENALTY:g} times its limit. {best}"
    )
    columns = shown(SUMMARY, found)
    shaded = table_of(found, columns, caption=caption, key="summary", methods=found["method"], rivals=rivals)
    notes = []
    if not ranked:
        counts = ", ".join(f"{method} {len(on)}" for method, on in held.items())
        notes.append(
            f"The methods did not run on the same instances ({counts}), so the rows above are means over different "
            "ones; the pairs below are compared on the instances both ran on."
        )
    return Section("Methods", [shaded, *notes, _virtual_best(runs)], "summary")


def rivals_of(held: Iterable[object]) -> Bools:
    """Return which methods can be compared: those that ran on all instances that any ran on, where there are several.

    held : the set of instances that each method ran on; empty or missing where it ran on none.
    """
    sets = [of if isinstance(of, frozenset) else frozenset() for of in held]
    everything = frozenset().union(*sets)
    found = np.array([of == everything for of in sets], dtype=bool)
    return found if found.sum() > 1 else np.zeros(len(found), dtype=bool)


def _virtual_best(runs: pd.DataFrame) -> str:
    """Return what the best method of each run, known beforehand, would reach, and which methods it would need."""
    best = virtual_best(runs)
    added = contributions(runs)
    alone = [f"{method} on {row.alone}" for method, row in added.iterrows() if row["alone"]]
    words = f"only these found the best: {', '.join(alone)}" if alone else "every best was found by several methods"
    return (
        f"The virtual best, which takes the best method for each instance, has a mean gap to the best of "
        f"{numbers.gap(best['gap_best'].mean())} in {numbers.seconds(shifted_geometric_mean(best['elapsed']))} s "
        f"(medians over seeds). Of {runs['digest'].nunique()} instances, {words}."
    )


CLOCKED = [
    Column("method", "Method"),
    Column("runs", "Runs", "", numbers.count, "with routes, on instances whose costs change with time"),
    Column("promised", "Promise off by", "", numbers.gap, "what the routes take, against what they would if costs "
           "stayed those of take-off"),
    Column("value", "Loss", "", numbers.gap, "what the routes take, against the best found by any method", least),
    Column("turned", "Loss in better directions", "", numbers.gap,
           "the same with each tour flown the way round that is home first; below 0 that is the best there is", least),
]  # fmt: skip
"""What the table of plans in costs that change holds: means over runs, a row a method."""


def by_clock(runs: pd.DataFrame) -> list[Section]:
    """Return what plans promise, take and lose where costs change with time; nothing where they do nowhere."""
    held = runs[runs["promised"].notna() & runs["value"].notna()]
    if held.empty:
        return []
    value, best = held["value"].to_numpy(float), held["best_found"].to_numpy(float)
    shares = pd.DataFrame({
        "method": held["method"].to_numpy(),
        "promised": relative_gap(value, held["promised"].to_numpy(float)),
        "value": relative_gap(value, best),
        "turned": relative_gap(held["turned"].to_numpy(float), best),
    })  # fmt: skip
    means = shares.groupby("method", sort=False)
    table = means.mean().assign(runs=means.size()).reset_index()
    note = (
        "Costs change with time on "
        f"{numbers.counted(held['digest'].nunique(), 'instance')}. A plan for the costs of take-off, as if they stayed "
        "(memetic with static = true makes one), promises something else than it takes. All was computed again from "
        "the stored routes; a tour that is turned round costs no search."
    )
    return [Section("Planning by the clock", [Note(note), table_of(table, CLOCKED, key="clocked")], "clocked")]


OVER_MEMBERS = [
    Column("method", "Method"),
    Column("runs", "Runs", "", numbers.count, "with routes, on instances that have an ensemble"),
    Column("ensemble_least", "Least", "", numbers.gap, "of the members, against the longest tour in the forecast "
           "planned with"),
    Column("ensemble_mean", "Mean", "", numbers.gap, "the same of the mean over members"),
    Column("ensemble_cvar", "CVaR", "", numbers.gap, "the same of the mean over the worst fifth of members"),
    Column("ensemble_worst", "Worst", "", numbers.gap, "the same of the member in which they take longest"),
    Column("loss", "Loss at worst", "", numbers.gap, "greatest makespan over members, against the least of these of "
           "any run on the instance", least),
]  # fmt: skip
"""What the table of routes over ensembles holds: means over runs, a row a method."""


def over_members(runs: pd.DataFrame) -> list[Section]:
    """Return what routes take over the members of ensembles of forecasts; nothing where no instance has one."""
    held = runs[runs["ensemble_worst"].notna() & runs["value"].notna()]
    if held.empty:
        return []
    shares = {name: relative_gap(held[name].to_numpy(float), held["value"].to_numpy(float)) for name in ENSEMBLE} | {
        "method": held["method"].to_numpy(),
        "loss": relative_gap(
            held["ensemble_worst"].to_numpy(float),
            held.groupby("digest")["ensemble_worst"].transform("min").to_numpy(float),
        ),
    }
    means = pd.DataFrame(shares).groupby("method", sort=False)
    table = means.mean().assign(runs=means.size()).reset_index()
    note = (
        f"On {numbers.counted(held['digest'].nunique(), 'instance')} the wind is an ensemble of forecasts. Routes were "
        "planned in one; here each stored set of routes was flown, along the same paths, in every member. Members "
        "count alike, and what is no member is not told of; seconds are in the list of runs."
    )
    return [Section("Over the members of an ensemble", [Note(note), table_of(table, OVER_MEMBERS)], "ensemble")]


def groups(runs: pd.DataFrame) -> Section:
    """Return one table each by family, n, m and asymmetry: a column a method, mean gap to best found (share proved)."""
    grouped = banded(runs)
    tables = [
        Section(title, [_by_group(grouped, key, title)])
        for key, title in GROUPINGS.items()
        if grouped[key].nunique() > 1
    ]
    note = Note(
        "Mean gap to the best found, and in brackets the share of runs proved. The best of a row is shaded among the "
        "methods that ran on all its instances."
        if tables
        else "All instances are of one family, one size and alike in asymmetry: there are no groups to compare."
    )
    return Section("Where each method is good", [note, *tables], "groups", "By group")


def _by_group(runs: pd.DataFrame, key: str, title: str) -> Table:
    found = scores(runs, [key])
    gaps, proved = found["gap_found"].unstack(), found["proved"].unstack()
    instances = runs.groupby(key, observed=True)["digest"].nunique()
    held = runs.groupby([key, "method"], observed=True)["digest"].agg(frozenset).unstack()
    sets = held.reindex(index=gaps.index, columns=gaps.columns).to_numpy()
    columns = [
        Column(key, title),
        Column("instances", "Instances", "", numbers.count),
        *(Column(str(method), str(method), "", numbers.gap) for method in gaps),
    ]
    rows = []
    counts = instances.reindex(gaps.index)
    for (group, of), shares, count, ran in zip(gaps.iterrows(), proved.to_numpy(), counts, sets, strict=True):
        made = [cell(column, gap) for column, gap in zip(columns[2:], of, strict=True)]
        rivals, marks = rivals_of(ran), np.full(len(of), "", dtype=object)
        marks[rivals] = GROUPED.marks(of[rivals])
        marked = [
            replace(one, text=f"{one.text} ({numbers.share(share)})" if share > 0 else one.text, mark=mark)
            for one, share, mark in zip(made, shares, marks, strict=True)
        ]
        rows.append([Cell(str(group)), cell(columns[1], count), *marked])
    return Table(columns, rows, key=f"by-{key}")


def against(comparison: Comparison) -> Section:
    """Return what became of each method against the baseline: regressions first, then tables."""
    lines = [f"Regression: {line}" for line in comparison.regressions] or ["No significant regression."] * bool(
        comparison.pairs
    )
    ends = [numbers.interval(numbers.gap, row.low, row.high) for row in comparison.methods.itertuples()]
    columns = [
        Column("method", "Method"), Column("measure", "Measure"), Column("instances", "Instances", "", numbers.count),
        Column("better", "Better", "", numbers.count), Column("worse", "Worse", "", numbers.count),
        Column("unchanged", "Unchanged", "", numbers.count), Column("change", "Mean change", "", numbers.gap),
        Column("interval", "95 % interval"), Column("p_holm", "p", "", numbers.p_value), Column("verdict", "Verdict"),
    ]  # fmt: skip
    caption = (
        "Medians over seeds, new against baseline; a negative change is an improvement. p from Wilcoxon's "
        "signed-rank test over instances, corrected by Holm's method."
    )
    tables = [table_of(comparison.methods.assign(interval=ends), columns, caption=caption, key="against")]
    changed = comparison.instances[comparison.instances["verdict"] != "unchanged"]
    if len(changed):
        tables.append(_changes(changed))
    return Section("Against the baseline", [*lines, *comparison.remarks, *tables], "against", "Baseline")


def _changes(changed: pd.DataFrame) -> Table:
    """Return the instances whose cost changed, the largest changes first."""
    ordered = changed.reindex(changed["change"].abs().sort_values(ascending=False, kind="stable").index)
    first = ordered.head(MOST_CHANGES)
    columns = [
        Column("instance", "Instance"), Column("method", "Method"),
        Column("baseline", "Baseline", "s", numbers.cost), Column("new", "New", "s", numbers.cost),
        Column("change", "Change", "", numbers.gap), Column("verdict", "Verdict"),
    ]  # fmt: skip
    caption = f"The largest changes of cost ({len(first)} of {len(changed)} that changed)."
    return table_of(first, columns, caption=caption, key="changes")
