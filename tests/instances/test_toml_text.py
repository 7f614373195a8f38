"""What is written as TOML reads back the same."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instances.errors import InputError
from instances.toml_text import toml_text, toml_value

NUMBERS = st.one_of(st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False), st.booleans())
VALUES = st.recursive(
    NUMBERS | st.text(st.characters(exclude_categories=["Cs"]), max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text('ab" .\n,[]', max_size=4), inner, max_size=3),
    max_leaves=12,
)


@settings(deadline=None, max_examples=200)
@given(st.dictionaries(st.text('ab" .\n,[]', max_size=4), VALUES, max_size=4))
def test_there_and_back(table):
    text = toml_text(table)
    assert tomllib.loads(text) == table
    assert all(f"\n{part}" not in text for part in (" ", "]"))  # no list over several lines


@settings(deadline=None, max_examples=100)
@given(VALUES)
def test_a_value_is_one_line(value):
    text = toml_value(value)
    assert "\n" not in text
    assert tomllib.loads(f"key = {text}")["key"] == value


def test_numpy_paths_and_what_is_not_there():
    table = {"a": np.float64(1 / 3), "b": np.array([[1, 2], [3, 4]]), "c": Path("d/e"), "f": None, "g": {"h": None}}
    assert tomllib.loads(toml_text(table)) == {"a": 1 / 3, "b": [[1, 2], [3, 4]], "c": "d/e", "g": {}}
    assert toml_value({"kind": "uniform", "velocity": [-5.0, 0.0]}) == '{ kind = "uniform", velocity = [-5.0, 0.0] }'


def test_what_toml_has_no_place_for():
    with pytest.raises(InputError, match="1j cannot be written as TOML"):
        toml_text({"a": 1j})
