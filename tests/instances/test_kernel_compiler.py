"""Kernels call large kernels where they lie, kept or not, and leave as many references to arrays as there were."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numba.np import arraymath, linalg

from instances.kernel_compiler import load_arrays
from instances.kernels import njit

LARGE = "".join(f"    total += x[{i}] * x[{i}] if x[{i}] < {i}.5 else x[{i + 1}]\n" for i in range(40))
MODULE = f"""
from instances.kernels import njit

@njit()
def large(x):
    total = 0.0
{LARGE}    return total

@njit()
def caller(x):
    return 1.0 + large(x)

@njit()
def another(x):
    return 2.0 + large(x)
"""
SCRIPT = """
import sys
import numpy as np
import instances.compilation as compilation
told = []
with compilation.told_to(told.append):
    import planned
    print(getattr(planned, sys.argv[1])(np.arange(41.0)), sum(told))
assert "scipy.linalg" not in sys.modules
"""
RIGHT = float(np.sum(np.arange(40.0) ** 2))


def test_a_large_kernel_is_called_by_kept_machine_code_unless_it_is_another(tmp_path: Path) -> None:
    (tmp_path / "planned.py").write_text(MODULE)
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    env["NUMBA_CACHE_DIR"] = str(tmp_path / "kept")

    def run(kernel: str) -> tuple[float, int]:
        """Return what a kernel returns in a process of its own, and how often something was compiled."""
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT, kernel], env=env, capture_output=True, text=True, check=True
        )
        value, compiled = done.stdout.split()
        return float(value), int(compiled)

    assert run("caller") == (1.0 + RIGHT, 1)
    assert run("caller") == (1.0 + RIGHT, 0)
    for path in tmp_path.glob("kept/**/planned.large-*"):
        path.unlink()
    assert run("another") == (2.0 + RIGHT, 1)  # and with it `large`, under another name than `caller` knows
    assert run("caller") == (1.0 + RIGHT, 1)


def test_numba_looks_for_linear_algebra_where_it_is_called() -> None:
    load_arrays()
    assert linalg.ensure_blas.__module__ == linalg.__name__
    assert arraymath._HAVE_BLAS


class Two(NamedTuple):
    """Two arrays."""

    a: np.ndarray
    b: np.ndarray


@njit()
def _exchanged(two: Two) -> Two:
    return Two(two.b, two.a)


@njit()
def _rows(table: np.ndarray) -> float:
    total = 0.0
    for row in table:
        total += row[1:].sum()
    return total


@njit()
def _second(table: np.ndarray) -> np.ndarray:
    return table[1]


@njit()
def _only_borrows(two: Two, rounds: int) -> float:
    a, b = two.a, two.b
    for _ in range(rounds):
        a, b = b, a
    return a[0] - b[0] + Two(b, a).a[-1]


@njit()
def _all(two: Two) -> float:
    exchanged = _exchanged(two)
    table = np.vstack((exchanged.a, two.b))
    order = np.argsort(-_second(table))
    return _rows(table) + _second(table)[order][0] + _only_borrows(exchanged, 3)


@njit()
def _of_list(numbers: list[np.ndarray]) -> float:
    return numbers[0][1] + numbers[1][1]


@njit()
def _refuses(two: Two) -> float:
    if two.a[0] < two.b[0]:
        raise ValueError("less")
    return 0.0


def test_references_are_as_many_as_before() -> None:
    two = Two(np.arange(4.0), np.arange(4.0) + 5.0)
    before = sys.getrefcount(two.a), sys.getrefcount(two.b)
    for _ in range(50):
        assert _all(two) == 2.0 * (6.0 + 7.0 + 8.0) + 8.0 + (0.0 - 5.0 + 8.0)
        assert _exchanged(two).a is not None
        assert _second(np.vstack(two)).base is not None
        with pytest.raises(ValueError, match="less"):
            _refuses(two)
    assert (sys.getrefcount(two.a), sys.getrefcount(two.b)) == before


@pytest.mark.filterwarnings("ignore::numba.core.errors.NumbaPendingDeprecationWarning")
def test_a_list_is_taken_too() -> None:
    assert _of_list([np.arange(3.0), np.arange(3.0)]) == 2.0


def test_what_a_kernel_returns_stays_when_its_arguments_are_gone() -> None:
    kept = [_second(np.full((2, 1000), float(i))) for i in range(200)]
    assert [row.sum() for row in kept] == [1000.0 * i for i in range(200)]
