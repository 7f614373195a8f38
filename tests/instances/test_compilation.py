"""A kernel compiles once and says so; what it calls is compiled into it and is the same for Python."""

from __future__ import annotations

import gc
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


@njit()
def _first(a: float, *others: float) -> float:
    return a + others[0]


@njit()
def _first_of_two(a: float, b: float) -> float:
    return _first(a, b)


def test_a_kernel_calls_kernels_as_python_does():
    pair = Pair(np.arange(3.0), np.ones(3))
    twice = Kernel(_twice.py_func, targetoptions={"nopython": True})  # not kept: nor is it there from another day
    told: list[bool] = []
    with told_to(told.append):
        assert twice(pair) == (3.0 + 6.0) + (3.0 + 9.0)
        assert told == [True, False]  # one compilation, whatever lies inside it
        assert twice(pair) == 21.0
        assert told == [True, False]


def test_for_python_it_is_a_call_of_what_kernels_call(monkeypatch):
    pair = Pair(np.arange(3.0), np.ones(3))
    assert _twice(pair) == 21.0
    inside = Kernel(_total.py_func, targetoptions={"nopython": True})  # not kept: it has to be compiled
    inside.inner = _total.inner
    monkeypatch.setitem(globals(), "_total", inside)
    assert inside(pair) == 3.0 + 6.0
    assert inside(pair, 3.0) == inside(pair, weight=3.0) == 3.0 + 9.0
    assert inside(pair, 3) == 3.0 + 9.0  # of a whole number no kernel is called yet
    usual, given, whole = ({step.op for step in found.fndesc.calltypes} for found in inside.overloads.values())
    assert usual == given == {"call"}
    assert whole > {"binop", "call"}


def test_any_number_of_arguments_is_handed_on():
    assert _first_of_two(7.0, 8.0) == 15.0
    assert _first(7.0, 8.0) == 15.0


def test_garbage_is_looked_for_again_after_a_compilation():
    compiled = Kernel(_total.py_func, targetoptions={"nopython": True})
    assert compiled(Pair(np.arange(3.0), np.ones(3))) == 9.0
    assert gc.isenabled()
    gc.disable()
    try:
        assert compiled(Pair(np.arange(3.0), np.ones(3)), 3.0) == 12.0
        assert not gc.isenabled()
    finally:
        gc.enable()


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
