"""Computed indices of our kernels count from the front; constants, and indices of others' kernels, as numpy's do."""

from __future__ import annotations

from types import FunctionType
from typing import Any

import numpy as np
import pytest

from instances.kernels import njit


def _read(x: np.ndarray, i: int) -> float:
    return float(x[i])


def _read_twice(table: np.ndarray, i: int) -> float:
    return float(table[0, i] + 100.0 * table[0][i])


def _write(x: np.ndarray, i: int) -> float:
    x[i] = 100.0
    return float(x[-1])


def _last(table: np.ndarray, i: int) -> float:
    return float(table[i, -1] + 100.0 * table[-1, i] + 1e4 * table[-1][-1])


def _kernel(function: Any, module: str) -> Any:
    """Return the kernel that `function` would be in another module."""
    copy = FunctionType(function.__code__, function.__globals__)
    copy.__module__, copy.__qualname__ = module, f"{module.replace('.', '_')}{function.__name__}"
    return njit()(copy)


OURS, THEIRS = "instances.kernels", "numpy"


@pytest.mark.parametrize(("module", "found"), [(OURS, 4.0), (THEIRS, 9.0)])
def test_a_computed_index_of_ours_counts_from_the_front(module: str, found: float) -> None:
    part = np.arange(10.0)[5:]
    assert _kernel(_read, module)(part, -1) == found
    assert _kernel(_read_twice, module)(part.reshape(1, 5), -1) == 101.0 * found


@pytest.mark.parametrize(("module", "left"), [(OURS, 9.0), (THEIRS, 100.0)])
def test_so_does_one_that_is_written_to(module: str, left: float) -> None:
    whole = np.arange(10.0)
    assert _kernel(_write, module)(whole[5:], -1) == left
    assert whole[4 if module == OURS else 9] == 100.0


@pytest.mark.parametrize("module", [OURS, THEIRS])
def test_constants_count_from_either_end(module: str) -> None:
    assert _kernel(_last, module)(np.arange(6.0).reshape(2, 3), 1) == 5.0 + 400.0 + 5e4
