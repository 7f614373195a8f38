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
from typing import Any

import click

from formulations.task_location.certificate import certificate
from instances.disk import write_aside
from instances.errors import InputError
from workbench.job import Job
from workbench.machine import environment, environment_digest
from workbench.placement_jobs import PlacementStudy, Task, placement_study_from
from workbench.placement_runner import run_placement
from workbench.study import load_tables


def compare_placements(
    path: Path, out: Path | None, parallel: int, changes: Mapping[str, object], dry_run: bool
) -> int:
    """Run the study in the file `path`, with the changes that flags make to it, and report; return the exit code."""
    tables = load_tables(path)
    for key, value in changes.items():
        if key not in ("time_limit", "seeds"):
            raise InputError(f"compare: {key} cannot be given with a placement study")
        tables = {**tables, key: value}
        tables["methods"] = [{k: v for k, v in entry.items() if k != key} for entry in tables.get("methods", [])]
    try:
        study = placement_study_from(tables, name=path.stem, base=path.parent)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    folder = out or Path("runs") / study.name
    todo = [(task, job) for task, job in study.jobs if not (folder / job.path).exists()]
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
    return report_placements(study, folder)


def report_placements(study: PlacementStudy, folder: Path) -> int:
    """Write results.csv and report.html about every stored run of the study, print the summary; 1 where one failed."""
    from rich import box  # here: not needed while methods run
    from rich.console import Console
    from rich.table import Table

    from reports.placement_page import HEADINGS, placement_summary, summary_cells, write_placement_page

    runs = [_read(folder / job.path) for _, job in study.jobs]
    frame = write_placement_page(runs, folder / "report.html", f"Task locations: {study.name}")
    write_aside(folder / "results.csv", frame.to_csv(index=False))
    table = Table(box=box.SIMPLE_HEAD)
    for words in HEADINGS.values():
        table.add_column(words, justify="left" if words in ("Problem", "Method") else "right")
    for cells in summary_cells(placement_summary(frame)):
        table.add_row(*cells)
    console = Console()
    Console(width=None if console.is_terminal else max(console.width, 160)).print(table)
    click.echo(f"{folder / 'results.csv'}\n{folder / 'report.html'}")
    return 1 if frame["mutual_information"].isna().any() else 0


def _prepare(study: PlacementStudy, folder: Path) -> dict[str, float]:
    """Make the folders, state what is asked, and return the certificate of each problem, computed once."""
    (folder / "environments").mkdir(parents=True, exist_ok=True)
    found = environment()
    write_aside(folder / "environments" / f"{environment_digest(found)}.json", json.dumps(found, indent=1))
    asked = {"schema": 1, "study": study.asked, "runs": [job.path for _, job in study.jobs]}
    write_aside(folder / "study.json", json.dumps(asked))
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
        bounds[task.folder] = float(_read(path)["certificate"]["bound"])
    return bounds


def _read(path: Path) -> dict[str, Any]:
    try:
        data: dict[str, Any] = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read ({error}); move it away to go on") from None
    return data
