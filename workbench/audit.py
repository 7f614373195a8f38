"""Audit: every run of a store verified again from its files, and the runs against each other."""

from __future__ import annotations

from pathlib import Path

from formulations.solver import Status
from instances import InputError, Instance, makespan
from workbench.run import Run
from workbench.store import Store
from workbench.verify import ROUNDING, refute_bound, refute_cost, refute_proof, refute_routes


def audit(folder: Path) -> tuple[str, list[str]]:
    """Return what was looked at, in words, and every problem found, a sentence each.

    Problems: a damaged or foreign file, a run refuted by its own routes, a run that ended in ERROR, and a bound
    above another run's routes on the same instance.
    """
    store = Store(folder)
    problems: list[str] = []
    runs: dict[str, list[tuple[str, Run]]] = {name: [] for name in store.folders()}
    for path in store.paths():
        try:
            runs[path.partition("/")[0]].append((path, store.get(path)))
        except InputError as error:
            problems.append(str(error))
    for name, stored in runs.items():
        try:
            instance = store.instance(name)
        except InputError as error:
            problems.append(str(error))
            continue
        refuted = {path: wrong for path, run in stored if (wrong := refute_run(instance, run))}
        problems += [f"{folder / path}: {wrong}" for path, wrong in refuted.items()]
        problems += _contradictions(folder, [(path, run) for path, run in stored if path not in refuted])
    return f"{sum(map(len, runs.values()))} runs on {len(runs)} instances", problems


def refute_run(instance: Instance, run: Run) -> str | None:
    """Return what is wrong with a stored run, in a sentence, or None."""
    if run.instance["digest"] != instance.digest:
        return f"is a run of another instance (digest {run.instance['digest']})"
    if run.status is Status.ERROR:
        return f"{run.label} ended in ERROR: {run.message}"
    wrong = None
    if run.routes is not None:
        wrong = refute_routes(instance, run.routes) or refute_cost(run.objective, makespan(instance, run.routes))
    elif run.objective is not None:
        wrong = f"states a longest tour of {run.objective!r} s without routes"
    return (
        wrong
        or refute_bound(run.bound, run.objective, run.tolerance)
        or refute_proof(run.status, run.bound, run.objective, run.tolerance)
    )


def _contradictions(folder: Path, stored: list[tuple[str, Run]]) -> list[str]:
    """Return the bounds that the best routes of another run refute."""
    found = [(run.objective, path) for path, run in stored if run.objective is not None]
    if not found:
        return []
    best, where = min(found)
    return [
        f"{folder / path}: bound of {run.bound!r} s contradicts the routes of {folder / where}, which cost {best!r} s"
        for path, run in stored
        if run.bound is not None and path != where and run.bound > best + max(run.tolerance, ROUNDING * best)
    ]
