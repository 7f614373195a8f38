"""Child: one run watched from outside: its messages, its clock, its memory. Knows no products.

What is printed goes to a log of which the end is kept. Wall clock, processor time and memory are measured here, of all
the run's processes: a run cannot tell its own.
"""

from __future__ import annotations

import contextlib
import os
import selectors
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from instances import compilation
from workbench.jobs.process.messages import (
    FOLLOWS,
    Compiling,
    Event,
    Message,
    Prepared,
    Started,
    UnreadableError,
    read_message,
)
from workbench.jobs.process.tree import Tree
from workbench.jobs.process.worker import Assignment

Hear = Callable[[float, Message | UnreadableError], None]
"""Told when a message came [s since the solve began, 0 before], and what it is, or why it is none."""
PREPARE_CPU = 300.0
"""Processor time [s] a run may take to start, import and compile: not part of the solve, but not endless either."""
PREPARE_WALL = 900.0
"""Wall clock [s] it may take for the same, on a machine that is busy."""
EXIT_GRACE = 5.0
"""Seconds a child may take to end once it has told its result."""
KILLER_GRACE = 1.0
"""Seconds between a signal from outside that ended a run and our believing that only the run was meant."""
TICK = 0.1
"""Seconds between two looks at the clock and the memory."""
PAUSE = 0.002
"""The same where both pipes are closed: the end is near."""
LONGEST_MESSAGE = 1 << 28
"""Bytes of the longest line that is still taken for a message."""
LOG_KEPT = 8192
"""Bytes kept of what the child printed."""


class InterruptedRunError(Exception):
    """The run was told to stop, its processes are gone, and there is nothing to store."""


@dataclass(frozen=True)
class Ending:
    """How a child ended, as seen from outside.

    killed : why it was killed, in words, or ""; out_of_memory : whether that was for its memory.
    exit_code : of the process; negative for a signal.
    wall, prepare, cpu [s] : start to end; start to the beginning of the solve; processor time of all processes from
    there to the result, or to the end. peak_memory : bytes. log : the end of what was printed.
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

    Killed with all it started when it outlasts PREPARE_CPU, PREPARE_WALL, its time limit by `grace`, or
    `memory_limit` [bytes]. Raises InterruptedRunError as soon as `stop()`.
    """
    child = _Child(assignment, hear, memory_limit)
    try:
        while child.tree.alive() and not child.tree.ordered:
            _stop_if(stop)
            child.watch()
    finally:
        child.end()
    if child.working and child.tree.ended_from_outside:  # perhaps with us: who is being ended too stores nothing
        until = time.monotonic() + KILLER_GRACE
        while time.monotonic() < until:
            _stop_if(stop)
            time.sleep(TICK)
    return child.ending()


def _stop_if(stop: Callable[[], bool]) -> None:
    if stop():
        raise InterruptedRunError


class _Child:
    def __init__(self, assignment: Assignment, hear: Hear, memory_limit: int) -> None:
        self.limit, self.memory_limit, self.hear = assignment.limits.time, memory_limit, hear
        self.unread, self.log = b"", b""
        self.killed, self.out_of_memory, self.compiling = "", False, False
        self.heard: type[Any] | None = None
        self.prepare, self.cpu_before, self.cpu = 0.0, 0.0, None  # type: float, float, float | None
        self.next_look = 0.0
        self.tree = Tree(assignment)
        self.deadline = self.tree.began + PREPARE_WALL
        self.selector = selectors.DefaultSelector()
        for descriptor in (self.tree.messages, self.tree.output):
            os.set_blocking(descriptor, False)
            self.selector.register(descriptor, selectors.EVENT_READ)

    @property
    def preparing(self) -> bool:
        """Whether the solve has not begun."""
        return self.heard in (None, Started, Compiling)

    @property
    def working(self) -> bool:
        """Whether it has not told how it ended."""
        return self.heard in FOLLOWS

    def watch(self) -> None:
        """Listen for one tick, then look at clock and memory."""
        for key, _ in self.selector.select(TICK if self.selector.get_map() else PAUSE):
            self._read(int(key.fd))
        now = time.monotonic()
        if now > self.deadline:
            self._outlasted(now)
        if now >= self.next_look and not self.killed:
            self.next_look = now + TICK
            self._weigh()
            if self.preparing and (cpu := self.tree.processor_time()) > PREPARE_CPU:
                self._kill(f"was still preparing (imports, compilation) after {cpu:.0f} s of processor time")

    def end(self) -> None:
        """End what is left, read the last words and close the pipes."""
        self.tree.end()
        for descriptor in (self.tree.messages, self.tree.output):
            self._read(descriptor)
        self._compiled()
        self.selector.close()
        self.tree.close()

    def ending(self) -> Ending:
        """Return how it ended."""
        cpu = self.tree.usage if self.cpu is None else self.cpu
        return Ending(
            killed=self.killed,
            out_of_memory=self.out_of_memory,
            exit_code=self.tree.exit_code,
            wall=self.tree.wall,
            prepare=self.prepare or self.tree.wall,
            cpu=max(0.0, cpu - self.cpu_before),
            peak_memory=self.tree.peak_memory,
            log=self.log.decode("utf-8", errors="replace"),
        )

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
            if descriptor == self.tree.output:
                self.log = (self.log + data)[-LOG_KEPT:]
            else:
                self._messages(data)

    def _messages(self, data: bytes) -> None:
        *lines, self.unread = (self.unread + data).split(b"\n")
        if len(self.unread) > LONGEST_MESSAGE:
            lines, self.unread = [self.unread], b""
        for line in lines:
            if not self.working:
                return
            now = time.monotonic()
            try:
                message = read_message(line)
                if not isinstance(message, FOLLOWS[self.heard]):
                    raise UnreadableError(f"{type(message).__name__.lower()!r}, which cannot come now")
            except UnreadableError as error:
                self.hear(self._elapsed(now), error)
                continue
            self.heard = type(message)
            self._follow(message, now)
            self.hear(self._elapsed(now), message)

    def _elapsed(self, now: float) -> float:
        return 0.0 if self.preparing else now - self.tree.began - self.prepare

    def _follow(self, message: Message, now: float) -> None:
        if isinstance(message, Compiling):
            self.compiling = True
            compilation.begun()
            return
        self._compiled()
        if isinstance(message, Prepared):
            self.prepare, self.deadline = now - self.tree.began, now + self.limit + grace(self.limit)
            self.cpu_before = self.tree.processor_time()
        elif not isinstance(message, (Started, Event)):
            self.deadline = now + EXIT_GRACE
            self._weigh()
            self.cpu = self.tree.processor_time(afresh=True)

    def _compiled(self) -> None:
        if self.compiling:
            self.compiling = False
            compilation.ended()

    def _outlasted(self, now: float) -> None:
        if not self.working:
            self.tree.order_end()
        elif self.preparing:
            self._kill(f"was still preparing (imports, compilation) after {PREPARE_WALL:g} s")
        else:
            after = now - self.tree.began - self.prepare
            self._kill(f"ignored its time limit of {self.limit:g} s and was killed after {after:.1f} s")

    def _weigh(self) -> None:
        """Look at the memory held: what the processes share is taken off only where that decides."""
        if self.tree.memory() <= self.memory_limit or (held := self.tree.own_memory()) <= self.memory_limit:
            return
        self.out_of_memory = not self.killed
        self._kill(f"held {held / 2**20:.0f} MB, more than its {self.memory_limit / 2**20:.0f} MB")

    def _kill(self, why: str) -> None:
        self.killed = self.killed or why
        self.tree.order_end()
