"""Stored placement runs, read and checked key by key: a folder of a store that holds a problem.json is theirs.

Nothing is computed here: whether points are inside and worth what is claimed is for `workbench check` to say.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from instances import InputError
from reports.runfile import SCHEMA, read_json

PROBLEM_FILE = "problem.json"
ROUNDING = 1e-9
"""Relative excess over a certificate that floating point may explain."""
_TEXTS = ("solver", "label", "status", "stopped_by", "message")
_NUMBERS = ("mutual_information", "certificate", "ratio", "elapsed", "cpu_seconds", "peak_memory", "time_limit")


@dataclass(frozen=True)
class PlacementStore:
    """What folders hold about task locations.

    runs : JSON values with the file's path as ``path``. problems : folder → JSON values, None where unreadable.
    warnings : a sentence for each file left alone. routing : whether there are instances of routing as well.
    """

    runs: list[dict[str, Any]]
    problems: dict[Path, dict[str, Any] | None]
    warnings: list[str]
    routing: bool


def read_placements(*folders: Path | str) -> PlacementStore:
    """Read every placement run below `folders`; of a run stored more than once the latest is kept.

    Raises InputError where a folder does not exist.
    """
    problems: dict[Path, dict[str, Any] | None] = {}
    runs: dict[tuple[object, ...], dict[str, Any]] = {}
    warnings: list[str] = []
    routing = False
    for folder, names in _folders(folders):
        routing |= bool({"instance.json", "instance.json.gz"} & set(names))
        if PROBLEM_FILE not in names:
            continue
        problems[folder] = _problem(folder / PROBLEM_FILE, warnings)
        for name in names:
            if name == PROBLEM_FILE or not name.endswith(".json"):
                continue
            try:
                run = placement_run(folder / name)
            except InputError as error:
                warnings.append(f"{folder / name}: {error}; left alone.")
                continue
            key = (run["instance"]["digest"], run["label"], run["seed"], run["time_limit"])
            if key not in runs or str(runs[key].get("created")) <= str(run.get("created")):
                runs[key] = run
    return PlacementStore(list(runs.values()), problems, warnings, routing)


def placement_run(path: Path) -> dict[str, Any]:
    """Return the run in `path`, its path added; InputError with a sentence, without the path, where it is none."""
    data = read_json(path)
    if not isinstance(data, dict) or data.get("problem") != "placement":
        raise InputError("is not a run of a placement study")
    if data.get("schema") != SCHEMA:
        raise InputError(f"has schema {data.get('schema')!r}; this version reads schema {SCHEMA}")
    about = data.get("instance")
    if not isinstance(about, dict) or not all(isinstance(about.get(key), str) for key in ("name", "digest")):
        raise InputError("does not say which problem it is a run on (instance.name, instance.digest)")
    for key in _TEXTS:
        if not isinstance(data.get(key), str):
            raise InputError(f"{key} must be a text, got {data.get(key)!r}")
    for key in _NUMBERS:
        value = data.get(key)
        if value is not None and not _is_number(value):
            raise InputError(f"{key} must be a number, got {value!r}")
    for key in ("certificate", "elapsed"):
        if data.get(key) is None:
            raise InputError(f"{key} is missing")
    if not isinstance(data.get("seed"), int):
        raise InputError(f"seed must be a whole number, got {data.get('seed')!r}")
    trace = data.get("trace")
    if not isinstance(trace, list) or not all(
        isinstance(event, list) and len(event) == 3 and _is_number(event[0]) and _is_number(event[1]) for event in trace
    ):
        raise InputError("trace must be a list of [elapsed, objective, bound]")
    return {**data, "instance": {"n_tasks": None, **about}, "path": str(path)}


def placement_contradictions(runs: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    """Return (path, sentence) for each run worth more than a certificate that any run states for the same problem."""
    lowest: dict[str, dict[str, Any]] = {}
    for run in runs:
        least = lowest.setdefault(run["instance"]["digest"], run)
        if run["certificate"] < least["certificate"]:
            lowest[run["instance"]["digest"]] = run
    found = []
    for run in runs:
        value, least = run["mutual_information"], lowest[run["instance"]["digest"]]
        if value is not None and value > least["certificate"] + ROUNDING * abs(least["certificate"]):
            whose = (
                "its own certificate"
                if run["certificate"] == least["certificate"]
                else f"the certificate stated by {least['label']}"
            )
            sentence = (
                f"{run['label']} seed {run['seed']} on {run['instance']['name']} is worth {value!r} nats, above "
                f"{whose}, {least['certificate']!r}: one of the two is wrong"
            )
            found.append((run["path"], sentence))
    return found


def _folders(roots: Sequence[Path | str]) -> Iterator[tuple[Path, list[str]]]:
    for root in roots:
        if not Path(root).is_dir():
            raise InputError(f"{root}: is not a folder of stored runs")
        for folder, subfolders, names in os.walk(root):
            subfolders[:] = sorted(name for name in subfolders if not name.startswith("."))
            yield Path(folder), sorted(name for name in names if not name.startswith("."))


def _problem(path: Path, warnings: list[str]) -> dict[str, Any] | None:
    try:
        data = read_json(path)
        if not isinstance(data, dict) or data.get("problem") != "placement":
            raise InputError("is not a placement problem")
    except InputError as error:
        warnings.append(f"{path}: {error}; left alone.")
        return None
    return data


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
