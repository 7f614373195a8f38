"""Runner: one job in one fresh process, and only what could be verified is believed.

The parent keeps the best streamed product, has its problem recompute every claimed objective, and turns whatever
happens to the child (crash, kill, hang, nonsense) into a Run with what had been streamed so far.
"""

from __future__ import annotations

import math
import signal
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from formulations.limits import Limits
from instances.code import code_digest, revision
from reports.record import Run
from workbench.jobs.child import Ending, run_child
from workbench.jobs.job import Job
from workbench.jobs.machine import environment, environment_digest, usable_memory
from workbench.jobs.problem import Claim, Problem
from workbench.jobs.worker import Assignment

Observer = Callable[[float, float | None, float | None], None]
"""Told elapsed [s], objective and bound of each verified event."""


def run(
    problem: Problem[Any],
    job: Job,
    item: Any,
    *,
    start: Any = None,
    memory_limit: int | None = None,
    observe: Observer = lambda elapsed, objective, bound: None,
    stop: Callable[[], bool] = lambda: False,
) -> Run:
    """Run `job` of `problem` on `item` in a fresh, killable process and return what could be verified.

    start : a product to begin from. memory_limit [bytes]: of the child, by default what the machine can spare.
    stop : polled; InterruptedRunError once it is true.
    """
    limits = Limits(time=job.time_limit, threads=job.threads, iterations=job.iterations)
    witness = _Witness(problem, item, observe, bound=problem.bound(item))
    ending = run_child(
        Assignment(problem, item, job.method, dict(job.options), limits, job.seed, start),
        witness.hear,
        memory_limit=usable_memory() if memory_limit is None else memory_limit,
        stop=stop,
    )
    return _written(job, witness, ending)


AT_ONCE = 1e-3
"""Events closer than this [s], after the first second this share of the elapsed time, are stored as one."""


@dataclass
class _Witness:
    """Hears the child's messages, keeps what is verified, and remembers the first false claim."""

    problem: Problem[Any]
    item: Any
    observe: Observer
    bound: float | None = None
    proves: bool = False
    product: Any = None
    objective: float | None = None
    refuted: str = ""
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
            claim = Claim(**message["claim"])
            self._believe(claim, message["elapsed"])
            if kind == "result":
                self._refute(self.problem.refute_ending(claim, self.objective), claim.objective)
        if kind in ("result", "declined", "error"):
            self.last = message

    def _believe(self, claim: Claim, elapsed: float) -> None:
        """Verify what is claimed; keep products that are better and bounds that are higher."""
        self.elapsed = max(self.elapsed, elapsed)
        news = False
        if claim.product is not None:
            objective, wrong = self.problem.judge(self.item, claim.product, claim.objective)
            if objective is not None and (self.objective is None or objective < self.objective):
                self.product, self.objective, news = claim.product, objective, True
            self._refute(wrong, claim.objective)
        bound = claim.bound
        if bound is not None and math.isfinite(bound) and (self.bound is None or bound > self.bound):
            self.bound, news = bound, True
        if news:
            if self.trace and self.elapsed - self.trace[-1][0] < AT_ONCE * max(1.0, self.elapsed):
                del self.trace[-1]
            self.trace.append((self.elapsed, self.objective, self.bound))
            self.observe(self.elapsed, self.objective, self.bound)

    def _refute(self, sentence: str, claimed: float | None) -> None:
        if sentence and not self.refuted:
            self.refuted, self.refuted_claim = sentence, claimed


def _written(job: Job, witness: _Witness, ending: Ending) -> Run:
    status, stopped_by, message = _verdict(witness, ending)
    problem, item, last = witness.problem, witness.item, witness.last
    claim = last.get("claim", {})
    claimed = witness.refuted_claim if witness.refuted else claim.get("objective")
    # A refuted run proves nothing: its product is worth what it is worth, the bounds it claimed are dropped.
    bound = problem.bound(item) if witness.refuted else witness.bound
    if bound is not None and witness.objective is not None:
        bound = min(bound, witness.objective)  # a hair above within the tolerance, by rounding
    return Run(
        problem=problem.name,
        instance=problem.describe(item),
        solver=job.method,
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
        stopped_by=stopped_by,
        message=message,
        tolerance=claim.get("tolerance", 0.0),
        claimed_objective=_finite(claimed),
        prepare_elapsed=ending.prepare,
        wall_elapsed=ending.wall,
        cpu_seconds=min(ending.cpu, last.get("cpu", ending.cpu)),  # without what telling the result took
        peak_memory=ending.peak_memory,
        environment=environment_digest(environment()),
        code=code_digest(),
        revision=revision(),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        trace=[(t, cost, problem.bound(item) if witness.refuted else low) for t, cost, low in witness.trace],
        statistics=dict(claim.get("statistics", {})),
        log=ending.log,
        own=problem.own_columns(item, witness.product),
    )


def _verdict(witness: _Witness, ending: Ending) -> tuple[str, str, str]:
    """Return status, what stopped the run, and a sentence."""
    last = witness.last
    kind = last.get("kind")
    if witness.refuted:
        return "ERROR", "error", witness.refuted
    if kind == "error":
        return "ERROR", "error", last["message"]
    if kind == "declined":
        return "NO_SOLUTION", "declined", f"does not take this {witness.problem.item}: {last['reason']}"
    if kind == "result":
        return last["claim"]["status"], last["claim"]["stopped_by"], last["claim"]["message"]
    if ending.killed:
        return "KILLED", "memory" if ending.out_of_memory else "killed", ending.killed
    if ending.exit_code == -signal.SIGKILL:
        return "KILLED", "killed", "was killed from outside (SIGKILL)"
    if ending.exit_code < 0:
        return "ERROR", "error", f"crashed with {signal.Signals(-ending.exit_code).name}"
    return "ERROR", "error", f"ended with exit code {ending.exit_code} and without a result"


def _finite(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and abs(value) < float("inf") else None
