"""Limits: what a method of any sub-problem may use."""

from __future__ import annotations

import math
from dataclasses import dataclass

from instances.errors import InputError, shown
from instances.registry import LARGEST_WHOLE

LONGEST = 1e9
"""Longest time limit [s], thirty years: engines and clocks wait no longer."""
MOST_THREADS = 1024
LARGEST_SEED = 2**31 - 1
"""The largest seed that every engine takes."""


@dataclass(frozen=True)
class Limits:
    """What a solve may use.

    Parameters
    ----------
    time
        Wall clock [s], > 0 and at most LONGEST, or infinite for no limit.
    threads
        Worker threads, from 1 to MOST_THREADS.
    iterations
        The method's own iterations (GA generations, search steps), or None for no limit. A solve ended by it is
        deterministic for a seed; one ended by the clock need not be.

    Raises
    ------
    InputError
        For a number out of range.
    """

    time: float = 60.0
    threads: int = 1
    iterations: int | None = None

    def __post_init__(self) -> None:
        if not (0 < self.time <= LONGEST or self.time == math.inf):
            raise InputError(f"time limit must be positive and at most {LONGEST:g} [s], got {shown(self.time)}")
        if not 1 <= self.threads <= MOST_THREADS:
            raise InputError(f"threads must be from 1 to {MOST_THREADS}, got {shown(self.threads)}")
        if self.iterations is not None and not 0 <= self.iterations <= LARGEST_WHOLE:
            raise InputError(f"iterations must be from 0 to {LARGEST_WHOLE}, got {shown(self.iterations)}")
