"""Every key of a mission file, with what it takes, what it means and an example: as a list and as a file that runs.

The words are those beside each key: `instances.scenario_keys` and the metadata of `workbench.mission.settings`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, NamedTuple

from instances.scenario_keys import RADIO_KEYS, SCENARIO_KEYS, WINDS, ScenarioKey
from instances.toml_text import toml_value
from workbench.mission.settings import TABLES

OWN = {
    "scenario": ScenarioKey(
        "a file", "a scenario's keys from a file of their own, instead of here", "scenario.toml", False
    ),
    "origin": ScenarioKey(
        "[latitude, longitude] [degrees]", "of the point (0, 0); without it no files for other software", [36.0, 128.0]
    ),
}
"""Keys of a mission file beside its scenario's."""


class Described(NamedTuple):
    """One key: its table ("" for none), name, what it takes, what it means, an example, whether a template sets it."""

    table: str
    name: str
    wanted: str
    meaning: str
    example: Any
    given: bool

    @property
    def lines(self) -> list[str]:
        """The key as it stands in a file; a kind of wind with the keys of its own."""
        table = self.example if self.table == "wind" else {self.name: self.example}
        return [f"{key} = {toml_value(value)}" for key, value in table.items()]


def described() -> Iterator[Described]:
    """Yield every key of a mission file, table by table."""
    for name, key in {**SCENARIO_KEYS, **OWN}.items():
        yield Described("", name, *key)
    for kind, (meaning, example) in WINDS.items():
        yield Described("wind", "kind", "a wind", f"{kind}: {meaning}", {"kind": kind, **example}, kind == "uniform")
    for name, key in RADIO_KEYS.items():
        yield Described("radio", name, *key)
    for table, cls in TABLES.items():
        for each in fields(cls):
            about, example = each.metadata, each.metadata["example"]
            given = example == _default(each)
            yield Described(table, each.name, about["wanted"], about["meaning"], example, given)


def template() -> str:
    """Return a mission file with every key: those that need a value or have one are set, the others are comments."""
    lines = ["# A mission: workbench mission THIS.toml --out FOLDER. Files are relative to this one.", ""]
    table = ""
    for key in described():
        if key.table != table:
            table = key.table
            lines += ["", f"[{table}]"]
        lines.append(f"# {key.meaning} ({key.wanted})")
        lines += key.lines if key.given else [f"# {line}" for line in key.lines]
    return "\n".join(lines) + "\n"


def _default(each: Any) -> Any:
    return each.default_factory() if callable(each.default_factory) else each.default
