"""Stored survey runs as frames: what the map of each plan is worth, and verdicts over fields and noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from reports.record import Run
from reports.verdicts import Verdict, difference, verdicts

OWN = (
    "rmse", "nlpd", "coverage", "promised_sd", "information", "length", "longest", "readings", "endurance",
    "model", "unit",
)  # fmt: skip
FRAME = [
    "instance", "digest", "family", "endurance", "unit", "solver", "method", "seed", "time_limit", "status", "rmse",
    "nlpd", "coverage", "promised_sd", "information", "length", "longest", "readings", "model", "elapsed",
    "cpu_seconds", "peak_memory", "stopped_by", "message", "threads", "created", "environment", "code", "revision",
]  # fmt: skip
REFERENCE = "workbench"
"""The plan that the others are paired with, where it was run."""
Verdicts = Mapping[tuple[str, float], Sequence[Verdict]]
"""Name of the fields and endurance [s] → the reference against each other plan."""


def survey_frame(runs: Mapping[Path, Run]) -> pd.DataFrame:
    """Return a row a run: FRAME. What a run that failed has not is missing."""
    rows = []
    for run in runs.values():
        about = {name: run.instance.get(name, "") for name in ("name", "digest", "family")}
        row = {"instance": about.pop("name"), **about, "method": run.label}
        own = {name: run.own[name] for name in OWN}
        if run.status == "ERROR":
            own |= dict.fromkeys(("rmse", "nlpd", "coverage"))
        rows.append({name: getattr(run, name, np.nan) for name in FRAME} | row | own)
    frame = pd.DataFrame(rows, columns=FRAME)
    return frame.astype(dict.fromkeys(OWN[:-2], float)).sort_values("instance", kind="stable", ignore_index=True)


def reference_plan(methods: Sequence[str]) -> str:
    """Return the plan that the others are paired with."""
    return REFERENCE if REFERENCE in methods else sorted(methods)[0]


def survey_verdicts(frame: pd.DataFrame) -> Verdicts:
    """Return the reference against the others, for each name of fields and endurance; seeds count by their median."""
    found: dict[tuple[str, float], Sequence[Verdict]] = {}
    solved = frame.dropna(subset=["rmse"])
    for (family, endurance), rows in solved.groupby(["family", "endurance"], sort=False):
        reference = reference_plan(list(rows["method"].unique()))
        draws = rows.groupby(["method", "digest"], sort=False)[["rmse", "nlpd", "length"]].median().reset_index()
        own = set(draws.loc[draws["method"] == reference, "digest"])
        draws = draws[draws["digest"].isin(own)].rename(columns={"method": "name", "digest": "draw"})
        found[str(family), float(str(endurance))] = verdicts(draws.assign(refused=""), reference)
    return found


def survey_summary(frame: pd.DataFrame, judged: Verdicts) -> pd.DataFrame:
    """Return a row a name of fields, endurance and plan, best first: means over runs, and the reference's verdict."""
    failed = frame["rmse"].isna() & (frame["stopped_by"] != "declined")
    groups = frame.assign(failed=failed).groupby(["family", "endurance", "method"], sort=False)
    means = {name: (name, "mean") for name in ("rmse", "nlpd", "coverage", "promised_sd", "information", "length")}
    table = groups.agg(
        runs=("seed", "size"),
        failed=("failed", "sum"),
        **means,
        longest=("longest", "max"),
        cpu_seconds=("cpu_seconds", "median"),
    ).reset_index()
    said = {(*key, verdict.name): verdict for key, verdicts in judged.items() for verdict in verdicts}
    keys = list(zip(table["family"], table["endurance"], table["method"], strict=True))
    table["more"] = [_more(said[key]) if key in said else "" for key in keys]
    table["verdict"] = [said[key].outcome if key in said else "" for key in keys]
    ruled = {(*key, verdict.by) for key, verdicts in judged.items() for verdict in verdicts}
    table.loc[[key in ruled for key in keys], "verdict"] = "reference"
    return table.sort_values(["family", "endurance", "rmse"], ignore_index=True)


def _more(verdict: Verdict) -> str:
    mean, low, high = difference(verdict.turned)
    return mean if verdict.rmse.pairs < 2 else f"{mean} ({low} to {high})"
