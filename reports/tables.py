"""Tables: runs, summary and instances as CSV, LaTeX, Markdown and Parquet, their columns always in the same order."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from instances import InputError
from instances.disk import write_aside
from reports import numbers
from reports.metrics import instance_table, summary, with_gaps

RUN_COLUMNS = [
    "instance", "digest", "family", "n_tasks", "n_depots", "asymmetry", "solver", "method", "options", "proves",
    "seed", "time_limit", "threads", "iterations", "status", "objective", "bound", "gap", "value", "best_known",
    "best_found", "best_bound", "proved", "gap_known", "gap_found", "gap_bound", "stopped_by", "tolerance",
    "claimed_objective", "fault", "message", "elapsed", "prepare_elapsed", "wall_elapsed", "cpu_seconds",
    "peak_memory", "environment", "created",
]  # fmt: skip
"""Columns of ``results.csv``; those from `elapsed` on differ between two executions of the same runs."""


class Column(NamedTuple):
    """One column of a table for people: where it is found, what is above it, how its numbers are written."""

    key: str
    heading: str
    write: Callable[[Any], str]
    meaning: str


SUMMARY_COLUMNS = [
    Column("runs", "Runs", numbers.count, "stored runs of the method"),
    Column("solved", "Solved", numbers.share, "share of runs with routes whose re-computed cost is right"),
    Column("proved", "Proved", numbers.share, "share of runs that ended with a proof of optimality"),
    Column(
        "certified",
        "Certified",
        numbers.share,
        "share of runs whose routes the best bound of any method proves to be within 1 % of the optimum",
    ),
    Column("gap_known", "Gap to best known", numbers.gap, "mean over solved runs with a best known value"),
    Column("gap_found", "Gap to best found", numbers.gap, "mean over solved runs; best over all runs of this report"),
    Column("gap_bound", "Gap to best bound", numbers.gap, "mean over solved runs of instances with a bound"),
    Column("time", "Time [s]", numbers.seconds, "shifted geometric mean of the solve; runs without routes penalised"),
    Column(
        "proof_time",
        "Time to proof [s]",
        numbers.seconds,
        "shifted geometric mean until optimality was proved; runs without a proof penalised",
    ),
    Column(
        "target_time",
        "Time to 1\u00a0% [s]",
        numbers.seconds,
        "shifted geometric mean until the routes were within 1 % of the best; runs that never were penalised",
    ),
    Column(
        "primal_integral",
        "Primal integral",
        numbers.ratio,
        "mean over runs of the integral of the gap over the time limit, as a share of it: 0 perfect at once, 1 nothing",
    ),
    Column(
        "primal_dual_integral",
        "Primal-dual integral",
        numbers.ratio,
        "the same of the gap between a run's own routes and bound, for methods that give bounds",
    ),
    Column("memory", "Peak memory", numbers.memory, "greatest of a run's process"),
    Column("failed", "Failed", numbers.count, "runs that were killed or ended in error"),
]

INSTANCE_COLUMNS = [
    Column("family", "Family", str, "generator family or set"),
    Column("n_tasks", "n", numbers.count, "tasks"),
    Column("n_depots", "m", numbers.count, "UAVs"),
    Column("asymmetry", "Asymmetry", numbers.gap, "mean |c_ij − c_ji| / (c_ij + c_ji)"),
    Column("best_known", "Best known [s]", numbers.cost, "value stored with the instance"),
    Column("best_found", "Best found [s]", numbers.cost, "over all runs of this report"),
    Column("best_bound", "Best bound [s]", numbers.cost, "over all runs of this report"),
    Column("gap", "Gap left", numbers.gap, "(best found − best bound) / best found"),
    Column("best_method", "Found first by", str, "method that had the best routes soonest"),
]


def write_csv(runs: pd.DataFrame, path: Path | str) -> None:
    """Write a row a run; the same runs give the same file but for the columns from `elapsed` on."""
    write_aside(path, with_gaps(runs)[RUN_COLUMNS].to_csv(index=False, lineterminator="\n"))


def write_parquet(runs: pd.DataFrame, path: Path | str) -> None:
    """Write the columns of the CSV as Parquet; InputError where pyarrow is not installed."""
    if importlib.util.find_spec("pyarrow") is None:
        raise InputError(f"{path}: writing Parquet needs pyarrow, which is not installed (pip install pyarrow)")
    write_aside(path, with_gaps(runs)[RUN_COLUMNS].to_parquet(index=False))


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
        head = " & ".join(_tex(heading) for heading in headings)
        body = "\n".join(" & ".join(_tex(cell) for cell in row) + r" \\" for row in rows)
        parts.append(
            f"\\begin{{longtable}}{{l{'r' * (len(headings) - 1)}}}\n\\caption{{{_tex(title)}}}\\\\\n\\toprule\n"
            f"{head} \\\\\n\\midrule\n\\endhead\n\\bottomrule\n\\endfoot\n{body}\n\\end{{longtable}}"
        )
    write_aside(path, "\n\n".join(parts) + "\n")


def shown(columns: Sequence[Column], table: pd.DataFrame) -> list[Column]:
    """Return those of `columns` in which `table` has anything to show."""
    return [c for c in columns if table[c.key].notna().any() and not (c.key == "failed" and not table["failed"].any())]


def cells(columns: Sequence[Column], table: pd.DataFrame) -> list[list[str]]:
    """Return the texts of `table`, a list a row."""
    blank = [[numbers.NOTHING if value != value else c.write(value) for value in table[c.key]] for c in columns]
    return [list(row) for row in zip(*blank, strict=True)]


def _both(runs: pd.DataFrame) -> list[tuple[str, list[str], list[list[str]]]]:
    methods, instances = summary(runs), instance_table(runs)
    parts = []
    for title, first, names, columns, table in (
        ("Summary", "Method", methods.index, SUMMARY_COLUMNS, methods),
        ("Instances", "Instance", instances["instance"], INSTANCE_COLUMNS, instances),
    ):
        kept = shown(columns, table)
        rows = [[str(name), *row] for name, row in zip(names, cells(kept, table), strict=True)]
        parts.append((title, [first, *[c.heading for c in kept]], rows))
    return parts


def _pipes(row: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"


_TEX = {
    "\\": r"\textbackslash{}",
    "–": "--",
    "−": "$-$",
    "∞": r"$\infty$",
    "<": "$<$",
    ">": "$>$",
    "~": r"\textasciitilde{}",
}
_TEX |= {"\u00a0": "~"} | {character: f"\\{character}" for character in "&%$#_{}"} | {"^": r"\textasciicircum{}"}


def _tex(text: str) -> str:
    return "".join(_TEX.get(character, character) for character in text)
