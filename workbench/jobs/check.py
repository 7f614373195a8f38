"""Check: every stored run of a problem judged again from the item beside it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

from instances.errors import LONGEST_VALUE, InputError, one_line
from reports.record import ITEM_FILES, Run
from workbench.jobs.job import folder_of
from workbench.jobs.problem import Problem

MACHINERY = ("KILLED", "NO_SOLUTION")
"""Endings that the machinery adds to those of a problem; ERROR is told apart."""


def check_runs(
    problem: Problem[Any],
    root: Path,
    item_faults: Callable[[Any], list[str]],
    run_faults: Callable[[Any, Run], list[str]],
) -> tuple[int, int, list[str]]:
    """Return the numbers of runs and of items below `root`, and what is wrong with them, a sentence each.

    item_faults : what is wrong with an item. run_faults : what is wrong with a run on an item, beside its ending.
    """
    from reports.stores import read_runs, walk  # here: pandas takes its time, and every child imports this

    runs, problems = read_runs(root, problem=problem.name)
    beside: dict[Path, list[tuple[Path, Run]]] = defaultdict(list)
    for path, run in runs.items():
        beside[path.parent].append((path, run))
    items = 0
    for folder, names, of in walk(root):
        if of != problem.name or not set(ITEM_FILES[of]) & set(names):
            continue
        items += 1
        try:
            item = problem.read(folder)
        except InputError as error:
            problems.append(str(error))
            continue
        file = folder / ITEM_FILES[of][0]
        if folder.name != folder_of(item):
            problems.append(f"{file}: is not the {problem.item} of its folder, it belongs into {folder_of(item)}")
            continue
        problems += [f"{file}: {sentence}" for sentence in item_faults(item)]
        for path, run in beside[folder]:
            problems += [f"{path}: {sentence}" for sentence in _faults(problem, item, run, run_faults)]
    return len(runs), items, problems


def _faults(problem: Problem[Any], item: Any, run: Run, run_faults: Callable[[Any, Run], list[str]]) -> list[str]:
    about, found = run.instance, []
    if about["digest"] != item.digest or about.get("n_tasks") != problem.size(item):
        found.append(f"is a run on another {problem.item} ({about['name']}, digest {about['digest']})")
    if run.status == "ERROR":
        return [*found, f"ERROR: {run.message}"]
    if run.status not in (*MACHINERY, *problem.statuses):
        found.append(f"claims to be {one_line(run.status, LONGEST_VALUE)}, which no {problem.methods.kind} can say")
    return found + run_faults(item, run)
