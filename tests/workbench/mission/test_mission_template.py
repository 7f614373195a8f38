"""Every key of a mission file says what it means: in the help, and in a template that loads."""

from __future__ import annotations

import tomllib
from dataclasses import fields
from pathlib import Path

import pytest
from click.testing import CliRunner

from instances.declared.reading import read_declared
from instances.declared.scenario import RadioTable
from instances.environment.radio import RadioSource
from instances.environment.wind_table import KINDS, wind_from_toml
from workbench.commands.mission import command
from workbench.mission.file import mission_of
from workbench.mission.settings import TABLES, MissionTable
from workbench.mission.template import Described, described, template

ALL = list(described())
TABLE_KEYS = {(table, name) for table, cls in TABLES.items() for name in cls.__struct_fields__}
WINDS = {key.example["kind"]: key.example for key in ALL if key.table == "wind"}


def test_no_key_goes_without_a_description() -> None:
    names = {key.name for key in ALL if not key.table} | {key.table for key in ALL if key.table}
    assert names == set(MissionTable.__struct_encode_fields__)
    assert {(key.table, key.name) for key in ALL if key.table in TABLES} == TABLE_KEYS
    assert set(WINDS) == set(KINDS)
    assert set(RadioTable.__struct_fields__) == {each.name for each in fields(RadioSource)}
    for key in ALL:
        assert key.meaning, f"{key.table}.{key.name} has no meaning"
        assert key.wanted, f"{key.table}.{key.name} does not say what it takes"
        assert key.example is not None, f"{key.table}.{key.name} has no example"


@pytest.mark.parametrize("key", [key for key in ALL if key.table in TABLES], ids=lambda key: f"{key.table}.{key.name}")
def test_examples_are_values_the_key_takes(key: Described) -> None:
    read_declared(TABLES[key.table], {key.name: key.example})


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("grid", "terrain")])
def test_winds_of_the_template_blow(kind: str) -> None:
    assert wind_from_toml(WINDS[kind])([[0.0, 0.0]]).shape == (1, 2)


def test_the_template_is_a_mission_with_the_defaults() -> None:
    mission = mission_of(tomllib.loads(template()), Path(), "template")
    assert all(getattr(mission, table) == cls() for table, cls in TABLES.items())
    assert mission.scenario.n_tasks == 40


def test_every_key_stands_in_the_template_and_in_the_help() -> None:
    told, shown = (CliRunner().invoke(command, [flag], terminal_width=200).output for flag in ("--help", "--template"))
    assert shown == template()
    lines = shown.splitlines()
    for key in ALL:
        assert any(line.removeprefix("# ") == key.lines[0] for line in lines), key
        assert key.meaning[:30] in told
        assert f"{key.lines[0]}"[:40] in told
    for unit in ("[m]", "[s]", "[m/s]", "[Hz]", "[dB]"):
        assert unit in told
        assert unit in shown
