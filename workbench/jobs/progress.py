"""Progress of a study on stderr: a bar with the time left on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Callable, Iterable
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from instances.compilation import WORDS, told_to
from instances.errors import LONGEST_SENTENCE, one_line
from reports.numbers import counted
from reports.record import Run
from workbench.jobs.job import Job
from workbench.terminal import say

STARTING = 2.0
"""Seconds a process takes around its solve, until a run has shown how long."""
COLD = 5.0
"""Seconds from which on preparing is taken to have compiled kernels, once for all runs of the method."""


class Estimate:
    """Time left: what each remaining job is expected to take, by the mean of its method so far, else by its limit.

    Preparing is counted apart: where a method of the study had to compile its kernels, so will each that has not run
    yet, once; and one that has will not again.
    """

    def __init__(self, jobs: Iterable[Job], parallel: int) -> None:
        self._waiting = {job.path: job for job in jobs}
        self._parallel = parallel
        self._seen: dict[tuple[str, float], list[float]] = defaultdict(list)
        self._prepared: dict[str, list[float]] = defaultdict(list)

    def finished(self, job: Job, wall: float | None, prepared: float = 0.0) -> None:
        """Take note that `job` took `wall` [s], `prepared` [s] of it before the solve; None where another ran it."""
        self._waiting.pop(job.path, None)
        if wall is not None:
            self._seen[job.label, job.time_limit].append(wall - prepared)
            self._prepared[job.method].append(prepared)

    def left(self) -> float:
        """Return the time left [s]."""
        total = 0.0
        for job in self._waiting.values():
            seen, prepared = self._seen.get((job.label, job.time_limit)), self._prepared.get(job.method)
            total += sum(seen) / len(seen) if seen else job.time_limit
            total += min(*prepared, COLD) if prepared else STARTING
        firsts = [prepared[0] for prepared in self._prepared.values() if prepared[0] > COLD]
        cold = {job.method for job in self._waiting.values()} - set(self._prepared)
        return (total + (len(cold) * sum(firsts) / len(firsts) if firsts else 0.0)) / self._parallel


class StudyProgress:
    """Shows each finished run; use as a context manager."""

    def __init__(self, jobs: Iterable[Job], parallel: int, spell: Callable[[Run], str]) -> None:
        jobs = list(jobs)
        self._spell = spell
        self._estimate = Estimate(jobs, parallel)
        self._total, self._done, self._waited_for = len(jobs), 0, 0
        self._said = False
        self._bar: Progress | None = None
        if sys.stderr.isatty():
            columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
            self._bar = Progress(*columns, console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task(self._left(), total=self._total)

    def __enter__(self) -> StudyProgress:
        self._told = told_to(self._compiling)
        self._told.__enter__()
        if self._bar:
            self._bar.start()
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._told.__exit__(None, None, None)
        if self._bar:
            self._bar.stop()

    def _compiling(self, begins: bool) -> None:
        """Show that runs compile, as the bar's words; on no terminal once, as a line."""
        if self._bar:
            self._bar.update(self._task, description=WORDS if begins else self._left())
        elif begins and not self._said:
            print(WORDS, file=sys.stderr, flush=True)
        self._said = True

    def _left(self) -> str:
        return f"about {duration(self._estimate.left())} left"

    def finished(self, job: Job, run: Run) -> None:
        """Show that `job` has ended as `run`."""
        value = self._spell(run)
        line = f"{run.instance['name']} {job.label} seed {job.seed}: {run.status} {value} in {run.elapsed:.1f} s"
        self._show(job, run.wall_elapsed or 0.0, line, run.prepare_elapsed or 0.0)

    def elsewhere(self, job: Job) -> None:
        """Show that another process has run `job`."""
        self._show(job, None, f"{job.path}: run by another process")

    def waiting(self, count: int) -> None:
        """Show that only runs of other processes are left; once for each number of them."""
        if count == self._waited_for:
            return
        self._waited_for = count
        words = f"waiting for {counted(count, 'run')} of another process"
        if self._bar:
            self._bar.update(self._task, description=words)
        else:
            print(words, file=sys.stderr, flush=True)

    def _show(self, job: Job, wall: float | None, line: str, prepared: float = 0.0) -> None:
        self._done += 1
        self._estimate.finished(job, wall, prepared)
        line = one_line(line, LONGEST_SENTENCE)
        left = self._left()
        if self._bar:
            self._bar.console.print(line, highlight=False, markup=False, soft_wrap=True)
            self._bar.update(self._task, advance=1, description=left)
        else:
            say(f"[{self._done}/{self._total}] {line}; {left}", err=True)


def duration(seconds: float) -> str:
    """Return a time for people: 45 s, 12 min, 3.5 h."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"
