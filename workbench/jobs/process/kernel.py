"""What is asked of Linux for this process; elsewhere nothing happens."""

from __future__ import annotations

import ctypes
import signal
import sys
from pathlib import Path

_LINUX = sys.platform == "linux"


def adopt_descendants() -> bool:
    """Be the parent of what loses its own below this process (a child subreaper, man 2 prctl); return whether it is."""
    return _LINUX and not _process_control(36, 1)


def die_with_parent() -> None:
    """Be killed when the thread that forked this process ends."""
    if _LINUX:
        _process_control(1, signal.SIGKILL)


def be_first_to_free_memory() -> None:
    """Be the kernel's first choice where memory runs out."""
    if _LINUX:
        Path("/proc/self/oom_score_adj").write_text("1000")


def _process_control(option: int, value: int) -> int:
    return int(ctypes.CDLL(None).prctl(option, ctypes.c_ulong(value)))
