"""Backlog: the jobs of a study still to do, begun one by one, each claimed so that no other process runs it too."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Protocol, TypeVar

from reports.record import Run
from workbench.jobs.claims import Claims
from workbench.jobs.job import Job
from workbench.jobs.store import Store, Version

POLL = 0.5
"""Seconds between two looks at the jobs that other processes have claimed."""

Ended = TypeVar("Ended")


class Progress(Protocol):
    """Is told what becomes of the jobs."""

    def finished(self, job: Job, run: Run) -> None:
        """`job` has ended as `run`, which is stored."""

    def elsewhere(self, job: Job) -> None:
        """Another process has run `job` and stored the run."""

    def waiting(self, count: int) -> None:
        """Nothing is left to do but to wait for `count` runs of other processes."""


class Backlog:
    """The jobs of a study still to do; a context manager that lets go of what was handed out and not done.

    seen : for jobs that are run again, which file lay there when that was decided; where another lies there by the
    time it is their turn, another process has run them again.
    """

    def __init__(self, jobs: Iterable[Job], store: Store, seen: Mapping[str, Version | None] | None = None) -> None:
        self.store = store
        self._fresh, self._seen = deque(jobs), seen or {}
        self._others: deque[Job] = deque()
        self._out: set[str] = set()
        self._claims = Claims()
        self._looked = 0.0

    def __enter__(self) -> Backlog:
        self._claims.__enter__()
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._claims.__exit__()

    def work_off(
        self,
        room: int,
        begin: Callable[[Job], None],
        ended: SimpleQueue[tuple[Job, Ended]],
        take: Callable[[Job, Ended], None],
        progress: Progress,
    ) -> None:
        """Begin every job, `room` at once, and take how each ended as it comes out of the queue `ended`."""
        while True:
            while len(self._out) < room and (job := self._next(progress)):
                self._out.add(job.path)
                begin(job)
            if not self._out and not self._others:
                return
            if not self._out:
                progress.waiting(len(self._others))
            with contextlib.suppress(Empty):
                job, how = ended.get(timeout=POLL if self._others else None)
                take(job, how)
                self._out.remove(job.path)
                self._claims.release(self.store.root / job.path)

    def _next(self, progress: Progress) -> Job | None:
        """Return a job that is now ours to run; None where there is none for the moment."""
        while self._fresh:
            if self._ours(job := self._fresh.popleft(), progress):
                return job
        if time.monotonic() - self._looked >= POLL:
            self._looked = time.monotonic()
            for _ in range(len(self._others)):
                if self._ours(job := self._others.popleft(), progress):
                    return job
        return None

    def _ours(self, job: Job, progress: Progress) -> bool:
        if not self._claims.take(self.store.root / job.path):
            self._others.append(job)
            return False
        now = self.store.version(job.path)
        if now is None or now == self._seen.get(job.path):
            return True
        self._claims.release(self.store.root / job.path)
        progress.elsewhere(job)
        return False
