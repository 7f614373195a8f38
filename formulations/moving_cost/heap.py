"""A binary heap of keys and items in two arrays, for kernels."""

from __future__ import annotations

from instances.arrays import Floats, Ints
from instances.kernels import njit


@njit(cache=True)
def push(keys: Floats, items: Ints, size: int, key: float, item: int) -> None:
    """Put (key, item) into a binary heap of `size` entries."""
    k = size
    while k > 0 and keys[(k - 1) // 2] > key:
        keys[k], items[k] = keys[(k - 1) // 2], items[(k - 1) // 2]
        k = (k - 1) // 2
    keys[k], items[k] = key, item


@njit(cache=True)
def pop(keys: Floats, items: Ints, size: int) -> int:
    """Take the item of the least key out of a binary heap of `size` entries."""
    top = items[0]
    key, item = keys[size - 1], items[size - 1]
    k = 0
    while 2 * k + 1 < size - 1:
        child = 2 * k + 1
        if child + 1 < size - 1 and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[k], items[k] = keys[child], items[child]
        k = child
    keys[k], items[k] = key, item
    return top
