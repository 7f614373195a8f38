"""Payload: what the page's tables and panels show, as compact JSON, with a cap on what is embedded.

Every run has its row. Routes, trace, options and log are embedded while the budget lasts, first for the best run of
each method on each instance; the page says how many it holds.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instances import InputError
from instances.arrays import Floats
from instances.files import read_instance
from reports.figures.style import COLOURS, styles
from reports.figures.surroundings import surroundings
from reports.metrics import instance_table
from reports.record import STATUSES, read_run

DETAILS_BUDGET = 1_300_000
"""Characters of JSON spent on runs' details."""
MAPS_BUDGET = 300_000
"""Characters of JSON spent on coordinates."""
TRACE_POINTS = 80
LOG_TAIL = 1500
"""Characters of a run's log that are embedded, its end."""


def payload(runs: pd.DataFrame, instance_files: dict[str, Path]) -> dict[str, Any]:
    """Return the page's data for `runs` (with gaps) and the files of their instances."""
    table = instance_table(runs)
    methods = sorted(runs["method"].unique())
    number = {digest: i for i, digest in enumerate(table.index)}
    maps = dict(_maps(list(table.index), number, instance_files))
    walls = {i: found for i, (_, found) in maps.items() if found}
    details = dict(_details(runs))
    look = styles(methods)
    return {
        "methods": methods,
        "styles": [
            [look[m].colour, " ".join(map(str, look[m].dash[1])) if len(look[m].dash) == 2 else ""] for m in methods
        ],
        "colours": COLOURS,
        "statuses": STATUSES["routing"],
        "families": sorted(runs["family"].unique()),
        "instances": _instances(table, methods),
        "maps": {i: places for i, (places, _) in maps.items()},
        "walls": walls,
        "runs": _rows(runs, number, methods),
        "details": details,
    }


def embedded(data: dict[str, Any]) -> str:
    """Return `data` as JSON that may stand inside a ``<script>`` element."""
    return json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False).replace("</", "<\\/")


def _number(value: Any, digits: int = 7) -> Any:
    """Return a JSON number of few digits; null for what is missing, 1e999 being no JSON."""
    if value is None or value is pd.NA or not np.isfinite(value):
        return None
    short = float(f"{float(value):.{digits}g}")
    return int(short) if short == int(short) and abs(short) < 1e15 else short


def _instances(table: pd.DataFrame, methods: list[str]) -> list[list[Any]]:
    numeric = ["n_tasks", "n_depots", "asymmetry", "best_known", "best_found", "best_bound", "gap"]
    rows = []
    for digest, row in table.iterrows():
        best = methods.index(row["best_method"]) if isinstance(row["best_method"], str) else None
        rows.append(
            [row["instance"], digest, row["family"], *[_number(row[c]) for c in numeric], bool(row["proved"]), best]
        )
    return rows


def _rows(runs: pd.DataFrame, number: dict[Any, int], methods: list[str]) -> dict[str, list[Any]]:
    """Return the runs column by column; the page's JavaScript names the same keys."""
    method_number = {method: i for i, method in enumerate(methods)}
    return {
        "instance": [number[d] for d in runs["digest"]],
        "method": [method_number[m] for m in runs["method"]],
        "seed": runs["seed"].tolist(),
        "status": [STATUSES["routing"].index(s) for s in runs["status"]],
        "value": [_number(v) for v in runs["value"]],
        "bound": [_number(v) for v in runs["bound"]],
        "found": [_number(v, 4) for v in runs["gap_found"]],
        "gap": [_number(v, 4) for v in runs["gap_bound"]],
        "elapsed": [_number(v, 4) for v in runs["elapsed"]],
        "limit": [_number(v) for v in runs["time_limit"]],
        "stopped": runs["stopped_by"].tolist(),
        "memory": [_number(v, 3) for v in runs["peak_memory"]],
    }


def _maps(
    digests: list[Any], number: dict[Any, int], files: dict[str, Path]
) -> Iterator[tuple[int, tuple[list[Any], list[Any]]]]:
    """Yield an instance's number, its coordinates [m] and the rings of its region, while the budget lasts."""
    spent = 0
    for digest in digests:
        if digest not in files or spent > MAPS_BUDGET:
            continue
        try:
            instance = read_instance(files[digest])
        except InputError:
            continue
        if instance.coordinates is not None:
            region, _ = surroundings(instance)
            places, *rings = (
                [[_number(x, 5), _number(y, 5)] for x, y in points]
                for points in (instance.coordinates, *(region.rings if region is not None else []))
            )
            spent += 12 * (len(places) + sum(map(len, rings)))
            if spent <= MAPS_BUDGET:
                yield number[digest], (places, rings)


def _details(runs: pd.DataFrame) -> Iterator[tuple[int, dict[str, Any]]]:
    spent = 0
    tours, traces = runs["tour_costs"].tolist(), runs["trace"].tolist()
    for index in _by_interest(runs):
        try:
            run = read_run(Path(str(runs.at[index, "path"])))
        except InputError:
            continue
        detail = {
            "routes": run.own["routes"],
            "tours": [_number(c, 6) for c in tours[index]],
            "trace": [[_number(t, 4), _number(z), _number(b)] for t, z, b in _thinned(traces[index])],
            "options": run.options,
            "message": run.message,
            "statistics": run.statistics,
            "log": run.log[-LOG_TAIL:],
            "file": f"{Path(str(runs.at[index, 'path'])).parent.name}/{Path(str(runs.at[index, 'path'])).name}",
            "times": [_number(getattr(run, k), 4) for k in ("prepare_elapsed", "wall_elapsed", "cpu_seconds")],
        }
        spent += len(json.dumps(detail, separators=(",", ":"), ensure_ascii=False))
        if spent > DETAILS_BUDGET:
            return
        yield index, detail


def _by_interest(runs: pd.DataFrame) -> list[int]:
    """Return the runs' numbers: failed ones first, then the best of each method on each instance, then the rest."""
    order = runs.assign(_fine=~runs["status"].isin(["ERROR", "KILLED"]), _value=runs["value"].fillna(np.inf))
    order = order.sort_values(["_value", "elapsed"], kind="stable")
    order["_turn"] = order.groupby(["digest", "method"]).cumcount()
    return [int(i) for i in order.sort_values(["_fine", "_turn"], kind="stable").index]


def _thinned(trace: Floats) -> Floats:
    """Return at most `TRACE_POINTS` of the trace's points: first, last, and evenly between."""
    if len(trace) <= TRACE_POINTS:
        return trace
    kept: Floats = trace[np.unique(np.linspace(0, len(trace) - 1, TRACE_POINTS).astype(int))]
    return kept
