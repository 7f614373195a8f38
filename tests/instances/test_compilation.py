"""A kernel compiles once and says so; what it calls is compiled into it and is the same for Python."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from instances.compilation import WORDS, OnStderr, begun, ended, told_to
from instances.kernel_compiler import Kernel
from instances.kernels import njit


class Pair(NamedTuple):
    """Two arrays, as kernels are given them."""

    a: np.ndarray
    b: np.ndarray


@njit()
def _total(pair: Pair, weight: float = 2.0) -> float:
    if pair.a.size != pair.b.size:
        raise ValueError("different sizes")
    total = 0.0
    for i in range(pair.a.size):
        total += pair.a[i] + weight * pair.b[i]
    return total


@njit()
def _twice(pair: Pair) -> float:
    return _total(pair) + _total(pair, weight=3.0)


def test_a_kernel_calls_kernels_as_python_does():
    pair = Pair(np.arange(3.0), np.ones(3))
    twice = Kernel(_twice.py_func, targetoptions={"nopython": True})  # not kept: nor is it there from another day
    told: list[bool] = []
    with told_to(told.append):
        assert twice(pair) == (3.0 + 6.0) + (3.0 + 9.0)
        assert told == [True, False]  # one compilation, whatever lies inside it
        assert twice(pair) == 21.0
        assert told == [True, False]


def test_what_a_called_kernel_raises_arrives():
    with pytest.raises(ValueError, match="different sizes"):
        _twice(Pair(np.arange(3.0), np.ones(2)))


def test_it_is_said_once_where_there_is_no_terminal(capsys):
    with told_to(OnStderr()):
        for _ in range(2):
            begun()
            begun()  # inside the first
            ended()
            ended()
    assert capsys.readouterr().err == f"{WORDS}\n"
