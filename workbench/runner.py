"""Runner: one job in one fresh process, and only what could be verified is believed.

The parent keeps the best streamed routes, recomputes every claimed cost, and turns whatever happens to the child
(crash, kill, hang, nonsense) into a Run with what had been streamed so far.
"""

from __future__ import annotations

import math
import signal
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from formulations.routing.solver import Event, Limits, Status, ignore
from instances import Instance, Routes, as_routes, makespan, tour_costs
from workbench.child import Ending, run_child
from workbench.job import Job
from workbench.machine import environment, environment_digest, usable_memory
from workbench.run import Run, describe
from workbench.verify import refute_bound, refute_cost, refute_proof, refute_routes
from workbench.worker import Assignment


def run(
    job: Job,
    instance: Instance,
    *,
    start: Routes | None = None,
    memory_limit: int | None = None,
    observe: Callable[[Event], None] = ignore,
    stop: Callable[[], bool] = lambda: False,
) -> Run:
    """Run `job` on `instance` in a fresh, killable process and return what could be verified.

    start : feasible routes to begin from. memory_limit [bytes]: of the child, by default what the machine can spare.
    observe : is told each verified event as it is streamed. stop : polled; InterruptedRunError once it is true.
    """
    limits = Limits(time=job.time_limit, threads=job.threads, iterations=job.iterations)
    witness = _Witness(instance, observe)
    ending = run_child(
        Assignment(instance, job.solver, dict(job.options), limits, job.seed, start),
        witness.hear,
        memory_limit=usable_memory() if memory_limit is None else memory_limit,
        stop=stop,
    )
    return _written(job, instance, witness, ending)


AT_ONCE = 1e-3
"""Events closer than this [s], after the first second this share of the elapsed time, are stored as one."""


@dataclass
class _Witness:
    """Hears the child's messages, keeps what is verified, and remembers the first false claim."""

    instance: Instance
    observe: Callable[[Event], None]
    proves: bool = False
    routes: Routes | None = None
    objective: float | None = None
    bound: float | None = None
    refuted: str | None = None
    refuted_claim: float | None = None
    elapsed: float = 0.0
    trace: list[tuple[float, float | None, float | None]] = field(default_factory=list)
    last: dict[str, Any] = field(default_factory=dict)

    def hear(self, message: dict[str, Any]) -> None:
        """Take one message of the child."""
        kind = message["kind"]
        self.proves = message.get("proves", self.proves)
        if kind == "rubbish":
            self._refute(f"sent an unreadable message: {message['line']!r}", None)
        if kind in ("event", "result"):
            self._believe(message)
        if kind == "result":
            self._refute(self._false_ending(message), message["objective"])
        if kind in ("result", "declined", "error"):
            self.last = message

    def _believe(self, message: dict[str, Any]) -> None:
        """Verify what is claimed; keep routes that are better and bounds that are higher."""
        self.elapsed = max(self.elapsed, message["elapsed"])
        news = False
        if message["routes"] is not None:
            routes, claimed = as_routes(message["routes"]), message["objective"]
            wrong = refute_routes(self.instance, routes)
            if not wrong:
                cost = makespan(self.instance, routes)
                wrong = refute_cost(claimed, cost)
                if self.objective is None or cost < self.objective:
                    self.routes, self.objective, news = routes, cost, True
            self._refute(wrong, claimed)
        bound = message["bound"]
        if bound is not None and math.isfinite(bound) and (self.bound is None or bound > self.bound):
            self.bound, news = bound, True
        if news:
            if self.trace and self.elapsed - self.trace[-1][0] < AT_ONCE * max(1.0, self.elapsed):
                del self.trace[-1]
            self.trace.append((self.elapsed, self.objective, self.bound))
            self.observe(Event(self.elapsed, self.objective, self.bound, self.routes))

    def _false_ending(self, message: dict[str, Any]) -> str | None:
        """Return what is wrong with the final claim apart from its routes, or None."""
        status, bound, tolerance = Status(message["status"]), message["bound"], message["tolerance"]
        if message["routes"] is None and (message["objective"] is not None or status is Status.FEASIBLE):
            return f"claimed {status} with a longest tour of {message['objective']!r} s, but gave no routes"
        return refute_bound(bound, self.objective, tolerance) or refute_proof(status, bound, self.objective, tolerance)

    def _refute(self, sentence: str | None, claimed: float | None) -> None:
        if sentence and not self.refuted:
            self.refuted, self.refuted_claim = sentence, claimed


def _written(job: Job, instance: Instance, witness: _Witness, ending: Ending) -> Run:
    status, stopped_by, message = _verdict(witness, ending)
    last = witness.last
    claimed = witness.refuted_claim if witness.refuted else last.get("objective")
    # A refuted run proves nothing: its routes cost what they cost, its bounds are dropped.
    bound = None if witness.refuted else witness.bound
    if bound is not None and witness.objective is not None:
        bound = min(bound, witness.objective)  # a hair above within the tolerance, by rounding
    return Run(
        instance=describe(instance),
        solver=job.solver,
        options=dict(job.options),
        label=job.label,
        seed=job.seed,
        time_limit=job.time_limit,
        threads=job.threads,
        iterations=job.iterations,
        proves=witness.proves,
        status=status,
        objective=witness.objective,
        bound=bound,
        elapsed=last.get("elapsed", witness.elapsed if not ending.killed else max(0.0, ending.wall - ending.prepare)),
        routes=witness.routes,
        stopped_by=stopped_by,
        message=message,
        tolerance=last.get("tolerance", 0.0),
        claimed_objective=_finite(claimed),
        tour_costs=[] if witness.routes is None else tour_costs(instance, witness.routes).tolist(),
        prepare_elapsed=ending.prepare,
        wall_elapsed=ending.wall,
        cpu_seconds=ending.cpu,
        peak_memory=ending.peak_memory,
        environment=environment_digest(environment()),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        trace=[(t, cost, None if witness.refuted else low) for t, cost, low in witness.trace],
        statistics=last.get("statistics", {}),
        log=ending.log,
    )


def _verdict(witness: _Witness, ending: Ending) -> tuple[Status, str, str]:
    """Return status, what stopped the run, and a sentence."""
    last = witness.last
    kind = last.get("kind")
    if witness.refuted:
        return Status.ERROR, "error", witness.refuted
    if kind == "error":
        return Status.ERROR, "error", last["message"]
    if kind == "declined":
        return Status.NO_SOLUTION, "declined", f"does not take this instance: {last['reason']}"
    if kind == "result":
        return Status(last["status"]), last["stopped_by"], last["message"]
    if ending.killed:
        return Status.KILLED, "memory" if ending.out_of_memory else "killed", ending.killed
    if ending.exit_code == -signal.SIGKILL:
        return Status.KILLED, "killed", "was killed from outside (SIGKILL)"
    if ending.exit_code < 0:
        return Status.ERROR, "error", f"crashed with {signal.Signals(-ending.exit_code).name}"
    return Status.ERROR, "error", f"ended with exit code {ending.exit_code} and without a result"


def _finite(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and abs(value) < float("inf") else None
