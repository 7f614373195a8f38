"""`workbench check` of placement runs: every claim in a store recomputed from the points and the problem beside them.

The certificate is recomputed too: it is the claim that nothing better exists, and only its own argument can show it.
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from formulations.task_location.certificate import certificate
from formulations.task_location.criterion import Convention
from formulations.task_location.placement import PlacementProblem, PlacementStatus, checked_points
from instances.errors import InputError
from reports.placement_store import placement_contradictions, read_placements
from workbench.placement_jobs import Task
from workbench.placement_runner import TOLERANCE

LOOSER = 1e-3
"""Relative: a certificate lower by more than this than the recomputed one is not believed."""


def check_placements(folder: Path) -> tuple[str, list[str]]:
    """Return what placements were looked at ("" where none) and every problem found, a sentence each."""
    store = read_placements(folder)
    if not store.problems:
        return "", []
    problems = list(store.warnings)
    of_folder: dict[Path, list[dict[str, Any]]] = defaultdict(list)
    for run in store.runs:
        of_folder[Path(run["path"]).parent].append(run)
    for place, stated in store.problems.items():
        if stated is not None:
            problems += _check_folder(place, stated, of_folder[place])
    problems += [f"{path}: {sentence}" for path, sentence in placement_contradictions(store.runs)]
    return f"{len(store.runs)} placement runs on {len(store.problems)} problems", problems


def _check_folder(folder: Path, stated: dict[str, Any], runs: list[dict[str, Any]]) -> list[str]:
    """Check one problem, its certificate and its runs."""
    file = folder / "problem.json"
    try:
        task = Task(stated["name"], stated["polygon"], stated["setting"], stated["n_tasks"])
        bound = float(stated["certificate"]["bound"])
        problem = task.problem()
    except InputError as error:
        return [f"{file}: {error}"]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        return [f"{file}: does not describe a placement problem ({error!r})"]
    if folder.name != task.folder:
        return [f"{file}: is not the problem of its folder, it belongs into {task.folder}"]
    found = []
    actual = certificate(problem.criterion, problem.region, task.n_tasks).bound
    if not bound >= actual * (1 - LOOSER):
        found.append(f"{file}: states a certificate of {bound!r} nats, but recomputed it is {actual!r}")
    for run in runs:
        found += [f"{run['path']}: {sentence}" for sentence in _faults(run, task, problem, bound)]
    return found


def _faults(run: dict[str, Any], task: Task, problem: PlacementProblem, bound: float) -> list[str]:
    """Return what is wrong with one run, a sentence each."""
    found = []
    if run["instance"]["digest"] != task.digest or run["instance"]["n_tasks"] != task.n_tasks:
        found.append(f"is a run on another problem ({run['instance']['name']}, digest {run['instance']['digest']})")
    if run["status"] == "ERROR":
        return [*found, f"ERROR: {run['message']}"]
    if run["status"] not in ("KILLED", *PlacementStatus):
        found.append(f"claims to be {run['status']}, which no placement method can say")
    if not _close(run["certificate"], bound) or not _close(run.get("bound"), -bound):
        found.append(f"states a certificate of {run['certificate']!r} nats, but its problem's is {bound!r}")
    if run["mutual_information"] is None:
        return found if run.get("points") is None else [*found, "has points, but does not say what they are worth"]
    try:
        points = checked_points(problem, np.array(run.get("points"), dtype=float), run["label"])
        worth = {str(c): problem.criterion.under(c).value(points) for c in Convention}
    except (RuntimeError, TypeError, ValueError, np.linalg.LinAlgError) as error:
        return [*found, str(error)]
    value = worth[Convention.BOTH_NOISY]
    claims = {"mutual_information": run["mutual_information"], "minus objective": _negative(run.get("objective"))}
    claims |= {f"information ({name})": _entry(run.get("information"), name) for name in worth}
    actual = {"mutual_information": value, "minus objective": value}
    actual |= {f"information ({name})": number for name, number in worth.items()}
    found += [
        f"claims {what} = {claim!r} nats, but its points are worth {actual[what]!r}"
        for what, claim in claims.items()
        if not _close(claim, actual[what])
    ]
    highest = max((-event[1] for event in run["trace"]), default=value)
    if highest > value and not _close(highest, value):
        found.append(f"its trace claims {highest!r} nats, but its points are worth {value!r}")
    return found


def _entry(information: Any, name: str) -> Any:
    return information.get(name) if isinstance(information, dict) else None


def _negative(number: Any) -> Any:
    return -number if isinstance(number, (int, float)) else number


def _close(claim: Any, actual: float) -> bool:
    if not isinstance(claim, (int, float)) or isinstance(claim, bool):
        return False
    return bool(abs(claim - actual) <= TOLERANCE * abs(actual))
