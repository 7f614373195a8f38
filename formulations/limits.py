"""Limits: what a method of any sub-problem may use."""

from __future__ import annotations

from dataclasses import dataclass

from instances.errors import InputError


@dataclass(frozen=True)
class Limits:
    """What a solve may use.

    time : seconds of wall clock, > 0.
    threads : worker threads, ≥ 1.
    iterations : the method's own iterations (GA generations, search steps), or None for no limit. A solve ended
        by it is deterministic for a seed; one ended by the clock need not be.
    """

    time: float = 60.0
    threads: int = 1
    iterations: int | None = None

    def __post_init__(self) -> None:
        if not self.time > 0:
            raise InputError(f"time limit must be positive [s], got {self.time}")
        if self.threads < 1:
            raise InputError(f"threads must be at least 1, got {self.threads}")
        if self.iterations is not None and self.iterations < 0:
            raise InputError(f"iterations must not be negative, got {self.iterations}")
