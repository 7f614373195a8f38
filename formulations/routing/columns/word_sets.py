"""Sets of tasks as rows of ⌈n/64⌉ unsigned words, so that n has no limit, and a table that finds them again.

The table is one of open addressing: a set and its last task hash to a slot, and what is taken sends on to the next.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from instances.kernels import njit

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_DE_BRUIJN = np.uint64(0x03F79D71B4CB0A89)
"""A word of 64 bits whose 64 windows of six all differ: a product with it tells which bit of a word is its lowest."""
_LOWEST = np.zeros(64, np.int64)
for _bit in range(64):
    _LOWEST[(int(_DE_BRUIJN) << _bit & 2**64 - 1) >> 58] = _bit


@njit(cache=True, nogil=True)
def has(words: NDArray[np.uint64], task: int) -> bool:
    """Say whether a set contains a task."""
    return (words[task >> 6] >> np.uint64(task & 63)) & np.uint64(1) != np.uint64(0)


@njit(cache=True, nogil=True, inline="always")
def lowest(word: np.uint64) -> int:
    """Return the place of the lowest bit of a word that is not zero."""
    return _LOWEST[((word & (~word + np.uint64(1))) * _DE_BRUIJN) >> np.uint64(58)]


@njit(cache=True, nogil=True, inline="always")
def hashed(words: NDArray[np.uint64], task: int, mask: int) -> np.int64:
    """Return the slot of a set and its last task where there are mask + 1."""
    h = np.uint64(task + 1) * _GOLDEN
    for w in range(words.size):
        h = (h ^ words[w]) * _GOLDEN
        h ^= h >> np.uint64(29)
    return np.int64(h & np.uint64(mask))


@njit(cache=True, nogil=True, inline="always")
def same(a: NDArray[np.uint64], b: NDArray[np.uint64]) -> bool:
    """Say whether two sets are equal."""
    equal = True
    for w in range(a.size):
        equal = equal and a[w] == b[w]
    return equal


@njit(cache=True, nogil=True)
def clear(visited: NDArray[np.uint64], last: NDArray[np.int16], slots: NDArray[np.int32], begin: int, end: int) -> None:
    """Take the labels begin..end−1, which are all that is in it, out of the hash table."""
    mask = slots.size - 1
    if (end - begin) * 8 > slots.size:
        slots[:] = -1
        return
    for label in range(begin, end):
        slot = hashed(visited[label], last[label], mask)
        while slots[slot] >= 0:
            slots[slot] = -1
            slot = (slot + 1) & mask
