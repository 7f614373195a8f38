"""Tree: all processes of one run, started under a keeper and ended together; their wall clock, CPU time and memory."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Iterator
from typing import IO

import psutil

from workbench.jobs.process import processes
from workbench.jobs.process.orphans import MARK, begun, end_orphans, ended
from workbench.jobs.process.worker import Assignment
from workbench.threads import with_threads

ENDING = 15.0
"""Seconds the keeper may take to end all."""
SEARCH = 1.0
"""Seconds between two searches for processes that the run started."""
SPEAKING = {"PYTHONFAULTHANDLER": "1", "PYTHONUNBUFFERED": "1"}
"""Environment in which a crash leaves a trace."""
FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Signals with which a person or the system ends a whole study."""


class Tree:
    """A keeper, its worker and all they start, from the moment of construction.

    messages, output : descriptors to read what the worker says and what is printed; `close` closes both.
    ordered : whether we have ended it. ended_from_outside : whether a signal of somebody else has, known after `end`.
    wall, usage [s] : wall clock and processor time of all, once `alive` is false. peak_memory : the most that was seen
    held [bytes].
    """

    def __init__(self, assignment: Assignment) -> None:
        self.wall, self.usage, self.peak_memory = 0.0, 0.0, 0
        self.ordered, self.ended_from_outside = False, False
        self._next_search, self._found = 0.0, list[psutil.Process]()
        self._mark = uuid.uuid4().hex
        self.messages, childs_end = os.pipe()
        life, self._life = os.pipe()
        self.began = time.monotonic()
        with _handed_over(assignment) as task, begun() as children:
            self._keeper = subprocess.Popen(
                [sys.executable, "-P", "-m", "workbench.jobs.process.keeper", str(childs_end), str(life)],
                stdin=task,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                pass_fds=(childs_end, life),
                env=with_threads(assignment.limits.threads) | SPEAKING | {MARK: self._mark},
                start_new_session=True,
            )
            children.add(self._keeper.pid)
        os.close(childs_end)
        os.close(life)
        assert self._keeper.stdout is not None
        self.output = self._keeper.stdout.fileno()

    @property
    def exit_code(self) -> int:
        """Exit code of the worker, negative for a signal."""
        return int(self._keeper.returncode or 0)

    def alive(self) -> bool:
        """Return whether the keeper still runs; when it has just ended, take the processor time of all."""
        if self._keeper.returncode is None:
            pid, status, usage = os.wait4(self._keeper.pid, os.WNOHANG)
            if pid == 0:
                return True
            self._keeper.returncode = os.waitstatus_to_exitcode(status)
            self.wall, self.usage = time.monotonic() - self.began, usage.ru_utime + usage.ru_stime
            ended(pid)
        return False

    def processor_time(self, *, afresh: bool = False) -> float:
        """Return the processor time of all processes so far [s]; of those that have just begun only where `afresh`."""
        return processes.processor_time(self._all(afresh))

    def memory(self) -> int:
        """Return the memory all processes hold together [bytes], what they share counted in each."""
        held = processes.memory(self._all())
        self.peak_memory = max(self.peak_memory, held, *(processes.most_memory(each.pid) for each in self._found))
        return held

    def own_memory(self) -> int:
        """Return what they hold together, without what is shared between them [bytes]; this takes longer."""
        return processes.memory(self._all(afresh=True), shared=False)

    def order_end(self) -> None:
        """Have the keeper kill all the others and end; returns at once."""
        if not self.ordered:
            self.ordered = True
            os.close(self._life)

    def end(self) -> None:
        """End what is left and wait until it is gone."""
        self.ended_from_outside = not self.alive() and not self.ordered and -self.exit_code in FROM_OUTSIDE
        self.order_end()
        until = time.monotonic() + ENDING
        while self.alive() and time.monotonic() < until:
            with contextlib.suppress(ProcessLookupError):
                self._keeper.send_signal(signal.SIGCONT)  # should the run have stopped it
            time.sleep(0.001)
        if self.alive():  # it hangs
            processes.kill(self._all(afresh=True))
            while self.alive():
                time.sleep(0.001)
        if -self.exit_code in FROM_OUTSIDE:  # perhaps not by itself, and it could not end the others
            processes.kill(self._found)
            end_orphans(self._mark)

    def close(self) -> None:
        """Close the pipes."""
        os.close(self.messages)
        assert self._keeper.stdout is not None
        self._keeper.stdout.close()

    def _all(self, afresh: bool = False) -> list[psutil.Process]:
        """Return keeper, worker and what they started, as found a second ago at most."""
        now = time.monotonic()
        if afresh or now >= self._next_search:
            self._next_search = now + SEARCH
            with contextlib.suppress(psutil.Error):
                keeper = psutil.Process(self._keeper.pid)
                self._found = [keeper, *keeper.children(recursive=True)]
        return self._found


@contextlib.contextmanager
def _handed_over(assignment: Assignment) -> Iterator[IO[bytes]]:
    """Yield a file that holds `assignment`: in memory where the system can, so that a full disk does not matter."""
    nameless = os.memfd_create("assignment") if hasattr(os, "memfd_create") else None
    with tempfile.TemporaryFile() if nameless is None else os.fdopen(nameless, "w+b") as task:
        pickle.dump(assignment, task, protocol=5)  # arrays without a copy
        task.seek(0)
        yield task
