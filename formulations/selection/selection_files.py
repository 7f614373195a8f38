"""Files of selections: prizes in, a selection out, and the check of one from scratch.

Prizes are a CSV with columns ``task`` (numbers from 0) and ``prize``; a task that is not named scores 0. A selection is
the JSON object of `Selection.as_dict`. Nobody grades himself: `check_selection` believes none of its figures.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from formulations.routing.solver import Status
from formulations.selection.selection import TOLERANCE, Selection
from formulations.selection.worth import Worth, worth_of
from instances import InputError, Instance, as_routes, check_routes, tour_costs
from instances.arrays import Floats
from instances.disk import read_json, read_text, write_aside
from instances.errors import naming, shown

OWN_PRIZES = "prizes"
"""Key of an instance's provenance under which a file that has prizes keeps them."""
KEYS = ("digest", "endurance", "routes", "tasks", "tour_costs", "worth", "bound", "status", "about")
"""What the check of a selection reads."""
_SAME = 1e-6
"""Share by which a stored figure may differ from the one computed here: other machines sum otherwise."""


def read_prizes(path: Path, n_tasks: int) -> Floats:
    """Return the prizes (n,) in a CSV file; InputError names the line."""
    rows = csv.DictReader(io.StringIO(read_text(path), newline=""))
    prizes = np.zeros(n_tasks)
    with naming(path):
        if not {"task", "prize"} <= set(rows.fieldnames or ()):
            raise InputError("must have columns 'task' and 'prize'")
        seen = set()
        try:
            for row in rows:
                task, prize = _prize(row, rows.line_num, n_tasks)
                if task in seen:
                    raise InputError(f"line {rows.line_num}: task {task} is given twice")
                seen.add(task)
                prizes[task] = prize
        except csv.Error as error:
            raise InputError(f"line {rows.line_num}: {error}") from None
        return Worth.of_prizes(prizes).prizes


def own_prizes(instance: Instance) -> Any:
    """Return the prizes that an instance brought along, as they stand there, or None."""
    return instance.provenance.get(OWN_PRIZES)


def _prize(row: Mapping[str, Any], line: int, n_tasks: int) -> tuple[int, float]:
    word = str(row["task"]).strip()
    if not (word.isascii() and word.isdigit() and len(word) < 10 and int(word) < n_tasks):
        raise InputError(f"line {line}: task must be a number from 0 to {n_tasks - 1}, got {shown(row['task'])}")
    try:
        prize = float(row["prize"])
    except (TypeError, ValueError):
        prize = math.nan
    if not 0 <= prize < math.inf:
        raise InputError(f"line {line}: prize must be a number of at least 0, got {shown(row['prize'])}")
    return int(word), prize


def limited(instance: Instance, endurance: Floats) -> Instance:
    """Return the instance with an endurance (m,) [s], or less where its own UAVs fly less."""
    return replace(instance, endurance=np.minimum(instance.limits, endurance))


def write_selection(selection: Selection, path: Path) -> None:
    """Write everything as JSON."""
    write_aside(path, json.dumps(selection.as_dict()) + "\n")


def check_selection(path: Path, instance: Instance) -> tuple[str, list[str]]:
    """Return what was looked at, and what is wrong with the selection in a file, a sentence each.

    Looked at from scratch: that it is of this instance, tasks, legs, classes and endurance of every UAV, the worth of
    the tasks, and that bound and status do not contradict it. InputError where the file is no selection.
    """
    document = read_json(path)
    with naming(path):
        if not isinstance(document, dict) or not set(KEYS) <= set(document):
            raise InputError(f"is no selection: it must be an object with the keys {', '.join(KEYS)}")
        faults = _faults(document, instance)
    worth = document["worth"]
    return f"selection worth {worth!r}, {len(document['tasks'])} tasks", [f"{path}: {fault}" for fault in faults]


def _faults(document: Mapping[str, Any], instance: Instance) -> list[str]:
    digest = replace(instance, endurance=None).digest
    if document["digest"] != digest:
        return [f"is of another instance: digest without endurance {shown(document['digest'])}, not {digest}"]
    asked = _limits(document["endurance"], instance)
    if (asked > instance.limits).any():
        k = int(np.argmax(asked > instance.limits))
        return [f"endurance[{k}] is {asked[k]:.9g} s, more than the {instance.limits[k]:.9g} s of the instance"]
    try:
        routes = as_routes(document["routes"])
    except TypeError:
        raise InputError(f"routes must be lists of task numbers, got {shown(document['routes'])}") from None
    limited_ = limited(instance, asked)
    if faults := check_routes(limited_, routes, all_tasks=False):
        return faults
    tasks = sorted(task for route in routes for task in route)
    faults = [] if document["tasks"] == tasks else ["tasks are not those that the routes visit"]
    costs = tour_costs(limited_, routes)
    if not _close(document["tour_costs"], costs):
        faults.append(f"claimed tours of {shown(document['tour_costs'])} s, but they take {costs.tolist()} s")
    return faults + _wrong_worth(document, instance, tasks)


def _wrong_worth(document: Mapping[str, Any], instance: Instance, tasks: list[int]) -> list[str]:
    about = document["about"]
    if not isinstance(about, dict):
        raise InputError(f"about must be an object, got {shown(about)}")
    worth = worth_of(about, instance.n_tasks, instance.coordinates)
    own, faults = own_prizes(instance), []
    if own is not None and "prizes" in about and about["prizes"] != own:
        faults.append("its prizes are not those of the instance")
    actual, bound = worth.value(tasks), document["bound"]
    if not _close([document["worth"]], np.array([actual])):
        faults.append(f"claimed a worth of {shown(document['worth'])}, but its tasks are worth {actual!r}")
    if not isinstance(bound, (int, float)) or bound < actual * (1 - _SAME):
        faults.append(f"the bound {shown(bound)} is below the worth {actual!r}")
    elif document["status"] == Status.OPTIMAL and bound > actual * (1 + _SAME + TOLERANCE) + max(worth.step, _SAME):
        faults.append(f"claimed OPTIMAL, but the bound {bound!r} is above the worth {actual!r}")
    return faults


def _close(claimed: Any, actual: Floats) -> bool:
    try:
        numbers = np.array(claimed, dtype=float)
    except (TypeError, ValueError, OverflowError):
        return False
    return numbers.shape == actual.shape and bool(np.allclose(numbers, actual, rtol=_SAME, atol=_SAME))


def _limits(value: Any, instance: Instance) -> Floats:
    numbers = [math.inf if each is None else each for each in value] if isinstance(value, list) else []
    fit = all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in numbers)
    if len(numbers) != instance.n_depots or not fit:
        raise InputError(f"endurance must be {instance.n_depots} numbers [s] or null, got {shown(value)}")
    return np.array(numbers, dtype=float)
