"""What a mission may say: every key of every table with values nobody should write: a sentence or a use."""

from __future__ import annotations

import datetime
import math
from pathlib import Path
from typing import Any

import pytest

from instances.errors import InputError
from workbench.mission.file import mission_of
from workbench.mission.fitting import refuse_plugins
from workbench.mission.settings import TABLES
from workbench.mission.stamp import referenced_files

TABLE: dict[str, Any] = {
    "airspeed": 100.0,
    "size": [4000, 4000],
    "depots": [[500, 500], [3500, 500]],
    "tasks": 6,
    "radio": {"position": [2000, 2000]},
}
NEVER = [math.nan, math.inf, -math.inf, 1e308, 10**400, 1 << 20_000, "", {"a": 1}, [[]], datetime.date(1979, 5, 27)]
PERHAPS = [1e-320, 0, -1, 10**20, True, "x" * 10_000, "a\0b", [], {}, ".", ":x", "x:", "builtins:exit", "5:x", [1, [2]]]
KEYS = [f"{table}.{each}" for table, cls in TABLES.items() for each in cls.__struct_fields__]


@pytest.mark.filterwarnings("error::RuntimeWarning")
def sentence_on(value: Any, where: str, folder: Path) -> str:
    """Return what the mission with this value is refused with, or "" where it is not."""
    table, key = where.split(".")
    try:
        mission_of(TABLE | {table: {key: value}}, folder, "m")
    except InputError as refused:
        return str(refused)
    return ""


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("where", KEYS)
def test_every_key_is_used_or_refused_in_one_sentence(tmp_path: Path, where: str) -> None:
    never = [sentence_on(value, where, tmp_path) for value in NEVER]
    assert all(never)
    assert not any("\n" in sentence for sentence in never)
    assert not any("\n" in sentence_on(value, where, tmp_path) for value in PERHAPS)


@pytest.mark.parametrize("key", ["tasks", "airspeed", "origin", "scenario"])
def test_keys_of_the_mission_itself(tmp_path: Path, key: str) -> None:
    for value in [math.nan, math.inf, 1e308, 10**400, "", [[]], {"a": 1}, -1, 0, "x" * 10_000]:
        with pytest.raises(InputError) as refused:
            mission_of(TABLE | {key: value}, tmp_path, "m")
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "changes",
    [{"place": {"method": "os:abort"}}, {"costs": {"method": "os:abort"}}, {"routes": {"solver": "os:abort"}}],
)
def test_code_of_others_is_refused_where_asked(changes: dict[str, Any]) -> None:
    mission = mission_of(TABLE | changes, Path(), "m")  # not imported: we are still here
    with pytest.raises(InputError, match=r"--no-plugins: .* = 'os:abort' is not built in"):
        refuse_plugins(mission)
    refuse_plugins(mission_of(TABLE, Path(), "m"))


@pytest.mark.parametrize("text", ["x" * 400, "a\0b", "\udcff"], ids=["long", "zero", "bytes"])
def test_a_text_that_no_file_can_be_named_is_none(tmp_path: Path, text: str) -> None:
    assert referenced_files({"provenance": {"about": text}}, tmp_path) == {}
