"""Stores: folders of stored runs read into one tidy frame, a row a run, each claim re-computed on the way.

The cost of every run's routes is computed again from the instance stored beside it (paper, eqs. costsum and
c_max); `value` is that cost, and nothing where the claim is wrong. No later metric looks at a claim again.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instances import InputError, Instance, as_routes, check_routes, makespan, take_offs, tour_costs
from instances.errors import one_line
from instances.files import read_instance
from instances.frozen import frozen, in_better_directions
from instances.natural import natural
from instances.utilisation import endurance_margins, utilisation
from reports.foreign import claim_without_routes, is_mere_claim
from reports.kinds import is_number
from reports.order import naturally
from reports.proofs import holds
from reports.record import ENSEMBLE, ENSEMBLE_FILE, ITEM_FILES, PART_FILES, RUN, Run, described, read_json, read_run
from reports.tolerances import RELATIVE_ROUNDING

FRAME = (
    "instance", "digest", "family", "n_tasks", "n_depots", "asymmetry", "restricted", "spacing", "best_known", "solver",
    "method", "label", "options", "proves", "seed", "time_limit", "threads", "iterations", "status", "objective",
    "bound", "gap", "value", "proved", "elapsed", "stopped_by", "message", "tolerance", "claimed_objective",
    "recomputed", "promised", "turned", *ENSEMBLE, "fault", "prepare_elapsed", "wall_elapsed", "cpu_seconds",
    "peak_memory", "environment",
    "code", "revision", "stale", "foreign", "created", "routes", "tour_costs", "utilisation", "endurance_margin",
    "trace", "statistics", "path",
)  # fmt: skip
"""Columns of the frame, in order; `COLUMNS` says what each holds."""
COLUMNS = described(*FRAME)
"""Column of the frame → its unit and meaning."""

_NUMBERS = [c.name for c in RUN if c.kind == "number"]
_IDENTITY = ["digest", "solver", "options", "seed", "time_limit", "threads", "iterations"]
LONGEST_LABEL = 36
"""Longer names of methods do not fit into legends."""


@dataclass(frozen=True)
class Stores:
    """What the folders hold.

    runs : the frame (`COLUMNS`). damaged : a sentence for each file that could not be read. remarks : what else a
    reader must know. environments : digest → machine and versions. instance_files : digest → the instance's file.
    folders : the folders read. claims : a sentence for each imported run with neither routes nor a bound, which is no
    evidence and not in the frame.
    """

    runs: pd.DataFrame
    damaged: list[str]
    remarks: list[str]
    environments: dict[str, Any]
    instance_files: dict[str, Path]
    folders: list[Path]
    claims: list[str] = field(default_factory=list)

    @property
    def warnings(self) -> list[str]:
        """Everything that was not as it should be, a sentence each."""
        return [*self.damaged, *self.remarks]


def read_stores(*folders: Path | str) -> Stores:
    """Read every routing run below `folders`; InputError where a folder does not exist.

    A run that is in several stores counts once: the latest is kept.
    """
    rows: list[dict[str, Any]] = []
    damaged: list[str] = []
    remarks: list[str] = []
    environments: dict[str, Any] = {}
    instance_files: dict[str, Path] = {}
    for folder, names, problem in walk(*folders):
        if folder.name == "environments":
            environments |= _environments(folder, names, damaged)
        elif problem == "routing":
            rows += _folder_runs(folder, names, instance_files, damaged, remarks)
    claims = [claim_without_routes(row) for row in rows if is_mere_claim(row)]
    frame = _frame([row for row in rows if not is_mere_claim(row)], remarks)
    stores = Stores(frame, damaged, remarks, environments, instance_files, [Path(folder) for folder in folders], claims)
    frame.attrs["warnings"] = stores.warnings
    return stores


def walk(*folders: Path | str) -> Iterator[tuple[Path, list[str], str]]:
    """Yield every folder below `folders` with the names of its files and the problem whose item it keeps.

    A folder that keeps no item is taken for one of routing whose instance is missing. InputError where one of
    `folders` does not exist.
    """
    for root in folders:
        if not Path(root).is_dir():
            raise InputError(f"{root}: is not a folder of stored runs")
        for folder, subfolders, found in os.walk(root):
            subfolders[:] = sorted((name for name in subfolders if not name.startswith(".")), key=natural)
            names = sorted((name for name in found if not name.startswith(".")), key=natural)
            problem = next((p for p, items in ITEM_FILES.items() if set(items) & set(names)), "routing")
            yield Path(folder), names, problem


def problems_in(*folders: Path | str) -> list[str]:
    """Return the problems of which `folders` keep an item, in the order of ITEM_FILES."""
    found = {problem for _, names, problem in walk(*folders) if set(ITEM_FILES[problem]) & set(names)}
    return [problem for problem in ITEM_FILES if problem in found]


def read_runs(*folders: Path | str, problem: str) -> tuple[dict[Path, Run], list[str]]:
    """Return every run of `problem` below `folders` by its file, and a sentence for each damaged file, left alone.

    Of a run stored more than once the latest is kept. InputError where a folder does not exist.
    """
    runs: dict[tuple[object, ...], tuple[Path, Run]] = {}
    damaged: list[str] = []
    for folder, names, of in walk(*folders):
        if of == problem and folder.name != "environments":
            for path, run in _runs_in(folder, names, problem, damaged):
                key = (run.instance["digest"], run.label, run.seed, run.time_limit)
                if key not in runs or runs[key][1].created <= run.created:
                    runs[key] = path, run
    return dict(runs.values()), damaged


def _runs_in(folder: Path, names: list[str], problem: str, damaged: list[str]) -> Iterator[tuple[Path, Run]]:
    others = {*ITEM_FILES[problem], *PART_FILES.get(problem, ()), "study.json"}
    for name in names:
        if not name.endswith(".json") or name in others:
            continue
        try:
            run = read_run(folder / name)
            if run.problem != problem:
                raise InputError(f"is a run of another problem ({run.problem}), not of {problem}")
            yield folder / name, run
        except InputError as error:
            damaged.append(f"{folder / name}: {error}; left alone.")


def _environments(folder: Path, names: list[str], damaged: list[str]) -> dict[str, Any]:
    found = {}
    for name in names:
        try:
            data = read_json(folder / name)
            if not isinstance(data, dict):
                raise InputError("is not a description of machine and versions")
            found[Path(name).stem] = data
        except InputError as error:
            damaged.append(f"{folder / name}: {error}; left alone.")
    return found


def _folder_runs(
    folder: Path, names: list[str], instance_files: dict[str, Path], damaged: list[str], remarks: list[str]
) -> list[dict[str, Any]]:
    instance = _folder_instance(folder, damaged)
    if instance is not None:
        instance_files.setdefault(instance[0].digest, instance[1])
    rows = []
    for path, run in _runs_in(folder, names, "routing", damaged):
        known = instance[0] if instance is not None and instance[0].digest == run.instance["digest"] else None
        if run.own["routes"] is not None and known is None:
            remarks.append(f"{path}: its instance is not stored beside it, so its cost could not be re-computed.")
        rows.append(_row(path, run, known))
    if rows and instance is not None and ENSEMBLE_FILE in names:
        from reports.ensembles import add_spreads  # here: few stores have any, and it compiles

        add_spreads(rows, folder, instance[0], damaged)
    return rows


def _folder_instance(folder: Path, damaged: list[str]) -> tuple[Instance, Path] | None:
    for name in ("instance.json", "instance.json.gz"):
        path = folder / name
        if path.exists():
            try:
                return read_instance(path), path
            except InputError as error:
                damaged.append(f"{error}; the costs of the runs beside it could not be re-computed.")
    return None


def _row(path: Path, run: Run, instance: Instance | None) -> dict[str, Any]:
    flat, about = run.flat(), run.instance
    row: dict[str, Any] = {key: flat.get(key) for key in FRAME}
    row |= {key: _number(flat[key]) for key in _NUMBERS}
    row |= {key: _number(about.get(key)) for key in ("n_tasks", "n_depots", "asymmetry", "best_known")}
    row |= {"instance": about["name"], "digest": about["digest"], "family": about.get("family") or ""}
    row |= {"method": run.label, "path": str(path), "stale": run.stale}
    row |= {"routes": run.own["routes"]}
    row |= {"restricted": instance is not None and instance.restricted, "spacing": _spacing(instance)}
    row |= {"options": json.dumps(run.options, sort_keys=True)}
    row["trace"] = np.array(run.trace, dtype=np.float64).reshape(-1, 3)  # null becomes NaN
    objective, bound = row["objective"], row["bound"]
    row["gap"] = (objective - bound) / objective if objective > 0 else (objective - bound)
    return row | _recomputed(run, instance)


def _spacing(instance: Instance | None) -> float:
    """Return the spacing ratio that the instance was generated with, not a number where there was none."""
    given = {} if instance is None else instance.provenance.get("parameters", {})
    said = given.get("spacing") if isinstance(given, Mapping) else None
    return float(said) if is_number(said) else math.nan


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)


def _recomputed(run: Run, instance: Instance | None) -> dict[str, Any]:
    """Return value, recomputed, fault and tour costs of a run, and how much of its fleet it uses."""
    unknown = ("value", "recomputed", "promised", "turned", *ENSEMBLE, "utilisation", "endurance_margin")
    nothing = dict.fromkeys(unknown, math.nan) | {"fault": "", "tour_costs": np.empty(0)}
    routes, objective = run.own["routes"], _number(run.objective)
    if routes is None:
        return nothing
    solved = run.status in ("OPTIMAL", "FEASIBLE", "KILLED")
    if instance is None:
        return nothing | {"value": objective if solved else math.nan}
    faults = check_routes(instance, routes)
    if faults:
        return nothing | {"fault": " ".join(faults[:3])}
    costs = tour_costs(instance, routes)
    cost = float(costs.max())
    right = solved and math.isclose(cost, objective, rel_tol=RELATIVE_ROUNDING)
    used = {"utilisation": float(utilisation(costs).mean())}
    if "time" in instance.axes:
        used["promised"] = makespan(frozen(instance), routes)
        used["turned"] = makespan(instance, in_better_directions(instance, as_routes(routes)))
    if instance.endurance is not None:
        used["endurance_margin"] = float(endurance_margins(instance, costs - take_offs(instance, routes)).min())
    return nothing | used | {"value": cost if right else math.nan, "recomputed": cost, "tour_costs": costs}


def short_labels(labels: Iterable[str]) -> dict[str, str]:
    """Return for each label a name of about `LONGEST_LABEL` characters at most, different ones for different labels.

    "milp (a=1, b=2, c=3)" becomes "milp (a=1, 2 more)"; where that is not unique, a number is added.
    """
    named: dict[str, str] = {}
    for label in sorted(labels):
        short = label
        if len(label) > LONGEST_LABEL:
            first, *others = label.split(", ")
            short = one_line(first, LONGEST_LABEL) + (f", {len(others)} more)" if others else "")
        taken = sum(used == short or used.startswith(f"{short} #") for used in named.values())
        named[label] = f"{short} #{taken + 1}" if taken else short
    return named


def _frame(rows: list[dict[str, Any]], remarks: list[str]) -> pd.DataFrame:
    frame = pd.DataFrame(rows, columns=list(FRAME))
    if frame.empty:
        return frame
    for column in ("n_tasks", "n_depots"):
        frame[column] = frame[column].astype("Int64")
    order = ["instance", "digest", "solver", "options", "time_limit", "seed", "created", "path"]
    frame = frame.sort_values(order, kind="stable", ignore_index=True, key=naturally)
    twice = frame.duplicated(_IDENTITY, keep="last")
    if twice.any():
        remarks.append(f"{int(twice.sum())} runs are stored more than once; the latest of each is used.")
        frame = frame[~twice].reset_index(drop=True)
    frame["proved"] = holds(frame)
    digests = frame.groupby("instance")["digest"].transform("nunique")
    frame["instance"] = frame["instance"].where(digests == 1, frame["instance"] + "-" + frame["digest"].str[:4])
    several = frame.groupby(["digest", "label"])["time_limit"].transform("nunique")
    limits = several.groupby(frame["label"]).transform("max")
    name = frame["label"].map(short_labels(frame["label"].unique()))
    frame["method"] = name.where(limits <= 1, name + " @ " + frame["time_limit"].map("{:g} s".format))
    return frame
