"""One placement job in one fresh process; what it claims is checked here: points inside, information recomputed."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

import numpy as np

from formulations.task_location.criterion import Convention
from formulations.task_location.placement import PlacementProblem, checked_points
from workbench.child import grace
from workbench.job import Job
from workbench.machine import environment, environment_digest
from workbench.placement_jobs import Task
from workbench.threads import with_threads

PREPARE_LIMIT = 120.0
"""Seconds a child may take to start and import."""
TOLERANCE = 1e-6
"""Relative: a claim further from the recomputed information is refuted."""


def run_placement(task: Task, job: Job, problem: PlacementProblem, certificate: float) -> dict[str, Any]:
    """Run `job` on `task` and return the run as JSON values, in the keys of a routing run where they apply.

    objective is −I [nats], recomputed here, and bound −certificate, so that lower is better as in routing.
    """
    messages, log, killed, wall = _listen(task, job)
    last = next((m for m in reversed(messages) if m["kind"] == "result"), None)
    events = [m for m in messages if m["kind"] == "event"]
    claim = last or (events[-1] if events else None)
    status, fault = "ERROR", ""
    points: list[list[float]] | None = None
    worth: dict[str, float] = {}
    if claim is not None:
        points, worth, fault = _checked(problem, job, claim["points"], claim.get("claimed"))
    if fault:
        message, points = fault, None
    elif killed:
        status, message = "KILLED", killed
    elif last is None:
        message = log.strip().splitlines()[-1] if log.strip() else "ended without a result"
    else:
        status, message = last["status"], ""
    value = None if points is None else worth["b"]
    trace = [[m["elapsed"], -m["value"], -certificate] for m in _thinned(events)] if value is not None else []
    return {
        "schema": 1,
        "problem": "placement",
        "instance": {"name": task.name, "digest": task.digest, "n_tasks": task.n_tasks, "n_depots": 0},
        "solver": job.solver,
        "options": dict(job.options),
        "label": job.label,
        "proves": False,
        "seed": job.seed,
        "time_limit": job.time_limit,
        "threads": job.threads,
        "iterations": job.iterations,
        "status": status,
        "objective": None if value is None else -value,
        "bound": -certificate,
        "mutual_information": value,
        "certificate": certificate,
        "ratio": None if value is None else value / certificate,
        "information": worth,
        "elapsed": last["elapsed"] if last else wall,
        "points": points,
        "trace": trace,
        "stopped_by": last["stopped_by"] if last else ("killed" if killed else "error"),
        "message": message,
        "claimed_objective": None if last is None else -last["claimed"],
        "wall_elapsed": wall,
        "cpu_seconds": last["cpu"] if last else None,
        "peak_memory": last["peak_memory"] if last else None,
        "log": log[-4000:],
        "environment": environment_digest(environment()),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _checked(
    problem: PlacementProblem, job: Job, claimed_points: list[list[float]], claimed: float | None
) -> tuple[list[list[float]], dict[str, float], str]:
    """Return the points, what they are worth under every convention, and what is wrong with the claim."""
    points = np.array(claimed_points, dtype=float)
    try:
        checked_points(problem, points, job.solver)
    except RuntimeError as error:
        return claimed_points, {}, str(error)
    worth = {str(c): problem.criterion.under(c).value(points) for c in Convention}
    if claimed is not None and abs(claimed - worth["b"]) > TOLERANCE * abs(worth["b"]):
        return claimed_points, worth, f"claimed {claimed!r} nats, but its points are worth {worth['b']!r}"
    return claimed_points, worth, ""


def _listen(task: Task, job: Job) -> tuple[list[dict[str, Any]], str, str, float]:
    """Run the child; return its messages, its log, why it was killed (or ""), and its wall clock [s]."""
    given = {**asdict(task), "method": job.solver, "options": dict(job.options)}
    given |= {"seed": job.seed, "time_limit": job.time_limit}
    began, killed = time.monotonic(), ""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "workbench.placement_worker"],
            stdin=subprocess.PIPE,
            stdout=out,
            stderr=err,
            env=with_threads(1),
            start_new_session=True,
            text=True,
        )
        try:
            process.communicate(json.dumps(given), timeout=PREPARE_LIMIT + job.time_limit + grace(job.time_limit))
        except subprocess.TimeoutExpired:
            killed = f"ignored its time limit of {job.time_limit:g} s and was killed"
        finally:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        wall = time.monotonic() - began
        out.seek(0)
        err.seek(0)
        return _messages(out.read()), err.read(), killed, wall


def _messages(text: str) -> list[dict[str, Any]]:
    found = []
    for line in text.splitlines():
        with contextlib.suppress(ValueError):  # a line cut by a kill
            found.append(json.loads(line))
    return found


def _thinned(events: list[dict[str, Any]], most: int = 200) -> list[dict[str, Any]]:
    """Return at most about `most` events, the last among them."""
    step = max(1, len(events) // most)
    return events[::-1][::step][::-1]
