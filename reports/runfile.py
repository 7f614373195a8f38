"""Run file: one stored run, read from JSON and checked key by key, so that a bad file is named and not half-used."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from instances import InputError
from instances.arrays import Floats

SCHEMA = 1
STATUSES = ("OPTIMAL", "FEASIBLE", "INFEASIBLE", "NO_SOLUTION", "KILLED", "ERROR")
"""The values of a run's status; what each means is said in `formulations.routing.solver.Status`."""

_NUMBERS = (
    "time_limit", "objective", "bound", "elapsed", "tolerance", "claimed_objective",
    "prepare_elapsed", "wall_elapsed", "cpu_seconds", "peak_memory", "iterations", "threads",
)  # fmt: skip
_TEXTS = ("stopped_by", "message", "log", "environment", "created")


def read_json(path: Path) -> Any:
    """Return the JSON value in `path`; InputError with a sentence, without the path, where there is none."""
    try:
        return json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError:
        raise InputError("is not text, so not a run") from None
    except json.JSONDecodeError as error:
        raise InputError(f"is not valid JSON (line {error.lineno}, column {error.colno}), perhaps cut short") from None
    except RecursionError:
        raise InputError("is JSON nested too deeply to be a run") from None


def read_run(path: Path) -> dict[str, Any]:
    """Return the run stored in `path` with every expected key present and of its type.

    Numbers that are null become NaN; `trace` becomes an array (k, 3) of elapsed, objective, bound [s];
    `routes` stays a list of lists or None. InputError with a sentence, without the path, where it is no run.
    """
    return checked_run(read_json(path))


def checked_run(data: Any) -> dict[str, Any]:
    """Return `data` as `read_run` does; InputError with a sentence where it is not a run of the routing problem."""
    if not isinstance(data, dict) or "schema" not in data or "solver" not in data:
        raise InputError("is JSON, but not a run of this workbench")
    if data["schema"] != SCHEMA:
        raise InputError(f"has schema {data['schema']!r}; this version reads schema {SCHEMA}")
    if data.get("problem", "routing") != "routing":
        raise InputError(f"is a run of another problem ({data['problem']!r}), not of routing")
    run = dict(data)
    run["instance"] = _instance(data.get("instance"))
    if not isinstance(data["solver"], str):
        raise InputError(f"solver must be a name, got {data['solver']!r}")
    if data.get("status") not in STATUSES:
        raise InputError(f"status must be one of {', '.join(STATUSES)}, got {data.get('status')!r}")
    if isinstance(data.get("seed"), bool) or not isinstance(data.get("seed"), int):
        raise InputError(f"seed must be a whole number, got {data.get('seed')!r}")
    for key in _NUMBERS:
        run[key] = _number(data.get(key), key)
    for key in _TEXTS:
        run[key] = _typed(data.get(key), str, key)
    run["label"] = _typed(data.get("label"), str, "label") or data["solver"]
    run["options"] = _typed(data.get("options"), dict, "options")
    run["statistics"] = _typed(data.get("statistics"), dict, "statistics")
    run["proves"] = bool(data.get("proves", False))
    run["routes"] = _routes(data.get("routes"))
    run["trace"] = _trace(data.get("trace"))
    return run


def _instance(data: Any) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise InputError("has no instance")
    for key in ("name", "digest"):
        if not isinstance(data.get(key), str):
            raise InputError(f"instance.{key} must be a text, got {data.get(key)!r}")
    found = dict(data)
    for key in ("n_tasks", "n_depots", "asymmetry", "best_known"):
        found[key] = _number(data.get(key), f"instance.{key}")
    found["family"] = _typed(data.get("family"), str, "instance.family")
    return found


def _number(value: Any, key: str) -> float:
    if value is None:
        return math.nan
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"{key} must be a finite number or null, got {value!r}")
    return float(value)


def _typed(value: Any, kind: type, key: str) -> Any:
    if value is None:
        return kind()
    if not isinstance(value, kind):
        raise InputError(f"{key} must be a {kind.__name__} or null, got {value!r:.60}")
    return value


def _routes(value: Any) -> list[list[int]] | None:
    if value is None:
        return None
    if not isinstance(value, list) or not all(isinstance(route, list) for route in value):
        raise InputError("routes must be a list of lists of tasks, or null")
    if not all(type(task) is int for route in value for task in route):
        raise InputError("routes must hold whole numbers")
    return value


def _trace(value: Any) -> Floats:
    if not value:
        return np.empty((0, 3))
    try:
        trace = np.array(value, dtype=np.float64)  # null becomes NaN
    except (TypeError, ValueError):
        trace = np.empty(0)
    if trace.ndim != 2 or trace.shape[1] != 3 or not np.isfinite(trace[:, 0]).all():
        raise InputError("trace must be a list of [elapsed, objective or null, bound or null]")
    return trace
