"""Tables: runs, summary and instances as CSV, LaTeX, Markdown and Parquet, their columns always in the same order."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

from instances import InputError
from instances.disk import write_aside
from reports.columns import INSTANCES, SUMMARY, shown, texts
from reports.metrics import instance_table, summary, with_gaps
from reports.record import ENSEMBLE
from reports.tex import tex

RUN_COLUMNS = [
    "instance", "digest", "family", "n_tasks", "n_depots", "asymmetry", "solver", "method", "options", "proves",
    "seed", "time_limit", "threads", "iterations", "status", "objective", "bound", "gap", "value", "best_known",
    "best_found", "best_bound", "bound_by", "proved", "gap_known", "gap_found", "gap_bound", "stopped_by", "tolerance",
    "claimed_objective", "fault", "message", "elapsed", "prepare_elapsed", "wall_elapsed", "cpu_seconds",
    "peak_memory", "environment", "created", "code", "revision", "stale", "foreign",
]  # fmt: skip
"""Columns of ``results.csv``; those from `elapsed` on differ between two executions of the same runs."""


def run_table(runs: pd.DataFrame) -> pd.DataFrame:
    """Return a row a run: RUN_COLUMNS; the same runs give the same rows but for the columns from `elapsed` on.

    Before these stand ENSEMBLE where an instance has an ensemble of forecasts.
    """
    at = RUN_COLUMNS.index("elapsed")
    more = ENSEMBLE if runs[[*ENSEMBLE]].notna().any(axis=None) else ()
    return with_gaps(runs)[[*RUN_COLUMNS[:at], *more, *RUN_COLUMNS[at:]]]


def write_parquet(runs: pd.DataFrame, path: Path | str) -> None:
    """Write the columns of the CSV as Parquet; InputError where pyarrow is not installed."""
    if importlib.util.find_spec("pyarrow") is None:
        raise InputError(f"{path}: writing Parquet needs pyarrow, which is not installed (pip install pyarrow)")
    write_aside(path, run_table(runs).to_parquet(index=False))


def write_markdown(runs: pd.DataFrame, path: Path | str) -> None:
    """Write summary and instances as Markdown tables."""
    parts = []
    for title, headings, rows in _both(runs):
        rule = ["---", *["---:" for _ in headings[1:]]]
        lines = [_pipes(headings), _pipes(rule), *[_pipes(row) for row in rows]]
        parts.append(f"## {title}\n\n" + "\n".join(lines) + "\n")
    write_aside(path, "\n".join(parts))


def write_latex(runs: pd.DataFrame, path: Path | str) -> None:
    """Write summary and instances as LaTeX tables (packages booktabs and longtable)."""
    parts = ["% needs \\usepackage{booktabs,longtable}"]
    for title, headings, rows in _both(runs):
        head = " & ".join(tex(heading) for heading in headings)
        body = "\n".join(" & ".join(tex(cell) for cell in row) + r" \\" for row in rows)
        parts.append(
            f"\\begin{{longtable}}{{l{'r' * (len(headings) - 1)}}}\n\\caption{{{tex(title)}}}\\\\\n\\toprule\n"
            f"{head} \\\\\n\\midrule\n\\endhead\n\\bottomrule\n\\endfoot\n{body}\n\\end{{longtable}}"
        )
    write_aside(path, "\n\n".join(parts) + "\n")


def _both(runs: pd.DataFrame) -> Iterator[tuple[str, list[str], list[list[str]]]]:
    for title, columns, table in (
        ("Summary", SUMMARY, summary(runs).reset_index()),
        ("Instances", INSTANCES, instance_table(runs)),
    ):
        kept = shown(columns, table)
        yield title, [c.heading for c in kept], texts(kept, table)


def _pipes(row: Sequence[str]) -> str:
    return "| " + " | ".join(_READ_BY_MARKDOWN.sub(r"\\\g<0>", cell) for cell in row) + " |"


_READ_BY_MARKDOWN = re.compile(r"[\\`*|~$&\[\]]|<(?! )|\b_|_\b")
"""What Markdown takes for more than text in the middle of a line."""
