"""The child process of one run: ``python -P -m workbench.jobs.worker FD``, started and watched by `child`.

It reads a pickled Assignment from standard input and writes one JSON object a line to the pipe FD:
started, prepared, then any number of events, then result; or declined; or error. Whatever the method prints on
standard output or error is a log and cannot disturb this. The clock is kept here, not by the method.
"""

from __future__ import annotations

import ctypes
import json
import os
import pickle
import resource
import signal
import sys
import threading
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from formulations.limits import Limits
from workbench.jobs.problem import Claim, Problem


@dataclass(frozen=True)
class Assignment:
    """Everything the child needs to know."""

    problem: Problem[Any]
    item: Any
    method: str
    options: dict[str, Any]
    limits: Limits
    seed: int
    start: Any


class Channel:
    """The pipe to the parent: one JSON object a line, from whichever thread of the method speaks."""

    def __init__(self, descriptor: int) -> None:
        self._pipe = os.fdopen(descriptor, "w", encoding="utf-8")
        self._lock = threading.Lock()

    def say(self, kind: str, **fields: Any) -> None:
        """Send one message."""
        line = json.dumps({"kind": kind, **fields}, default=_plain)
        with self._lock:
            self._pipe.write(line + "\n")
            self._pipe.flush()


def main() -> None:
    """Prepare, solve, and tell the parent."""
    descriptor = int(sys.argv[1])
    os.set_inheritable(descriptor, False)
    channel = Channel(descriptor)
    _die_with_parent()
    assignment: Assignment = pickle.load(sys.stdin.buffer)
    try:
        _carry_out(assignment, channel)
    except Exception as error:  # the boundary to foreign code: whatever it raises is a finding about it
        traceback.print_exc()
        channel.say("error", message=f"{type(error).__name__}: {error}", peak_memory=peak_memory())


def _carry_out(assignment: Assignment, channel: Channel) -> None:
    problem, item = assignment.problem, assignment.item
    method = problem.methods.make(assignment.method, assignment.options)
    channel.say("started", proves=bool(getattr(method, "proves", False)))
    reason = problem.accepts(method, item)
    if reason is not None:
        channel.say("declined", reason=reason)
        return
    problem.prepare(method, item)
    before = cpu_time()
    channel.say("prepared", cpu=before)
    began = time.perf_counter()

    def tell(claim: Claim) -> None:
        elapsed = time.perf_counter() - began
        channel.say("event", elapsed=elapsed, claim={"product": claim.product} | _numbers(claim))

    claim = problem.solve(method, item, assignment.limits, assignment.seed, tell, assignment.start)
    elapsed, cpu = time.perf_counter() - began, cpu_time() - before
    words = {name: str(getattr(claim, name)) for name in ("status", "stopped_by", "message")}
    more = {"tolerance": float(claim.tolerance), "statistics": _storable(dict(claim.statistics))}
    told = {"product": claim.product, **_numbers(claim), **words, **more}
    channel.say("result", elapsed=elapsed, cpu=cpu, claim=told, peak_memory=peak_memory())


def _numbers(claim: Claim) -> dict[str, float | None]:
    values = {"objective": claim.objective, "bound": claim.bound}
    return {name: None if value is None else float(value) for name, value in values.items()}


def cpu_time() -> float:
    """Return the processor time [s] of this process and of its children that have ended."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + ended.ru_utime + ended.ru_stime


def peak_memory() -> int:
    """Return the most memory this process has held [bytes].

    On Linux from VmHWM: ru_maxrss there starts from what the parent held when it started us.
    """
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def _die_with_parent() -> None:
    """On Linux: be killed when the parent is (kill −9 included), and be the kernel's first choice to free memory."""
    if sys.platform != "linux":
        return
    set_parent_death_signal = 1
    ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGKILL)
    Path("/proc/self/oom_score_adj").write_text("1000")


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    return str(value)


def _storable(value: Any) -> Any:
    """Return `value` with infinities and NaN, which JSON does not have, spelled out."""
    if isinstance(value, dict):
        return {str(key): _storable(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_storable(item) for item in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else str(value)
    return value


if __name__ == "__main__":
    main()
