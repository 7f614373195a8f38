"""Every key of a mission file, with what it takes, what it means and an example: as a list and as a file that runs.

The words are those of the declaration, `workbench.mission.settings.MissionTable`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from instances.declared.tables import Key, KeyTable, key_tables
from instances.toml_text import toml_value
from workbench.mission.settings import MissionTable

WINDS = "[wind] kind = "
"""What heads the table of a kind of wind."""


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
    whole, *tables = key_tables(MissionTable)
    headed = {f"[{key.name}]" for key in whole.keys}
    stages = [table for table in tables if table.heading in headed]
    said = {"[wind]", *(table.heading for table in stages)}
    yield from (_described("", key) for key in whole.keys if f"[{key.name}]" not in said)
    yield from (_wind(table) for table in tables if table.heading.startswith(WINDS))
    for table in stages:
        yield from (_described(table.heading.strip("[]"), key) for key in table.keys)


def _described(table: str, key: Key) -> Described:
    """Return a key; a template sets it where it is needed or its example is its default."""
    example = key.default if key.example is None else key.example
    unsaid = key.default is None and not key.required and table not in ("", "radio")
    given = key.given and not unsaid and (table in ("", "radio") or example == key.default)
    return Described(table, key.name, key.wanted, key.meaning, example, given)


def _wind(table: KeyTable) -> Described:
    """Return a kind of wind as one key: its example holds what it needs, and what its template sets."""
    kind = table.heading.removeprefix(WINDS).strip('"')
    example = {"kind": kind} | {key.name: key.example for key in table.keys if key.given}
    takes = "; ".join(f"{key.name}{f' [{key.unit}]' if key.unit else ''}: {key.meaning}" for key in table.keys)
    return Described("wind", "kind", takes, f"{kind}: {table.about.rstrip(chr(46))}", example, kind == "uniform")


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
