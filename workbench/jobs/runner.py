"""Runner: one job in one fresh process, and only what could be verified is believed.

The parent keeps the best streamed product, has its problem recompute every claimed objective, and turns whatever
happens to the child (crash, kill, hang, nonsense) into a Run with what had been streamed so far.
"""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from formulations.limits import Limits
from instances.code import code_digest, revision
from instances.errors import LONGEST_VALUE, one_line
from reports.record import Run
from reports.tolerances import RELATIVE_ROUNDING
from workbench.jobs.job import Job
from workbench.jobs.machine import environment, environment_digest, usable_memory
from workbench.jobs.problem import Claim, Problem
from workbench.jobs.process.child import Ending, run_child
from workbench.jobs.process.messages import (
    Claimed,
    Declined,
    Ended,
    Event,
    Failed,
    Message,
    Result,
    Started,
    UnreadableError,
    read_product,
    text,
)
from workbench.jobs.process.worker import Assignment

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
    highest: float | None = None
    proves: bool = False
    product: Any = None
    objective: float | None = None
    refuted: str = ""
    refuted_claim: float | None = None
    elapsed: float = 0.0
    trace: list[tuple[float, float | None, float | None]] = field(default_factory=list)
    last: Message | None = None

    def hear(self, elapsed: float, message: Message | UnreadableError) -> None:
        """Take what the child said `elapsed` seconds after the solve began."""
        self.elapsed = elapsed
        if isinstance(message, UnreadableError):
            self._refute(f"sent an unreadable message: {message}", None)
        elif isinstance(message, Started):
            self.proves = message.proves
        elif isinstance(message, (Event, Result)):
            self._believe(message.claim)
        if isinstance(message, (Declined, Failed, Result)):
            self.last = message

    def _believe(self, claimed: Claimed) -> None:
        """Verify what is claimed; keep products that are better and bounds that are higher."""
        try:
            product = read_product(claimed.product, self.problem.product)
            news = product is not None and self._judge(product, claimed.objective)
        except Exception as error:  # whatever a product does to those who judge it is a finding about the product
            self._refute(f"gave {self.problem.found} that cannot be judged ({type(error).__name__}: {error})", None)
            return
        if claimed.bound is not None:
            self.highest = claimed.bound if self.highest is None else max(self.highest, claimed.bound)
            if self.bound is None or claimed.bound > self.bound:
                self.bound, news = claimed.bound, True
        self._refute(refute_bound(self.highest, self.objective), claimed.objective)
        if isinstance(claimed, Ended):
            self._refute(self._refuted_ending(claimed, product), claimed.objective)
        if news:
            self._remember()

    def _refuted_ending(self, claimed: Ended, product: Any) -> str:
        if claimed.status not in self.problem.statuses:
            return (
                f"claimed to be {one_line(claimed.status, LONGEST_VALUE)}, which no {self.problem.methods.kind} can say"
            )
        claim = Claim(product, claimed.objective, claimed.bound, claimed.status, tolerance=claimed.tolerance)
        return self.problem.refute_ending(self.item, claim, self.objective)

    def _judge(self, product: Any, claimed: float | None) -> bool:
        """Return whether `product` is the best so far."""
        objective, wrong = self.problem.judge(self.item, product, claimed)
        self._refute(wrong, claimed)
        if objective is None or (self.objective is not None and objective >= self.objective):
            return False
        self.product, self.objective = product, objective
        return True

    def _remember(self) -> None:
        if self.trace and self.elapsed - self.trace[-1][0] < AT_ONCE * max(1.0, self.elapsed):
            del self.trace[-1]
        self.trace.append((self.elapsed, self.objective, self.bound))
        self.observe(self.elapsed, self.objective, self.bound)

    def _refute(self, sentence: str, claimed: float | None) -> None:
        if sentence and not self.refuted:
            self.refuted, self.refuted_claim = text(sentence), claimed


def refute_bound(bound: float | None, objective: float | None) -> str:
    """Return why `bound` cannot be one, given the verified `objective` of the run's own product, or ""."""
    if bound is None or objective is None or bound <= objective + RELATIVE_ROUNDING * abs(objective):
        return ""
    return f"claimed a bound of {bound!r}, but what it found itself has {objective!r}"


def _written(job: Job, witness: _Witness, ending: Ending) -> Run:
    status, stopped_by, message = _verdict(witness, ending)
    problem, item, last = witness.problem, witness.item, witness.last
    claim = last.claim if isinstance(last, Result) else None
    claimed = witness.refuted_claim if witness.refuted or claim is None else claim.objective
    # A refuted run proves nothing: its product is worth what it is worth, the bounds it claimed are dropped.
    bound = problem.bound(item) if witness.refuted else witness.bound
    if bound is not None and witness.objective is not None:
        bound = min(bound, witness.objective)  # a hair above, by rounding
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
        elapsed=witness.elapsed if last or not ending.killed else max(0.0, ending.wall - ending.prepare),
        stopped_by=stopped_by,
        message=message,
        tolerance=claim.tolerance if claim else 0.0,
        claimed_objective=claimed,
        prepare_elapsed=ending.prepare,
        wall_elapsed=ending.wall,
        cpu_seconds=ending.cpu,
        peak_memory=ending.peak_memory,
        environment=environment_digest(environment()),
        code=code_digest(),
        revision=revision(),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        trace=[(t, cost, problem.bound(item) if witness.refuted else low) for t, cost, low in witness.trace],
        statistics=dict(claim.statistics) if claim else {},
        log=ending.log,
        own=problem.own_columns(item, witness.product),
    )


def _verdict(witness: _Witness, ending: Ending) -> tuple[str, str, str]:
    """Return status, what stopped the run, and a sentence."""
    last = witness.last
    if witness.refuted:
        return "ERROR", "error", witness.refuted
    if isinstance(last, Failed):
        return "ERROR", "error", last.message
    if isinstance(last, Declined):
        return "NO_SOLUTION", "declined", f"does not take this {witness.problem.item}: {last.reason}"
    if isinstance(last, Result):
        return last.claim.status, last.claim.stopped_by, last.claim.message
    if ending.killed:
        return "KILLED", "memory" if ending.out_of_memory else "killed", ending.killed
    if ending.exit_code == -signal.SIGKILL:
        return "KILLED", "killed", "was killed from outside (SIGKILL)"
    if ending.exit_code < 0:
        return "ERROR", "error", f"crashed with {signal.Signals(-ending.exit_code).name}"
    return "ERROR", "error", f"ended with exit code {ending.exit_code} and without a result"
