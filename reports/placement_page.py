"""One self-contained page about a placement study: methods against each other and against the certificate."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instances.disk import write_aside
from reports.figures.placement_convergence import draw_placement_convergence
from reports.figures.svg import Drawn, inline_svg
from reports.placement_store import placement_contradictions

RUN_COLUMNS = [
    "instance", "digest", "n_tasks", "method", "seed", "time_limit", "status", "mutual_information", "certificate",
    "ratio", "gap_found", "elapsed", "cpu_seconds", "peak_memory", "stopped_by", "message",
]  # fmt: skip


def placement_frame(runs: Sequence[dict[str, Any]]) -> pd.DataFrame:
    """Return a row a run: RUN_COLUMNS; gap_found is 1 − I / best I found on the same problem by any run."""
    rows = [
        {**run, "instance": run["instance"]["name"], "digest": run["instance"]["digest"], "method": run["label"],
         "n_tasks": run["instance"]["n_tasks"]}
        for run in runs
    ]  # fmt: skip
    frame = pd.DataFrame(rows, columns=[name for name in RUN_COLUMNS if name != "gap_found"])
    frame["mutual_information"] = frame["mutual_information"].astype(float)
    best = frame.groupby("digest")["mutual_information"].transform("max")
    frame["gap_found"] = 1 - frame["mutual_information"] / best
    return frame[RUN_COLUMNS]


def placement_summary(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a row a problem and method, best first: runs, failures, best and mean I, gaps, median times."""
    groups = frame.groupby(["instance", "method"], sort=False)
    table = groups.agg(
        runs=("seed", "size"),
        failed=("mutual_information", lambda column: int(column.isna().sum())),
        best=("mutual_information", "max"),
        mean=("mutual_information", "mean"),
        gap_found=("gap_found", "mean"),
        ratio=("ratio", "max"),
        elapsed=("elapsed", "median"),
        cpu_seconds=("cpu_seconds", "median"),
    ).reset_index()
    order = {name: k for k, name in enumerate(dict.fromkeys(frame["instance"]))}
    table["order"] = table["instance"].map(order)
    return table.sort_values(["order", "mean"], ascending=[True, False]).drop(columns="order").reset_index(drop=True)


def write_placement_page(runs: Sequence[dict[str, Any]], path: Path | None, title: str) -> pd.DataFrame:
    """Write the page about `runs` (from `read_placements`) to `path`, if given; return the frame it is made from."""
    frame = placement_frame(runs)
    if path is not None:
        write_aside(path, _page(runs, frame, title))
    return frame


def _page(runs: Sequence[dict[str, Any]], frame: pd.DataFrame, title: str) -> str:
    figures = [drawn for digest in dict.fromkeys(frame["digest"]) if (drawn := _convergence(runs, digest)) is not None]
    alarm = "".join(f"<p class='alarm'>{escape(words)}.</p>" for _, words in placement_contradictions(runs))
    css = resources.files("reports").joinpath("templates", "report.css").read_text(encoding="utf-8")
    body = "".join(
        f"<figure>{inline_svg(d)}<figcaption><b>{escape(d.title)}.</b> {escape(d.caption)}</figcaption></figure>"
        for d in figures
    )
    return (
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(title)}</title>"
        f"<meta name='viewport' content='width=device-width, initial-scale=1'><style>{css}</style></head><body><main>"
        f"<h1>{escape(title)}</h1><p>{len(frame)} runs of {frame['method'].nunique()} methods on "
        f"{frame['digest'].nunique()} problems. Before it was stored, every placement was checked to lie in its region "
        f"and its information recomputed outside the method.</p>{alarm}"
        f"<h2>Methods</h2>{_table(placement_summary(frame))}"
        f"<h2>Convergence</h2>{body}</main></body></html>\n"
    )


HEADINGS = {
    "instance": "Problem", "method": "Method", "runs": "Runs", "failed": "Failed", "best": "Best [nats]",
    "mean": "Mean [nats]", "gap_found": "Mean gap to best found", "ratio": "Best / certificate", "elapsed": "Time [s]",
    "cpu_seconds": "CPU [s]",
}  # fmt: skip


def summary_cells(table: pd.DataFrame) -> list[list[str]]:
    """Return `placement_summary` as text, row by row, in the order of HEADINGS."""
    writers = {
        "runs": "{:d}", "failed": "{:d}", "best": "{:.4f}", "mean": "{:.4f}", "gap_found": "{:.3%}", "ratio": "{:.2%}",
        "elapsed": "{:.3g}", "cpu_seconds": "{:.3g}",
    }  # fmt: skip
    return [
        [
            str(row[key]) if key not in writers else "–" if pd.isna(row[key]) else writers[key].format(row[key])
            for key in HEADINGS
        ]
        for row in table.to_dict("records")
    ]


def _table(table: pd.DataFrame) -> str:
    head = "".join(f"<th scope='col'>{escape(words)}</th>" for words in HEADINGS.values())
    rows = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>" for cells in summary_cells(table)
    )
    return f"<div class='scroll'><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"


def _convergence(runs: Sequence[dict[str, Any]], digest: str) -> Drawn | None:
    """Return the convergence of each method's median run (by final information) on one problem."""
    mine = [run for run in runs if run["instance"]["digest"] == digest and run["trace"]]
    traces: dict[str, list[tuple[float, float]]] = {}
    for label in dict.fromkeys(run["label"] for run in mine):
        ranked = sorted((run for run in mine if run["label"] == label), key=lambda run: run["mutual_information"])
        traces[label] = [(elapsed, -objective) for elapsed, objective, _ in ranked[(len(ranked) - 1) // 2]["trace"]]
    if not traces:
        return None
    name, bound = mine[0]["instance"]["name"], float(np.min([run["certificate"] for run in mine]))
    drawn = draw_placement_convergence(traces, bound, f"{name}, certificate {bound:.2f} nats")
    return (
        None if drawn is None else Drawn(f"convergence-{digest}", f"{drawn.title}, {name}", drawn.caption, drawn.figure)
    )
