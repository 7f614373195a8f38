"""Sections: what each part of the page says, as plain data for the template."""

from __future__ import annotations

from typing import Any

import pandas as pd

from reports import numbers
from reports.cells import cell, method_cell, number_cell
from reports.compare import Comparison
from reports.metrics import contributions, shifted_geometric_mean, summary, virtual_best
from reports.metrics.means import PENALTY, SHIFT
from reports.metrics.scores import GROUPINGS, banded, scores
from reports.stores import Stores
from reports.tables import SUMMARY_COLUMNS, Column, shown

LONGEST_MESSAGE = 240
MOST_FAILURES = 20
MOST_CHANGES = 40
"""Changed instances listed at most."""

BEST_IS_LEAST = {
    "gap_known",
    "gap_found",
    "gap_bound",
    "time",
    "proof_time",
    "target_time",
    "primal_integral",
    "primal_dual_integral",
}
BEST_IS_MOST = {"solved", "proved", "certified"}


def summary_table(runs: pd.DataFrame) -> dict[str, Any]:
    """Return the table of methods, the best of each column marked."""
    table = summary(runs)
    methods = [str(m) for m in table.index]
    columns = shown(SUMMARY_COLUMNS, table)
    rows = []
    for method, row in table.iterrows():
        marked = [number_cell(c.write, row[c.key], best=_is_best(c, row[c.key], table)) for c in columns]
        rows.append([method_cell(str(method), methods), *marked])
    caption = (
        f"One row a method over {numbers.counted(runs['digest'].nunique(), 'instance')} and "
        f"{numbers.counted(runs['seed'].nunique(), 'seed')}. Times are shifted geometric means (shift {SHIFT:g} s); "
        f"a run that failed counts {PENALTY:g} times its limit. The best of each column is shaded. What each column "
        "means is said at the end of the page."
    )
    headings = ["Method", *[c.heading for c in columns]]
    return {"key": "summary", "headings": headings, "texts": 1, "rows": rows, "caption": caption}


def summary_notes(runs: pd.DataFrame) -> list[str]:
    """Return what must be known to read the summary: whether its rows rest on the same runs, and the virtual best."""
    held = runs.groupby("method")["digest"].agg(frozenset)
    notes = []
    if held.nunique() > 1:
        counts = ", ".join(f"{method} {len(on)}" for method, on in held.items())
        notes.append(
            f"The methods did not run on the same instances ({counts}), so the rows above are means over different "
            "ones; the pairs below are compared on the instances both ran on."
        )
    return [*notes, virtual_best_line(runs)]


def virtual_best_line(runs: pd.DataFrame) -> str:
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


def _is_best(column: Column, value: float, table: pd.DataFrame) -> bool:
    if value != value or table[column.key].nunique(dropna=False) < 2:
        return False
    if column.key in BEST_IS_LEAST:
        return bool(value <= table[column.key].min())
    return column.key in BEST_IS_MOST and value > 0 and bool(value >= table[column.key].max())


def failure_table(runs: pd.DataFrame) -> dict[str, Any] | None:
    """Return the runs that were killed or ended in error, grouped by what they said; None where none did."""
    failed = runs[runs["status"].isin(["ERROR", "KILLED"])]
    if failed.empty:
        return None
    said = failed["message"].str.slice(0, LONGEST_MESSAGE)
    groups = sorted(failed.groupby(["method", "status", said]), key=lambda group: -len(group[1]))
    rows = [
        [cell(method), cell(status), number_cell(numbers.count, len(of)), cell(of["instance"].iloc[0]), cell(message)]
        for (method, status, message), of in groups[:MOST_FAILURES]
    ]
    headings = ["Method", "Status", "Runs", "For example on", "Message"]
    caption = (
        f"{len(groups) - len(rows)} more kinds of failure are in the list of runs." if len(groups) > len(rows) else ""
    )
    return {"key": "failures", "headings": headings, "texts": 2, "last_text": True, "rows": rows, "caption": caption}


def group_tables(runs: pd.DataFrame) -> list[dict[str, Any]]:
    """Return one table each by family, n, m and asymmetry: a column a method, mean gap to best found (share proved)."""
    grouped = banded(runs)
    methods = sorted(str(m) for m in runs["method"].unique())
    tables = []
    for key, title in GROUPINGS.items():
        if grouped[key].nunique() < 2:
            continue
        table = scores(grouped, [key])
        groups = list(dict.fromkeys(table.index.get_level_values(0).sort_values()))
        rows = []
        for group in groups:
            instances = int(runs[grouped[key] == group]["digest"].nunique())
            found = [_group_cell(table, group, method) for method in methods]
            best = min((c["sort"] for c in found if c["sort"] != ""), default=None)
            for c in found:
                c["best"] = best is not None and c["sort"] == best and len(methods) > 1
            rows.append([cell(str(group)), number_cell(numbers.count, instances), *found])
        tables.append(
            {"title": title, "headings": [title, "Instances", *methods], "texts": 1, "rows": rows, "caption": ""}
        )
    return tables


