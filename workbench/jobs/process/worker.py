"""Worker: the process of one run, forked by `keeper`, watched by `child`.

It reads a pickled Assignment from standard input and says what happens through a pipe (`messages`). Whatever the
method prints on standard output or error is a log and cannot disturb this. The clock is the parent's.
"""

from __future__ import annotations

import gc
import math
import os
import pickle
import sys
import threading
import traceback
from dataclasses import dataclass
from typing import Any

from formulations.limits import Limits
from instances.compilation import told_to
from instances.errors import InputError
from workbench.jobs.problem import Claim, Problem
from workbench.jobs.process.messages import (
    Claimed,
    Compiling,
    Declined,
    Ended,
    Event,
    Failed,
    Message,
    Prepared,
    Result,
    Started,
    encoded,
    figure,
    finite,
    text,
    written,
)


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
    """The pipe to the parent, for whichever thread of the method speaks."""

    def __init__(self, descriptor: int) -> None:
        self._pipe = os.fdopen(descriptor, "wb", buffering=0)
        self._lock = threading.Lock()

    def say(self, message: Message) -> None:
        """Send one message, whole."""
        line = memoryview(written(message))
        with self._lock:
            while line:
                line = line[self._pipe.write(line) :]


def main(descriptor: int) -> None:
    """Prepare, solve, and tell the parent through the pipe `descriptor`."""
    os.set_inheritable(descriptor, False)
    channel = Channel(descriptor)
    assignment: Assignment = pickle.load(sys.stdin.buffer)
    try:
        _carry_out(assignment, channel)
    except Exception as error:  # the boundary to foreign code: whatever it raises is a finding about it
        traceback.print_exc()
        words = text(error) if isinstance(error, InputError) else text(f"{type(error).__name__}: {error}")
        channel.say(Failed(words))
    gc.freeze()  # what is left goes with the process: looking through all that was imported takes longer than its end


def _carry_out(assignment: Assignment, channel: Channel) -> None:
    problem, item = assignment.problem, assignment.item
    method = problem.methods.make(assignment.method, assignment.options)
    gc.freeze()  # what is imported by now is never looked through again
    gc.enable()
    channel.say(Started(bool(getattr(method, "proves", False))))
    said: list[Message] = []

    def compiling(begins: bool) -> None:
        if begins and not said:
            said.append(Compiling())
            channel.say(said[0])

    with told_to(compiling):
        reason = problem.accepts(method, item)
        if reason is not None:
            channel.say(Declined(text(reason)))
            return
        problem.prepare(method, item)

    def tell(claim: Claim) -> None:
        channel.say(Event(Claimed(encoded(claim.product), *_numbers(claim))))

    channel.say(Prepared())
    claim = problem.solve(method, item, assignment.limits, assignment.seed, tell, assignment.start)
    told = Ended(
        encoded(claim.product),
        *_numbers(claim),
        status=text(claim.status),
        stopped_by=text(claim.stopped_by),
        message=text(claim.message),
        tolerance=finite("tolerance", claim.tolerance),
        statistics={text(name): figure(value) for name, value in claim.statistics.items()},
    )
    channel.say(Result(told))


def _numbers(claim: Claim) -> tuple[float | None, float | None]:
    """Return objective and bound; a bound of minus infinity says nothing."""
    objective = None if claim.objective is None else finite("objective", claim.objective)
    if claim.bound is None or claim.bound == -math.inf:
        return objective, None
    return objective, finite("bound", claim.bound)
