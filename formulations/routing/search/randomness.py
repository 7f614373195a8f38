"""Random numbers for the kernels: xorshift64* (Vigna 2016) on a one-word state that the caller owns.

A state of our own makes a run repeatable for a seed whatever else runs in the process, and lets two threads search
at once (numba's generators are shared by the functions of a thread).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from instances.kernels import njit

_SHIFT_A, _SHIFT_B, _SHIFT_C, _SHIFT_U = np.uint64(12), np.uint64(25), np.uint64(27), np.uint64(11)
_MULTIPLIER = np.uint64(2685821657736338717)
_UNIT = 2.0**-53


Rng = NDArray[np.uint64]
"""A state, shape (1,)."""


def seeded(*seed: int) -> Rng:
    """Return a fresh state from whole numbers such as (seed, thread)."""
    word = np.random.SeedSequence([abs(s) for s in seed]).generate_state(1, np.uint64)
    return np.maximum(word, np.uint64(1))


@njit(cache=True, nogil=True)
def uniform(state: Rng) -> float:
    """Draw from [0, 1)."""
    x = state[0]
    x ^= x >> _SHIFT_A
    x ^= x << _SHIFT_B
    x ^= x >> _SHIFT_C
    state[0] = x
    return ((x * _MULTIPLIER) >> _SHIFT_U) * _UNIT


@njit(cache=True, nogil=True)
def below(state: Rng, n: int) -> int:
    """Draw a whole number from 0..n−1."""
    return int(uniform(state) * n)