def _group_cell(table: pd.DataFrame, group: Any, method: str) -> dict[str, Any]:
    if (group, method) not in table.index:
        return number_cell(numbers.gap, None)
    row = table.loc[(group, method)]
    made = number_cell(numbers.gap, row["gap_found"])
    if row["proved"] > 0:
        made["text"] += f" ({numbers.share(row['proved'])})"
    return made


def against_section(comparison: Comparison) -> dict[str, Any]:
    """Return what became of each method against the baseline: regressions first, then tables."""
    lines = [f"Regression: {line}" for line in comparison.regressions] or ["No significant regression."]
    methods = [
        [
            cell(row.method),
            cell(row.measure),
            *[number_cell(numbers.count, value) for value in (row.instances, row.better, row.worse, row.unchanged)],
            number_cell(numbers.gap, row.change),
            cell(numbers.interval(numbers.gap, row.low, row.high)),
            number_cell(numbers.p_value, row.p_holm),
            cell(row.verdict),
        ]
        for row in comparison.methods.itertuples()
    ]
    headings = [
        "Method",
        "Measure",
        "Instances",
        "Better",
        "Worse",
        "Unchanged",
        "Mean change",
        "95 % interval",
        "p",
        "Verdict",
    ]
    caption = (
        "Medians over seeds, new against baseline; a negative change is an improvement. p from Wilcoxon's "
        "signed-rank test over instances, corrected by Holm's method."
    )
    tables = [
        {"key": "against", "headings": headings, "texts": 2, "last_text": True, "rows": methods, "caption": caption}
    ]
    changes = _changes_table(comparison.instances)
    tables += [changes] if changes else []
    return {"lines": [*lines, *comparison.remarks], "tables": tables}


def _changes_table(instances: pd.DataFrame) -> dict[str, Any] | None:
    """Return the instances whose cost changed, the largest changes first; None where none did."""
    changed = instances[instances["verdict"] != "unchanged"]
    changed = changed.reindex(changed["change"].abs().sort_values(ascending=False, kind="stable").index)
    rows = [
        [
            cell(row.instance),
            cell(row.method),
            *[number_cell(numbers.cost, value) for value in (row.baseline, row.new)],
            number_cell(numbers.gap, row.change),
            cell(row.verdict),
        ]
        for row in changed.head(MOST_CHANGES).itertuples()
    ]
    if not rows:
        return None
    headings = ["Instance", "Method", "Baseline [s]", "New [s]", "Change", "Verdict"]
    caption = f"The largest changes of cost ({len(rows)} of {len(changed)} that changed)."
    return {"key": "changes", "headings": headings, "texts": 2, "last_text": True, "rows": rows, "caption": caption}


def environment_section(runs: pd.DataFrame, stores: Stores) -> list[dict[str, Any]]:
    """Return limits and, for each machine the runs were made on, what it is and the versions."""
    limits = _limits(runs)
    threads = ", ".join(f"{count:g}" for count in sorted(runs["threads"].dropna().unique()))
    when = [text[:16].replace("T", " ") for text in (runs["created"].min(), runs["created"].max()) if text]
    rows = [("Time limit of a run", limits), ("Threads of a run", threads)]
    if when:
        rows.append(("Made", when[0] if when[0] == when[-1] else f"{when[0]} to {when[-1]} (UTC)"))
    parts = [{"title": "Limits", "rows": rows}]
    for digest, group in runs.groupby("environment", sort=True):
        about = stores.environments.get(str(digest), {})
        title = f"Machine of {len(group):,} runs" if runs["environment"].nunique() > 1 else "Machine and versions"
        found = [(str(k), _plain(v, str(k))) for part in ("machine", "versions") for k, v in _items(about.get(part))]
        parts.append(
            {"title": title, "rows": found or [("Machine", f"not stated in the store ({str(digest) or 'no digest'})")]}
        )
    return parts


def _limits(runs: pd.DataFrame) -> str:
    """Return the time limits, with the methods of each where there are several."""
    groups = [(limit, sorted(of["method"].unique())) for limit, of in runs.groupby("time_limit", sort=True)]
    if len(groups) == 1:
        return f"{float(str(groups[0][0])):g} s"
    return "; ".join(f"{float(str(limit)):g} s: {', '.join(methods)}" for limit, methods in groups)


def _items(part: Any) -> list[tuple[Any, Any]]:
    return list(part.items()) if isinstance(part, dict) else []


def _plain(value: Any, key: str) -> str:
    return numbers.memory(value) if key == "memory" and isinstance(value, (int, float)) else str(value)


def meanings() -> list[tuple[str, str]]:
    """Return what each column of the summary means."""
    return [(c.heading, c.meaning) for c in SUMMARY_COLUMNS]
