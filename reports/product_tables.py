"""Tables among a mission's products: which columns must be numbers, and of what kind.

A table is checked as it is read: what is missing or no number is an InputError that names the file.
"""

from __future__ import annotations

import io
from pathlib import Path

import pandas as pd

from instances.disk import read_text
from instances.errors import InputError
from reports.damage import reading

_SCORES = ("rmse", "nlpd", "coverage", "mean_sd", "max_sd")
NUMBERS: dict[str, tuple[str, ...]] = {
    "tasks.csv": ("x", "y"),
    "reference.csv": ("uav", "x", "y"),
    "flown.csv": ("uav", "time", "x", "y", "z"),
    "flight-check.csv": (
        "uav", "length", "reference_length", "task_distance", "least_radius", "deviation", "closure", "in_no_fly",
        "outside", "margin", "clearance", "home", "lowest", "highest", "duration",
    ),
    "tours.csv": ("uav", "tasks", "length", "flight_time", "energy", "calm"),
    "samples.csv": ("time", "x", "y"),
    "ticks.csv": ("time", "samples", "information", *_SCORES),
    "compare.csv": ("draws", "count", "length", "longest", "outside", "samples", "information", *_SCORES),
    "compare-draws.csv": ("draw", "length", *_SCORES),
    "compare-ticks.csv": ("flown", *_SCORES),
    "tracks.csv": ("uav", "x", "y"),
    "calm.csv": ("longest", "total"),
    "calm-paths.csv": ("uav", "x", "y"),
    "unpolished.csv": ("uav", "x", "y"),
    "polished.csv": ("uav", "x", "y", "task"),
}  # fmt: skip
"""Table → its columns of numbers that are read."""
NAMED = ("compare.csv", "compare-draws.csv", "compare-ticks.csv", "tracks.csv")
"""Tables of several plans, whose `name` says which."""
UNKNOWN = ("energy",)
"""Columns that may be missing: in a wind that changes there is no energy."""
WHOLE = ("uav", "draw", "draws")
"""Columns of whole numbers from 0."""
ENDLESS = ("least_radius", "flight_time")
"""Columns that may be infinite: a UAV that stays home makes no turn; against a wind as strong there is no flight."""
LARGEST = 1e12
"""No product has a greater number; pictures of greater ones cannot be drawn."""


def read_table(path: Path) -> pd.DataFrame:
    """Return a CSV product as a frame, its `NUMBERS` being numbers."""
    with reading(path, "a table"):
        frame = pd.read_csv(io.StringIO(read_text(path)))
        for name in NUMBERS[path.name]:
            frame[name] = _numbers(frame[name], name)
        if path.name in NAMED:
            frame["name"] = frame["name"].astype(str)
        if frame.empty:
            raise InputError("has no rows")
        return frame


def _numbers(column: pd.Series, name: str) -> pd.Series:
    values = pd.to_numeric(column).astype(float)
    endless = values.eq(float("inf")) if name in ENDLESS else False
    unknown = values.isna() if name in UNKNOWN else False
    if not ((values.abs() <= LARGEST) | endless | unknown).all():
        raise InputError(f"column '{name}' must hold finite numbers up to {LARGEST:g}")
    if name not in WHOLE:
        return values
    if (values < 0).any() or (values % 1 != 0).any():
        raise InputError(f"column '{name}' must hold whole numbers from 0")
    return values.astype(int)
