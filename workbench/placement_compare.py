"""`workbench compare` of a study with ``problem = "placement"``: run what is not stored yet, then report.

RUNS/study.json                               what was asked
RUNS/<region>-n<n>-<digest>/problem.json      the problem and its certificate
RUNS/<region>-n<n>-<digest>/<method>-<options>-s<seed>-t<limit>.json
RUNS/results.csv, RUNS/report.html
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import click

from formulations.task_location.certificate import certificate
from instances.disk import write_aside
from instances.errors import InputError, suggestion
from reports.placement_store import placement_run
from workbench.job import Job
from workbench.machine import environment, environment_digest
from workbench.placement_jobs import PlacementStudy, Task, placement_study_from
from workbench.placement_runner import run_placement
from workbench.settings import names
from workbench.store import Store
from workbench.study import load_tables

STATUSES = ("error", "killed")
"""What `--retry` can name: the ways in which a placement run ends without having finished."""


def compare_placements(
    path: Path,
    out: Path | None,
    parallel: int,
    changes: Mapping[str, object],
    *,
    retry: str | None,
    report: bool,
    dry_run: bool,
) -> int:
    """Run the study in the file `path`, with the changes that flags make to it, and report; return the exit code."""
    tables = load_tables(path)
    for key, value in changes.items():
        if key not in ("time_limit", "seeds"):
            flag = "INSTANCES" if key == "instances" else f"--{key}"
            raise InputError(f"compare: {flag} cannot be given with a placement study")
        tables = {**tables, key: value}
        tables["methods"] = [{k: v for k, v in entry.items() if k != key} for entry in tables.get("methods", [])]
    try:
        study = placement_study_from(tables, name=path.stem, base=path.parent)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    folder = out or Path("runs") / study.name
    todo, damaged = _to_do(study, folder, _statuses(retry))
    if dry_run:
        click.echo("\n".join(job.path for _, job in todo))
        click.echo(f"{len(todo)} runs to do ({len(study.jobs) - len(todo)} of {len(study.jobs)} stored)")
        return 0
    bounds = _prepare(study, folder)
    problems = {task.folder: task.problem() for task in study.tasks}

    def one(pair: tuple[Task, Job]) -> None:
        task, job = pair
        run = run_placement(task, job, problems[task.folder], bounds[task.folder])
        write_aside(folder / job.path, json.dumps(run))
        value = (
            "failed: " + run["message"]
            if run["mutual_information"] is None
            else f"{run['mutual_information']:.4f} nats"
        )
        click.echo(f"{job.path}: {value}, {run['elapsed']:.2f} s", err=True)

    with ThreadPoolExecutor(parallel) as pool:
        list(pool.map(one, todo))
    problems_found = _report(folder) if report else damaged
    for problem in problems_found:
        click.echo(problem, err=True)
    return 1 if problems_found else 0


def _statuses(retry: str | None) -> list[str]:
    """Return the statuses that `retry` names; InputError for one that no placement run ends with."""
    again = [] if retry is None else names(retry, "--retry")
    for name in again:
        if name.lower() not in STATUSES:
            near = suggestion(name.lower(), STATUSES)
            raise InputError(f"--retry: '{name}' is no status of a placement study{near} (known: error, killed)")
    return [name.upper() for name in again]


def _to_do(study: PlacementStudy, folder: Path, again: list[str]) -> tuple[list[tuple[Task, Job]], list[str]]:
    """Return the jobs that have no file or ended with a status in `again`, and what is wrong with damaged files."""
    todo, damaged = [], []
    for task, job in study.jobs:
        path = folder / job.path
        if not path.exists():
            todo.append((task, job))
            continue
        try:
            if placement_run(path)["status"] in again:
                todo.append((task, job))
        except InputError as error:
            damaged.append(f"{path}: {error}; left alone.")
    return todo, damaged


def _report(folder: Path) -> list[str]:
    """Write the CSV and the page about every stored placement run; return what is damaged, false or failed there."""
    from workbench.placement_publish import publish_placements  # here: pandas is not needed while methods run

    published = publish_placements([folder], folder / "report.html", folder / "results.csv")
    assert published is not None
    click.echo("\n".join(str(path) for path in published.written))
    failed = [f"{published.failed} runs ended without a placement"] if published.failed else []
    return [*published.warnings, *published.false, *failed]


def _prepare(study: PlacementStudy, folder: Path) -> dict[str, float]:
    """Make the folders, state what is asked, and return the certificate of each problem, computed once."""
    store = Store(folder)
    store.create()
    store.put_environment(environment_digest(environment()), environment())
    store.put_study({"name": study.name, **study.asked}, [job.path for _, job in study.jobs])
    bounds = {}
    for task in study.tasks:
        path = folder / task.folder / "problem.json"
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            problem = task.problem()
            began = time.perf_counter()
            bound = certificate(problem.criterion, problem.region, task.n_tasks)
            stated = {"bound": bound.bound, "kind": bound.kind, "elapsed": time.perf_counter() - began}
            write_aside(path, json.dumps({**json.loads(task.to_json()), "certificate": stated}))
        bounds[task.folder] = _bound(path)
    return bounds


def _bound(path: Path) -> float:
    try:
        return float(json.loads(path.read_bytes())["certificate"]["bound"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: is damaged or not ours ({error!r}); move it away to go on") from None
