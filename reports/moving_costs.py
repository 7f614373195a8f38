"""Stored moving-cost runs as frames: each method's paths against the best of all methods, and CPU time by starts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instances.arrays import Floats
from reports.record import Run

FRAME = [
    "instance", "digest", "starts", "solver", "options", "method", "seed", "time_limit", "status", "mean_cost", "mean",
    "p95", "largest", "elapsed", "cpu_seconds", "peak_memory", "stopped_by", "message",
    "threads", "created", "environment", "code", "revision",
]  # fmt: skip
_EXCESS = {name: (name, "first") for name in ("mean", "p95", "largest")}


def moving_cost_frame(runs: Mapping[Path, Run]) -> pd.DataFrame:
    """Return a row a run: FRAME.

    mean_cost [s]; mean, p95, largest : excess over the best path of any run on the same scenario, as a share of the
    flight time there and back over two, which is never negative, unlike the cost of a leg down a strong wind.
    """
    best: dict[tuple[str, int], Floats] = {}
    for run in runs.values():
        if (cost := _cost(run)) is not None:
            key = run.instance["digest"], len(cost)
            best[key] = np.minimum(best[key], cost) if key in best else cost
    return pd.DataFrame([_row(run, best) for run in runs.values()], columns=FRAME)


def methods_table(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a row a method of one scenario: method, options, cpu [s] (the least), mean, p95, largest excess."""
    rows = frame.dropna(subset=["mean_cost"]).groupby(["solver", "method"], sort=False)
    table = rows.agg(options=("options", "first"), cpu=("cpu_seconds", "min"), **_EXCESS).reset_index()
    return table.assign(method=table["solver"])[["method", "options", "cpu", "mean", "p95", "largest"]]


def scaling_table(frame: pd.DataFrame) -> pd.DataFrame:
    """Return CPU times [s] by number of starts: FMT* in the paper's three stages, and refined.

    "one query a pair" is extrapolated from the trees of two starts alone. Empty where a stage was not run.
    """
    least = frame.dropna(subset=["mean_cost"]).groupby(["starts", "method"])["cpu_seconds"].min().unstack("method")
    alone = next((name for name in map(str, least) if name.startswith("fmt-star") and "share=false" in name), "")
    shared = alone.replace(", share=false", "").replace("share=false, ", "").replace(" (share=false)", "")
    if not {alone, shared, "refined"} <= set(least):
        return pd.DataFrame()
    n = least.index.to_numpy()
    pair = least[alone].iloc[0] / n[0]
    table = pd.DataFrame({"starts": n, "one query a pair": pair * n * (n - 1)})
    for stage, method in (("one tree a start", alone), ("shared edges", shared), ("refined", "refined")):
        table[stage] = least[method].to_numpy()
    return table[1:] if len(table) > 1 else table


def moving_cost_summary(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a row a scenario and method: runs, mean_cost [s], mean, p95, largest excess, cpu_seconds (the least)."""
    groups = frame.groupby(["instance", "method"], sort=False)
    first = {"mean_cost": ("mean_cost", "first"), **_EXCESS}
    return groups.agg(runs=("seed", "size"), **first, cpu_seconds=("cpu_seconds", "min")).reset_index()


def _row(run: Run, best: Mapping[tuple[str, int], Floats]) -> dict[str, Any]:
    cost, digest = _cost(run), run.instance["digest"]
    options = run.label.removeprefix(run.solver).strip(" ()") or "default"
    row: dict[str, Any] = {"instance": run.instance["name"], "digest": digest, "starts": run.instance["n_tasks"]}
    mean_cost = np.nan if cost is None or run.status == "ERROR" else run.objective
    row |= {"method": run.label, "options": options, "mean_cost": mean_cost}
    if cost is not None:
        least = best[digest, len(cost)]
        tau = (least + least.T) / 2
        counted = tau > 0
        excess = (cost - least)[counted] / tau[counted] if counted.any() else np.zeros(1)
        row |= {"mean": excess.mean(), "p95": float(np.quantile(excess, 0.95)), "largest": excess.max()}
    return {name: getattr(run, name, np.nan) for name in FRAME} | row


def _cost(run: Run) -> Floats | None:
    return None if run.own["cost"] is None else np.array(run.own["cost"], dtype=np.float64)
