"""Payload: what the study page's panels show beyond its lists, as compact JSON, with a cap on what is embedded.

Every run has its row in the list. Routes, trace, options and log are embedded while the budget lasts, first for the
best run of each method on each instance; the page says how many it holds.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instances import InputError
from instances.arrays import Floats
from instances.errors import one_line
from instances.files import read_instance
from reports import numbers
from reports.columns import INSTANCES
from reports.figures.routes import surroundings, wind_inside
from reports.figures.style import COLOURS
from reports.pages.blocks import line_of
from reports.record import read_run

DETAILS_BUDGET = 1_300_000
"""Characters of JSON spent on runs' details at most."""
LEAST_DETAILS = 200_000
"""The same beside the longest lists."""
LISTED_BESIDE = 900_000
"""Characters of lists from which on the details have less, four for each, so that 10,000 runs fit into 4 MB."""
MAPS_BUDGET = 300_000
"""Characters of JSON spent on coordinates."""
TRACE_POINTS = 80
MOST_FIGURES = 200
"""Options, or figures of the method's own, that are told of a run."""
LONGEST_FIGURES = 4000
"""Characters of them."""
LOG_TAIL = 1500
"""Characters of a run's log that are embedded, its end."""


def payload(
    runs: pd.DataFrame, table: pd.DataFrame, instance_files: dict[str, Path], listed: int = 0
) -> dict[str, Any]:
    """Return what the lists of the page do not say of `runs` (with gaps), `table`'s instances and their files.

    Tables come column by column, a value a row of the list. listed : characters that the lists take.
    """
    methods = sorted(runs["method"].unique())
    number = {digest: i for i, digest in enumerate(table.index)}
    maps = _maps(list(table.index), number, instance_files)
    written = table.assign(proved=table["proved"].map(numbers.proved))
    return {
        "methods": methods,
        "styles": {method: line_of(method, methods) for method in methods},
        "colours": COLOURS,
        "instances": {c.key: _values(written[c.key]) for c in INSTANCES} | {"digest": list(table.index)},
        **maps,
        "runs": {
            "instance": [number[d] for d in runs["digest"]],
            "megabytes": [_number(value / 1e6, 3) for value in runs["peak_memory"].astype(float)],
        },
        "details": dict(_details(runs, _budget(listed))),
    }


def _budget(listed: int) -> int:
    """Return the characters that details may take beside lists of so many."""
    return min(DETAILS_BUDGET, max(LEAST_DETAILS, DETAILS_BUDGET - 4 * max(0, listed - LISTED_BESIDE)))


def _values(column: pd.Series) -> list[Any]:
    return [value if isinstance(value, str) else _number(value) for value in column]


def _number(value: Any, digits: int = 7) -> Any:
    """Return a JSON number of few digits; null for what is missing, 1e999 being no JSON."""
    if value is None or value is pd.NA or not np.isfinite(value):
        return None
    short = float(f"{float(value):.{digits}g}")
    return int(short) if short == int(short) and abs(short) < 1e15 else short


def _maps(digests: list[Any], number: dict[Any, int], files: dict[str, Path]) -> dict[str, dict[int, Any]]:
    """Return by an instance's number its coordinates [m], the rings of its region, its wind, while the budget lasts.

    A wind is arrows: x, y [m], and along both [m/s].
    """
    found: dict[str, dict[int, Any]] = {"maps": {}, "walls": {}, "winds": {}}
    spent = 0
    for digest in digests:
        if digest not in files or spent > MAPS_BUDGET:
            continue
        try:
            instance = read_instance(files[digest])
        except InputError:
            continue
        if instance.coordinates is None:
            continue
        region, wind = surroundings(instance)
        rings = region.rings if region is not None else []
        corners = np.vstack([instance.coordinates, *rings])
        arrows = np.hstack(wind_inside(wind, region, corners)) if wind is not None else np.empty((0, 4))
        spent += 12 * (len(corners) + 2 * len(arrows))
        if spent <= MAPS_BUDGET:
            i = number[digest]
            found["maps"][i] = _rows(instance.coordinates)
            if rings:
                found["walls"][i] = [_rows(ring) for ring in rings]
            if arrows.any():
                found["winds"][i] = _rows(arrows, 4)
    return found


def _rows(table: Floats, digits: int = 5) -> list[list[Any]]:
    return [[_number(value, digits) for value in row] for row in table]


def _details(runs: pd.DataFrame, budget: int) -> Iterator[tuple[int, dict[str, Any]]]:
    spent = 0
    tours, traces = runs["tour_costs"].tolist(), runs["trace"].tolist()
    ends = runs[["elapsed", "value", "bound"]].to_numpy(dtype=float)
    for index in _by_interest(runs):
        path = Path(str(runs.at[index, "path"]))
        try:
            run = read_run(path)
        except InputError:
            continue
        detail: dict[str, Any] = {
            "routes": run.own["routes"],
            "end": [_number(value) for value in ends[index][1:]],
            "tours": [_number(c, 6) for c in tours[index]],
            "trace": [[_number(t, 4), _number(z), _number(b)] for t, z, b in _whole(traces[index], ends[index])],
            "options": _told(run.options, " = "),
            "message": run.message,
            "statistics": _told(run.statistics, " "),
            "log": run.log[-LOG_TAIL:],
            "file": f"{path.parent.name}/{path.name}",
            "times": [_number(getattr(run, k), 4) for k in ("prepare_elapsed", "wall_elapsed", "cpu_seconds")],
        }
        size = len(json.dumps(detail, separators=(",", ":")))
        if size > budget // 4:  # one run alone leaves room for others
            continue
        spent += size
        if spent > budget:
            return
        yield index, detail


def _told(figures: dict[str, Any], between: str) -> str:
    """Return a table of a run as one line, cut where it is long."""
    first = list(islice(figures.items(), MOST_FIGURES))
    told = ", ".join(f"{key}{between}{json.dumps(value, ensure_ascii=False)}" for key, value in first)
    return one_line(told, LONGEST_FIGURES)


def _by_interest(runs: pd.DataFrame) -> list[int]:
    """Return the runs' numbers: failed ones first, then the best of each method on each instance, then the rest."""
    order = runs.assign(_fine=~runs["status"].isin(["ERROR", "KILLED"]), _value=runs["value"].fillna(np.inf))
    order = order.sort_values(["_value", "elapsed"], kind="stable")
    order["_turn"] = order.groupby(["digest", "method"]).cumcount()
    return [int(i) for i in order.sort_values(["_fine", "_turn"], kind="stable").index]


def _whole(trace: Floats, end: Floats) -> Floats:
    """Return the trace thinned, and the `end` of the run: elapsed, value, bound, where it had either of these."""
    kept = _thinned(trace)
    return kept if np.isnan(end[1:]).all() else np.vstack([kept, end])


def _thinned(trace: Floats) -> Floats:
    """Return at most `TRACE_POINTS` of the trace's points: first, last, and evenly between."""
    if len(trace) <= TRACE_POINTS:
        return trace
    kept: Floats = trace[np.unique(np.linspace(0, len(trace) - 1, TRACE_POINTS).astype(int))]
    return kept
