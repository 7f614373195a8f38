"""What is left of a study: processes, told by a variable of their environment or by what they were started to do."""

from __future__ import annotations

import os
import time
from pathlib import Path

import psutil

from tests.faults.hostile_processes import FOREVER

TOKEN = "WORKBENCH_FAULTS"
"""Variable of the environment that every process of a study under test inherits."""


def processes_with(token: str) -> list[psutil.Process]:
    """Return the living processes, but this one, that hold `token` or have hidden and sleep for ever."""
    mark, asleep, found = f"{TOKEN}={token}".encode(), str(FOREVER).encode(), []
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit() or int(folder.name) == os.getpid():
            continue
        try:
            ours = mark in (folder / "environ").read_bytes().split(b"\0")
            hidden = asleep in (folder / "cmdline").read_bytes().split(b"\0")
            process = psutil.Process(int(folder.name)) if ours or hidden else None
            if process and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
        except (OSError, psutil.Error):
            continue
    return found


def left_after(token: str, seconds: float) -> list[str]:
    """Return what still runs after `seconds`, or as soon as nothing does, and end it."""
    until = time.monotonic() + seconds
    while (found := processes_with(token)) and time.monotonic() < until:
        time.sleep(0.05)
    told = []
    for process in found:
        try:
            told.append(f"{process.pid} {' '.join(process.cmdline())[:200]}")
            process.kill()
        except psutil.Error:
            continue
    return told
