"""The moving-cost methods compared on one scenario, and the paper's scaling claim measured on it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from formulations.moving_cost.costing import solve_query
from formulations.moving_cost.method import MovingCosts, Query
from instances.paths import check_paths

VARIANTS: tuple[tuple[str, dict[str, Any], str], ...] = (
    ("refined", {}, "default"),
    ("refined", {"samples": 10_000, "slack": 0.1, "candidates": 12}, "10 000 samples, 12 classes"),
    ("fmt-star", {"samples": 2_000}, "2 000 samples"),
    ("fmt-star", {"samples": 10_000}, "10 000"),
    ("fmt-star", {"samples": 10_000, "radius_factor": 2.0}, "10 000, twice the radius"),
    ("dijkstra", {"samples": 10_000}, "10 000"),
    ("dijkstra", {"samples": 10_000, "radius_factor": 2.0}, "10 000, twice the radius"),
)
"""Method, options, and what they are called in the report."""

Progress = Callable[[float, str], None]


def compare_methods(query: Query, progress: Progress) -> pd.DataFrame:
    """Return a row a variant: method, options, cpu [s], mean, p95 and largest excess over the best of all variants."""
    off = ~np.eye(len(query.terminals), dtype=bool)
    off &= np.hypot(*(query.terminals[:, None] - query.terminals[None]).transpose(2, 0, 1)) > 0
    costs, rows = [], []
    for k, (method, options, words) in enumerate(VARIANTS):
        progress(k / len(VARIANTS), f"comparing: {method} {words}")
        solve_query(query, method, options | {"samples": 500})  # compiles
        found, cpu = timed(query, method, options)
        costs.append(found.cost)
        rows.append({"method": method, "options": words, "cpu": cpu})
    best = np.min(costs, axis=0)
    tau = (best + best.T) / 2  # never negative, unlike the cost of a leg down a strong wind
    for row, cost in zip(rows, costs, strict=True):
        excess = ((cost - best)[off] / tau[off]) if off.any() else np.zeros(1)
        row |= {"mean": excess.mean(), "p95": float(np.quantile(excess, 0.95)), "largest": excess.max()}
    return pd.DataFrame(rows)


def measure_claim(query: Query, progress: Progress) -> pd.DataFrame:
    """Return CPU times [s] by number of starts: FMT* (3 000 samples) in the paper's three stages, and refined."""
    most = len(query.terminals)
    options = {"samples": 3_000}
    alone = timed(replace(query, terminals=query.terminals[:2]), "fmt-star", options | {"share": False})[1] / 2
    rows = []
    for n in sorted({max(2, most // 4), max(2, most // 2), most}):
        progress(n / most, f"scaling: {n} starts")
        part = replace(query, terminals=query.terminals[:n])
        rows.append(
            {
                "starts": n,
                "one query a pair": alone * n * (n - 1),
                "one tree a start": timed(part, "fmt-star", options | {"share": False})[1],
                "shared edges": timed(part, "fmt-star", options)[1],
                "refined": timed(part, "refined", {})[1],
            }
        )
    return pd.DataFrame(rows)


def timed(query: Query, method: str, options: dict[str, Any], repeats: int = 3) -> tuple[MovingCosts, float]:
    """Return a method's result, re-evaluated independently, and its least CPU time [s]; RuntimeError where refuted."""
    cpu = np.inf
    for _ in range(repeats):
        began = time.process_time()
        found = solve_query(query, method, options)
        cpu = min(cpu, time.process_time() - began)
    faults = check_paths(found.paths, found.cost, query.terminals, query.region, query.wind, query.v0)
    if faults:
        raise RuntimeError(f"the independent check refutes {method}: " + " ".join(faults))
    return found, cpu
