"""Orphans: what a run leaves behind where its keeper was killed, found and ended by the study.

A keeper that is killed cannot end the others. Their environment still names the run; and where the study has said
`adopt`, they have become its own children (Linux: it is a child subreaper, as its keepers are), whatever they did to
their environment.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Iterator

import psutil

from workbench.jobs.process.kernel import adopt_descendants
from workbench.jobs.process.processes import kill, own_children

MARK = "WORKBENCH_RUN"
"""Variable of the environment that tells a run's processes from all others."""
PAUSE = 0.02
"""Seconds between two searches."""
QUIET = 3
"""Searches that find nothing before we believe that nothing is left: one that forks may be missed by a look."""
LONGEST = 10.0
"""Seconds to go on searching."""

_lock = threading.Lock()
_ours: set[int] | None = None
"""Children that are no orphans; None as long as nothing was adopted."""


def adopt() -> None:
    """Take over, from now on, what loses its keeper: every child of this process not begun by `begun` is an orphan."""
    global _ours
    with _lock:
        if _ours is None and adopt_descendants():
            _ours = {child.pid for child in own_children()}


@contextlib.contextmanager
def begun() -> Iterator[set[int]]:
    """Yield a set to put into the pids of children that are begun meanwhile, so that nobody takes them for orphans."""
    with _lock:
        fresh: set[int] = set()
        yield fresh
        if _ours is not None:
            _ours.update(fresh)


def ended(pid: int) -> None:
    """Forget a child that has ended: its number may be an orphan's next."""
    with _lock:
        if _ours is not None:
            _ours.discard(pid)


def end_orphans(mark: str) -> None:
    """Kill every process of the run that `mark` names, and every orphan, until none is found any more."""
    quiet, until = 0, time.monotonic() + LONGEST
    while quiet < QUIET and time.monotonic() < until:
        with _lock:
            left = [*_marked(mark), *_adopted()]
            kill(left)
            for process in _adopted():
                with contextlib.suppress(ChildProcessError):
                    os.waitpid(process.pid, os.WNOHANG)
        quiet = 0 if left else quiet + 1
        time.sleep(PAUSE)


def _marked(mark: str) -> list[psutil.Process]:
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error, OSError):
            if process.environ().get(MARK) == mark:
                found.append(process)
    return found


def _adopted() -> list[psutil.Process]:
    return [] if _ours is None else [child for child in own_children() if child.pid not in _ours]
