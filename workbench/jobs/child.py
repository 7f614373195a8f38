"""Child: the process of one run, watched from outside. Knows processes, pipes, clocks and signals; no products.

The child runs in a session of its own, so that the whole group can be killed. Messages come over a pipe of their
own; what is printed goes to a log of which the end is kept.
"""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import selectors
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import psutil

from workbench.jobs.worker import Assignment
from workbench.threads import with_threads

Hear = Callable[[dict[str, Any]], None]
"""Takes a message of the child."""
PREPARE_LIMIT = 300.0
"""Seconds a child may take to start, import and compile: not part of the solve, but not endless either."""
EXIT_GRACE = 5.0
"""Seconds a child may take to end once it has told its result."""
TICK = 0.1
"""Seconds between two looks at the clock and the memory."""
SEARCH = 1.0
"""Seconds between two searches for processes that the child started."""
LONGEST_MESSAGE = 1 << 26
"""Bytes of the longest line that is still taken for a message."""
LOG_KEPT = 8192
"""Bytes kept of what the child printed."""
SPEAKING = {"PYTHONFAULTHANDLER": "1", "PYTHONUNBUFFERED": "1"}
"""Environment in which a crash leaves a trace."""


class InterruptedRunError(Exception):
    """The run was told to stop, its process group is gone, and there is nothing to store."""


@dataclass(frozen=True)
class Ending:
    """How a child ended, as seen from outside.

    killed : why it was killed, in words, or ""; out_of_memory : whether that was for its memory.
    exit_code : of the process; negative for a signal.
    wall, prepare, cpu [s] : start to end; start to the beginning of the solve; CPU since the solve began.
    peak_memory : bytes. log : the end of what was printed.
    """

    killed: str
    out_of_memory: bool
    exit_code: int
    wall: float
    prepare: float
    cpu: float
    peak_memory: int
    log: str


def grace(limit: float) -> float:
    """Return how long after its time limit [s] a solver is killed [s]: 5 s + 10 %."""
    return 5.0 + 0.1 * limit


def run_child(assignment: Assignment, hear: Hear, *, memory_limit: int, stop: Callable[[], bool]) -> Ending:
    """Run `assignment` in a fresh process, passing each of its messages to `hear` as it comes.

    Killed with its whole group when it outlasts PREPARE_LIMIT, its time limit by `grace`, or `memory_limit` [bytes].
    Raises InterruptedRunError as soon as `stop()`.
    """
    child = _Child(assignment, hear, memory_limit)
    try:
        while child.alive():
            if stop():
                raise InterruptedRunError
            child.watch()
    finally:
        child.end()
    return child.ending()


