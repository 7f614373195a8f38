"""The page about a placement study: methods against each other and against the certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reports.columns import PLACEMENTS
from reports.figures.files import write_figures
from reports.figures.placement import draw_placement_convergence
from reports.figures.style import styles
from reports.figures.svg import Drawn
from reports.pages.blocks import Beside, Block, Lines, Section, figures_in, table_of
from reports.pages.made import code_notes, environments_of, limits_and_machines
from reports.pages.page import Page, write_page
from reports.placement_store import placement_contradictions, worth_of

RUN_COLUMNS = [
    "instance", "digest", "n_tasks", "method", "seed", "time_limit", "status", "mutual_information", "certificate",
    "ratio", "gap_found", "elapsed", "cpu_seconds", "peak_memory", "stopped_by", "message", "code", "worth",
]  # fmt: skip


def placement_frame(runs: Sequence[dict[str, Any]]) -> pd.DataFrame:
    """Return a row a run: RUN_COLUMNS; worth [nats] is of what is maximised; gap_found is 1 − worth / best found.

    What is maximised is mutual information (b) unless the study says another criterion; the best found is that of any
    run on the same problem.
    """
    rows = [
        {**run, "instance": run["instance"]["name"], "digest": run["instance"]["digest"], "method": run["label"],
         "n_tasks": run["instance"]["n_tasks"], "worth": worth_of(run)}
        for run in runs
    ]  # fmt: skip
    frame = pd.DataFrame(rows, columns=[name for name in RUN_COLUMNS if name != "gap_found"])
    for name in ("worth", "mutual_information"):
        frame[name] = frame[name].astype(float)
    best = frame.groupby("digest")["worth"].transform("max")
    frame["gap_found"] = 1 - frame["worth"] / best
    return frame[RUN_COLUMNS]


def placement_summary(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a row a problem and method, best first: runs, failures, best and mean worth, gaps, median times."""
    groups = frame.groupby(["instance", "method"], sort=False)
    found = groups.agg(
        runs=("seed", "size"),
        failed=("worth", lambda column: int(column.isna().sum())),
        best=("worth", "max"),
        mean=("worth", "mean"),
        gap_found=("gap_found", "mean"),
        ratio=("ratio", "max"),
        elapsed=("elapsed", "median"),
        cpu_seconds=("cpu_seconds", "median"),
    ).reset_index()
    found["order"] = found["instance"].map({name: k for k, name in enumerate(frame["instance"].unique())})
    return found.sort_values(["order", "mean"], ascending=[True, False], ignore_index=True).drop(columns="order")


def write_placement_page(
    runs: Sequence[dict[str, Any]], frame: pd.DataFrame, path: Path | None, title: str, figures: Path | None = None
) -> None:
    """Write the page about `runs` (from `read_placements`), whose `placement_frame` is `frame`, to `path`, if given.

    figures : folder for its figures as files (`write_figures`), None for none.
    """
    blocks = _blocks(runs, frame)
    if figures is not None:
        write_figures(figures_in(blocks), figures)
    if path is not None:
        about = (
            f"{len(frame)} runs of {frame['method'].nunique()} methods on {frame['digest'].nunique()} problems. Before "
            "it was stored, every placement was checked to lie in its region and what it is worth recomputed outside "
            "the method: information or, under criterion j, ½ log of how far the weighted mean variance falls."
        )
        units = "Worth in nats, times in seconds."
        write_page(Page(title, about, blocks, units), path)


def _blocks(runs: Sequence[dict[str, Any]], frame: pd.DataFrame) -> list[Block]:
    figures = [drawn for digest in dict.fromkeys(frame["digest"]) if (drawn := _convergence(runs, digest)) is not None]
    false = [f"{words}." for _, words in placement_contradictions(runs)]
    stored = [Path(run["path"]) for run in runs]
    made = pd.DataFrame(runs, columns=["label", "time_limit", "threads", "created", "environment", "code", "revision"])
    methods = table_of(placement_summary(frame), PLACEMENTS, key="summary", methods=frame["method"])
    return [
        *([Section("Contradictions", [Lines(false)], "contradictions", tone="alarm")] if false else []),
        *code_notes(made["code"]),
        Section("Methods", [methods], "summary"),
        Section("Convergence", [Beside(figures)], "figures"),
        limits_and_machines(made.rename(columns={"label": "method"}), environments_of(stored)),
    ]


def _convergence(runs: Sequence[dict[str, Any]], digest: str) -> Drawn | None:
    """Return the convergence of each method's median run (by final worth) on one problem."""
    solved = [run for run in runs if worth_of(run) is not None]
    mine = [run for run in solved if run["instance"]["digest"] == digest and _traced(run)]
    traces: dict[str, list[tuple[float, float]]] = {}
    for label in dict.fromkeys(run["label"] for run in mine):
        ranked = sorted((run for run in mine if run["label"] == label), key=lambda run: run["objective"], reverse=True)
        traces[label] = _traced(ranked[(len(ranked) - 1) // 2])
    if not traces:
        return None
    name, bound = mine[0]["instance"]["name"], float(np.min([run["certificate"] for run in mine]))
    drawn = draw_placement_convergence(
        traces, bound, f"{name}, certificate {bound:.2f} nats", styles(run["label"] for run in runs)
    )
    return None if drawn is None else replace(drawn, key=f"convergence-{digest}", title=f"{drawn.title}, {name}")


def _traced(run: dict[str, Any]) -> list[tuple[float, float]]:
    """Return elapsed [s] and worth [nats] of each improvement."""
    return [(elapsed, -objective) for elapsed, objective, _ in run["trace"] if objective is not None]
