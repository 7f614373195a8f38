"""Stores: folders of stored runs read into one tidy frame, a row a run, each claim re-computed on the way.

The cost of every run's routes is computed again from the instance stored beside it (paper, eqs. costsum and
c_max); `value` is that cost, and nothing where the claim is wrong. No later metric looks at a claim again.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instances import InputError, Instance, check_routes, tour_costs
from instances.files import read_instance
from reports.placement_store import PROBLEM_FILE
from reports.proofs import RELATIVE_ROUNDING, holds
from reports.runfile import read_json, read_run

COLUMNS: dict[str, str] = {
    "instance": "name of the instance (with digits of the digest where two share a name)",
    "digest": "digest of the instance",
    "family": "generator family or set",
    "n_tasks": "number of tasks n",
    "n_depots": "number of depots and UAVs m",
    "asymmetry": "mean |c_ij - c_ji| / (c_ij + c_ji), dimensionless",
    "best_known": "best known value [s] stored with the instance",
    "solver": "registered name of the solver",
    "method": "name in tables and figures: the label, cut short where long, and the limit where it has several",
    "label": "solver and its options where not default",
    "options": "options as JSON",
    "proves": "whether the method can prove optimality",
    "seed": "seed",
    "time_limit": "time limit [s]",
    "threads": "threads",
    "iterations": "limit on the method's iterations",
    "status": "OPTIMAL, FEASIBLE, INFEASIBLE, NO_SOLUTION, KILLED or ERROR",
    "objective": "C_max stored [s]",
    "bound": "lower bound [s]",
    "gap": "(objective - bound) / objective",
    "value": "C_max re-computed from the routes [s]; nothing where there are none or the claim is wrong",
    "proved": "whether the run proved its routes optimal, as far as the stored figures can tell (`reports.proofs`)",
    "elapsed": "wall clock of the solve [s]",
    "stopped_by": "what ended the run",
    "message": "one sentence",
    "tolerance": "tolerance of OPTIMAL [s]",
    "claimed_objective": "what the solver claimed [s]",
    "recomputed": "C_max of the stored routes [s], right or wrong",
    "fault": "what is wrong with the stored routes",
    "prepare_elapsed": "imports and compilation [s]",
    "wall_elapsed": "wall clock of the whole process [s]",
    "cpu_seconds": "processor time [s]",
    "peak_memory": "peak memory [bytes]",
    "environment": "digest of machine and versions",
    "created": "when",
    "tour_costs": "C_k re-computed [s], shape (m,)",
    "trace": "elapsed, objective, bound [s], shape (k, 3)",
    "statistics": "the method's own figures",
    "path": "the file",
}
"""Columns of the frame, in order, each with what it holds."""

_IDENTITY = ["digest", "solver", "options", "seed", "time_limit", "threads", "iterations"]
LONGEST_LABEL = 36
"""Longer names of methods do not fit into legends."""


@dataclass(frozen=True)
class Stores:
    """What the folders hold.

    runs : the frame (`COLUMNS`). warnings : a sentence for each file left alone. environments : digest → machine
    and versions. instance_files : digest → the instance's file. folders : the folders read.
    """

    runs: pd.DataFrame
    warnings: list[str]
    environments: dict[str, Any]
    instance_files: dict[str, Path]
    folders: list[Path]


def read_stores(*folders: Path | str) -> Stores:
    """Read every run below `folders`; InputError where a folder does not exist.

    A run that is in several stores counts once: the latest is kept.
    """
    rows: list[dict[str, Any]] = []
    warnings: list[str] = []
    environments: dict[str, Any] = {}
    instance_files: dict[str, Path] = {}
    roots = [Path(folder) for folder in folders]
    for root in roots:
        if not root.is_dir():
            raise InputError(f"{root}: is not a folder of stored runs")
        for folder, names in _folders(root):
            if folder.name == "environments":
                environments |= _environments(folder, names, warnings)
            elif PROBLEM_FILE not in names:  # else its runs are placements, read by reports.placement_store
                rows += _folder_runs(folder, names, instance_files, warnings)
    frame = _frame(rows, warnings)
    frame.attrs["warnings"] = warnings
    return Stores(frame, warnings, environments, instance_files, roots)


def _folders(root: Path) -> Iterator[tuple[Path, list[str]]]:
    for folder, subfolders, names in os.walk(root):
        subfolders[:] = sorted(name for name in subfolders if not name.startswith("."))
        yield Path(folder), sorted(name for name in names if name.endswith(".json") and not name.startswith("."))


def _environments(folder: Path, names: list[str], warnings: list[str]) -> dict[str, Any]:
    found = {}
    for name in names:
        try:
            data = read_json(folder / name)
            if not isinstance(data, dict):
                raise InputError("is not a description of machine and versions")
            found[Path(name).stem] = data
        except InputError as error:
            warnings.append(f"{folder / name}: {error}; left alone.")
    return found


def _folder_runs(
    folder: Path, names: list[str], instance_files: dict[str, Path], warnings: list[str]
) -> list[dict[str, Any]]:
    instance = _folder_instance(folder, warnings)
    if instance is not None:
        instance_files.setdefault(instance[0].digest, instance[1])
    rows = []
    for name in names:
        if name in ("instance.json", "study.json"):
            continue
        path = folder / name
        try:
            run = read_run(path)
        except InputError as error:
            warnings.append(f"{path}: {error}; left alone.")
            continue
        known = instance[0] if instance is not None and instance[0].digest == run["instance"]["digest"] else None
        if run["routes"] is not None and known is None:
            warnings.append(f"{path}: its instance is not stored beside it, so its cost could not be re-computed.")
        rows.append(_row(path, run, known))
    return rows


def _folder_instance(folder: Path, warnings: list[str]) -> tuple[Instance, Path] | None:
    for name in ("instance.json", "instance.json.gz"):
        path = folder / name
        if path.exists():
            try:
                return read_instance(path), path
            except InputError as error:
                warnings.append(f"{error}; the costs of the runs beside it could not be re-computed.")
    return None


def _row(path: Path, run: dict[str, Any], instance: Instance | None) -> dict[str, Any]:
    row = {key: run.get(key) for key in COLUMNS}
    about = run["instance"]
    row |= {key: about[key] for key in ("digest", "family", "n_tasks", "n_depots", "asymmetry", "best_known")}
    row |= {"instance": about["name"], "method": run["label"], "path": str(path)}
    row["options"] = json.dumps(run["options"], sort_keys=True)
    row |= _recomputed(run, instance)
    objective, bound = run["objective"], run["bound"]
    row["gap"] = (objective - bound) / objective if objective > 0 else (objective - bound)
    return row


def _recomputed(run: dict[str, Any], instance: Instance | None) -> dict[str, Any]:
    """Return value, recomputed, fault and tour costs of a run."""
    nothing = {"value": math.nan, "recomputed": math.nan, "fault": "", "tour_costs": np.empty(0)}
    if run["routes"] is None:
        return nothing
    if instance is None:
        trusted = run["objective"] if run["status"] in ("OPTIMAL", "FEASIBLE", "KILLED") else math.nan
        return nothing | {"value": trusted}
    faults = check_routes(instance, run["routes"])
    if faults:
        return nothing | {"fault": " ".join(faults[:3])}
    costs = tour_costs(instance, run["routes"])
    cost = float(costs.max())
    right = run["status"] != "ERROR" and math.isclose(cost, run["objective"], rel_tol=RELATIVE_ROUNDING)
    return {"value": cost if right else math.nan, "recomputed": cost, "fault": "", "tour_costs": costs}


def short_labels(labels: Iterable[str]) -> dict[str, str]:
    """Return for each label a name of at most about `LONGEST_LABEL` characters, different ones for different labels.

    "milp (a=1, b=2, c=3)" becomes "milp (a=1, 2 more)"; where that is not unique, a number is added.
    """
    named: dict[str, str] = {}
    for label in sorted(labels):
        short = label
        if len(label) > LONGEST_LABEL:
            first, *others = label.split(", ")
            short = f"{first}, {len(others)} more)" if others else f"{label[: LONGEST_LABEL - 1]}…"
        taken = sum(used == short or used.startswith(f"{short} #") for used in named.values())
        named[label] = f"{short} #{taken + 1}" if taken else short
    return named


def _frame(rows: list[dict[str, Any]], warnings: list[str]) -> pd.DataFrame:
    frame = pd.DataFrame(rows, columns=list(COLUMNS))
    if frame.empty:
        return frame
    for column in ("n_tasks", "n_depots"):
        frame[column] = frame[column].astype("Int64")
    order = ["instance", "digest", "solver", "options", "time_limit", "seed", "created", "path"]
    frame = frame.sort_values(order, kind="stable", ignore_index=True)
    twice = frame.duplicated(_IDENTITY, keep="last")
    if twice.any():
        warnings.append(f"{int(twice.sum())} runs are stored more than once; the latest of each is used.")
        frame = frame[~twice].reset_index(drop=True)
    frame["proved"] = holds(frame)
    digests = frame.groupby("instance")["digest"].transform("nunique")
    frame["instance"] = frame["instance"].where(digests == 1, frame["instance"] + "-" + frame["digest"].str[:4])
    limits = (
        frame.groupby(["digest", "label"])["time_limit"].transform("nunique").groupby(frame["label"]).transform("max")
    )
    name = frame["label"].map(short_labels(frame["label"].unique()))
    frame["method"] = name.where(limits <= 1, name + " @ " + frame["time_limit"].map("{:g} s".format))
    return frame