class _Child:
    def __init__(self, assignment: Assignment, hear: Hear, memory_limit: int) -> None:
        self.limit, self.memory_limit, self.hear = assignment.limits.time, memory_limit, hear
        self.unread, self.log = b"", b""
        self.killed, self.out_of_memory = "", False
        self.peak, self.cpu_before, self.prepare = 0, 0.0, 0.0
        self.phase, self.usage = "preparing", 0.0
        self.next_weighing, self.next_search = 0.0, 0.0
        self.offspring: list[psutil.Process] = []
        self.began = time.monotonic()
        self.deadline = self.began + PREPARE_LIMIT
        pipe, childs_end = os.pipe()
        with tempfile.TemporaryFile() as task:
            pickle.dump(assignment, task)
            task.seek(0)
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-m", "workbench.jobs.worker", str(childs_end)],
                stdin=task,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                pass_fds=(childs_end,),
                env=with_threads(assignment.limits.threads) | SPEAKING,
                start_new_session=True,
            )
        os.close(childs_end)
        self.pipe = pipe
        assert self.process.stdout is not None
        self.output = self.process.stdout.fileno()
        self.selector = selectors.DefaultSelector()
        for descriptor in (self.pipe, self.output):
            os.set_blocking(descriptor, False)
            self.selector.register(descriptor, selectors.EVENT_READ)

    def alive(self) -> bool:
        """Return whether the process still runs; when it has just ended, take its CPU time and last words."""
        if self.process.returncode is None:
            pid, status, usage = os.wait4(self.process.pid, os.WNOHANG)
            if pid == 0:
                return True
            self._gone(status, usage.ru_utime + usage.ru_stime)
        return False

    def watch(self) -> None:
        """Listen for one tick, then look at memory and clock."""
        for key, _ in self.selector.select(TICK):
            self._read(int(key.fd))
        self._weigh()
        if time.monotonic() > self.deadline and not self.killed:
            if self.phase == "preparing":
                self.killed = f"was still preparing (imports, compilation) after {PREPARE_LIMIT:g} s"
            elif self.phase == "solving":
                after = time.monotonic() - self.began - self.prepare
                self.killed = f"ignored its time limit of {self.limit:g} s and was killed after {after:.1f} s"
            self._kill()

    def end(self) -> None:
        """Kill what is left of the group, wait for the process, read its last words and close the pipes."""
        self._kill()
        if self.process.returncode is None:
            _, status, usage = os.wait4(self.process.pid, 0)
            self._gone(status, usage.ru_utime + usage.ru_stime)
        for descriptor in (self.pipe, self.output):
            self._read(descriptor)
        self.selector.close()
        os.close(self.pipe)
        assert self.process.stdout is not None
        self.process.stdout.close()

    def ending(self) -> Ending:
        """Return how it ended."""
        return Ending(
            killed=self.killed,
            out_of_memory=self.out_of_memory,
            exit_code=int(self.process.returncode or 0),
            wall=self.wall,
            prepare=self.prepare or self.wall,
            cpu=max(0.0, self.usage - self.cpu_before),
            peak_memory=self.peak,
            log=self.log.decode("utf-8", errors="replace"),
        )

    def _gone(self, status: int, usage: float) -> None:
        self.process.returncode = os.waitstatus_to_exitcode(status)
        self.wall, self.usage = time.monotonic() - self.began, usage

    def _read(self, descriptor: int) -> None:
        """Read what is in one pipe, a few MB at most before the next look at the clock: a child can print for ever."""
        for _ in range(64):
            try:
                data = os.read(descriptor, 1 << 16)
            except BlockingIOError:
                return
            if not data:
                with contextlib.suppress(KeyError):
                    self.selector.unregister(descriptor)
                return
            if descriptor == self.output:
                self.log = (self.log + data)[-LOG_KEPT:]
            else:
                self._messages(data)

    def _messages(self, data: bytes) -> None:
        *lines, self.unread = (self.unread + data).split(b"\n")
        if len(self.unread) > LONGEST_MESSAGE:
            lines, self.unread = [self.unread], b""
        for line in lines:
            try:
                message = json.loads(line)
                self._follow(message)
                self.hear(message)
            except (ValueError, KeyError, TypeError, AttributeError):  # whatever foreign code wrote into the pipe
                self.hear({"kind": "rubbish", "line": line[:80].decode("utf-8", errors="replace")})

    def _follow(self, message: dict[str, Any]) -> None:
        kind = message["kind"]
        if kind == "prepared":
            self.phase, self.prepare = "solving", time.monotonic() - self.began
            self.cpu_before = message["cpu"]
            self.deadline = time.monotonic() + self.limit + grace(self.limit)
        elif kind in ("result", "declined", "error"):
            self.phase, self.deadline = "done", time.monotonic() + EXIT_GRACE
            self.peak = max(self.peak, message.get("peak_memory", 0))

    def _weigh(self) -> None:
        """Look at the memory held, once a tick; less often for processes the child started, as that takes longer."""
        now = time.monotonic()
        if now < self.next_weighing:
            return
        self.next_weighing = now + TICK
        with contextlib.suppress(psutil.Error):
            leader = psutil.Process(self.process.pid)
            if now >= self.next_search:
                self.offspring, self.next_search = leader.children(recursive=True), now + SEARCH
            held = leader.memory_info().rss
            for other in self.offspring:
                with contextlib.suppress(psutil.Error):
                    held += other.memory_info().rss
            self.peak = max(self.peak, held)
            if held > self.memory_limit and not self.killed:
                self.killed = f"held {held / 2**20:.0f} MB, more than its {self.memory_limit / 2**20:.0f} MB"
                self.out_of_memory = True
                self._kill()

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signal.SIGKILL)
