"""Processes: who descends from whom, and the processor time and memory of a whole tree; nothing raises for one gone."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from collections.abc import Iterable
from pathlib import Path

import psutil

LINUX = sys.platform == "linux"


def kill(processes: Iterable[psutil.Process]) -> None:
    """Send SIGKILL to each that still is the process it was (psutil compares the time of its start)."""
    for process in processes:
        with contextlib.suppress(psutil.Error):
            process.send_signal(signal.SIGKILL)


def processor_time(processes: Iterable[psutil.Process]) -> float:
    """Return the processor time [s] so far, with that of their children that have ended."""
    total = 0.0
    for process in processes:
        with contextlib.suppress(psutil.Error, OSError):
            times = process.cpu_times()
            ended = times.children_user + times.children_system  # in hundredths; the process's own in nanoseconds
            total += ended + (_precise(process.pid) if LINUX else times.user + times.system)
    return total


def _precise(pid: int) -> float:
    """Return the processor time [s] of a process, all threads, by its own clock (man 3 clock_getcpuclockid)."""
    return time.clock_gettime((~pid << 3) | 2)


def memory(processes: Iterable[psutil.Process], *, shared: bool = True) -> int:
    """Return the memory held [bytes]; without what is `shared` between processes it takes longer."""
    total = 0
    for process in processes:
        with contextlib.suppress(psutil.Error, OSError):
            total += process.memory_info().rss if shared else process.memory_full_info().uss
    return total


def most_memory(pid: int) -> int:
    """Return the most memory process `pid` has held [bytes], 0 where the system does not tell."""
    try:
        lines = (Path("/proc") / str(pid) / "status").read_text().splitlines()
    except OSError:
        return 0
    return next((int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:")), 0)


def own_children() -> list[psutil.Process]:
    """Return the children of this process."""
    try:
        return psutil.Process(os.getpid()).children()
    except psutil.Error:
        return []
