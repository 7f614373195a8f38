"""The child process of one placement run: reads a job as JSON, writes messages as JSON, one a line."""

from __future__ import annotations

import json
import sys
import time
from typing import Any

from formulations.routing.solver import Limits
from formulations.task_location.placement import place
from formulations.task_location.registry import make_method
from workbench.placement_jobs import Task
from workbench.worker import peak_memory


def main() -> None:
    """Search, streaming improvements, and tell the end."""
    given = json.load(sys.stdin)
    channel, sys.stdout = sys.stdout, sys.stderr  # whatever a method prints is a log and cannot disturb the messages

    def say(kind: str, **fields: Any) -> None:
        channel.write(json.dumps({"kind": kind, **fields}) + "\n")
        channel.flush()

    task = Task(given["name"], given["polygon"], given["setting"], given["n_tasks"])
    method = make_method(given["method"], given["options"])
    method.prepare(task.problem())
    say("prepared")
    problem = task.problem()  # afresh: the eigendecomposition belongs to the search
    before = time.process_time()
    placement = place(
        problem,
        method,
        given["method"],
        seed=given["seed"],
        limits=Limits(time=given["time_limit"]),
        observe=lambda elapsed, value, points: say("event", elapsed=elapsed, value=value, points=points.tolist()),
    )
    say(
        "result",
        status=str(placement.status),
        elapsed=placement.elapsed,
        cpu=time.process_time() - before,
        points=placement.points.tolist(),
        claimed=placement.mutual_information,
        stopped_by=placement.stopped_by,
        peak_memory=peak_memory(),
    )


if __name__ == "__main__":
    main()
