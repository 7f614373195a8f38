"""The formats of files: what each is declared as, its JSON Schema, and its keys as tables for people."""

from __future__ import annotations

import importlib
import json
from collections.abc import Mapping
from typing import Any, NamedTuple

from instances.declared.schema import schema_of
from instances.declared.tables import Key, key_tables


class FileFormat(NamedTuple):
    """One format.

    declared : variant → ``module:name`` of its declaration, or of a function of the variant that returns it.
    by : the key that says the variant, where there are several; without it the first is meant.
    extends : the format some of whose keys and tables it has, too.
    """

    about: str
    declared: Mapping[str, str]
    by: str = ""
    toml: bool = True
    extends: str = ""

    def kinds(self) -> dict[str, type]:
        """Import and return the declarations."""
        found = {}
        for variant, target in self.declared.items():
            module, _, name = target.partition(":")
            made = getattr(importlib.import_module(module), name)
            found[variant] = made if isinstance(made, type) else made(variant)
        return found


FORMATS = {
    "study": FileFormat(
        "A study of the MMMDMTSP workbench",
        {
            "routing": "workbench.problems.tables:RoutingTable",
            "placement": "workbench.problems.tables:PlacementTable",
            "moving-cost": "workbench.problems.tables:MovingCostTable",
            "survey": "workbench.problems.tables:SurveyTable",
        },
        by="problem",
    ),
    "instance": FileFormat(
        "An instance of the MMMDMTSP workbench",
        {"": "instances.declared.instance:InstanceTable"},
        toml=False,
        extends="scenario",
    ),
    "mission": FileFormat(
        "A mission of the MMMDMTSP workbench", {"": "workbench.mission.settings:MissionTable"}, extends="scenario"
    ),
    "scenario": FileFormat("A scenario of the MMMDMTSP workbench", {"": "instances.declared.scenario:ScenarioTable"}),
    "run": FileFormat(
        "A stored run of the MMMDMTSP workbench",
        dict.fromkeys(("routing", "placement", "moving-cost", "survey"), "reports.record:run_type"),
        by="problem",
        toml=False,
    ),
}
"""Format of a file → how it is declared."""


def json_schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a format; `name` is one of FORMATS."""
    found = FORMATS[name]
    return schema_of(found.kinds(), found.about, found.by)


HEAD = ["| key | takes | unit | default | meaning | example |", "|---|---|---|---|---|---|"]


def markdown(name: str) -> str:
    """Return every key of a format as tables in Markdown; what an earlier variant or format has is not said again."""
    found = FORMATS[name]
    told: set[str] = set()
    if found.extends:
        _sections(FORMATS[found.extends], told)
    lines: list[str] = []
    for heading, about, rows in _sections(found, told):
        lines += [*([f"### `{heading}`", ""] if heading else []), about, ""]
        lines += [*HEAD, *rows, ""] if rows else []
    return "\n".join(lines)


def _sections(found: FileFormat, told: set[str]) -> list[tuple[str, str, list[str]]]:
    """Return heading, words and rows of every table; what is `told` of tables and of the file itself is left out."""
    made = []
    for number, (variant, kind) in enumerate(found.kinds().items()):
        whole, *tables = key_tables(kind, toml=found.toml)
        own = [row for key in whole.keys if (row := _row(key, found.toml)) not in told]
        made.append((f'{found.by} = "{variant}"' if number else "", whole.about, own))
        told |= {*own}
        for table in tables:
            rows = [_row(key, found.toml) for key in table.keys]
            if (same := "".join([table.about, *(key.name for key in table.keys)])) not in told:
                made.append((table.heading, table.about, rows))
            told.add(same)
    return made


def _row(key: Key, toml: bool) -> str:
    default = "required" if key.required else "" if key.default is None else f"`{_inline(key.default, toml)}`"
    example = "" if key.example is None else f"`{_inline(key.example, toml)}`"
    cells = (f"`{key.name}`", key.wanted.replace(f" [{key.unit}]", ""), key.unit, default, key.meaning, example)
    escaped = (cell.replace("|", r"\|").replace("<", "&lt;") for cell in cells)
    return f"| {' | '.join(escaped)} |"


def _inline(value: Any, toml: bool) -> str:
    """Return a value on one line, as TOML or JSON writes it."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_inline(each, toml) for each in value)}]"
    if isinstance(value, dict) and toml:
        return f"{{ {', '.join(f'{key} = {_inline(each, toml)}' for key, each in value.items())} }}"
    return json.dumps(value, ensure_ascii=False)
