"""How many threads numerical libraries may start on their own: as many as the solver was given, one by default.

The matrices here are small: BLAS on two cores is slower than on one, spins in the second, and rounds otherwise, so that
one seed would not give one answer.
"""

from __future__ import annotations

import os

POOLS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def with_threads(threads: int) -> dict[str, str]:
    """Return this process's environment for a child whose libraries may start `threads` threads."""
    return {**os.environ, **dict.fromkeys(POOLS, str(threads))}


def keep_to_one() -> None:
    """Let libraries loaded from now on start one thread each, unless the user has said otherwise."""
    for pool in POOLS:
        os.environ.setdefault(pool, "1")
