"""The keys of a declared file, table by table: for the documentation, for help, and for templates."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

import msgspec
from msgspec import inspect

from instances.declared.words import alternatives, peeled, words_of


class Key(NamedTuple):
    """One key: what it takes, its unit, default, meaning and an example, each None where there is none.

    given : whether a template sets it.
    """

    name: str
    wanted: str
    unit: str
    required: bool
    default: Any
    meaning: str
    example: Any
    given: bool


class KeyTable(NamedTuple):
    """A table of a file: how it is headed ("" for the file itself), what it is, and its keys."""

    heading: str
    about: str
    keys: tuple[Key, ...]


def key_tables(kind: Any, *, toml: bool = True) -> list[KeyTable]:
    """Return the tables of a declared file, each after the one that names it; `toml` : headed as TOML heads them."""
    found: dict[type, KeyTable] = {}

    def visit(node: inspect.Type, heading: str) -> None:
        for struct in _structs(node):
            if struct.cls in found:
                continue
            tag = f"{struct.tag_field} = {json.dumps(struct.tag)}" if struct.tag_field else ""
            found[struct.cls] = KeyTable(" ".join(filter(None, (heading, tag))), _about(struct), tuple(_keys(struct)))
            for each in struct.fields:
                several = any(isinstance(one, inspect.ListType) for one in alternatives(each.type))
                inside = f"{heading} {each.encode_name}".lstrip()
                visit(each.type, inside if heading or not toml else f"[[{inside}]]" if several else f"[{inside}]")

    visit(inspect.type_info(kind), "")
    return list(found.values())


def _structs(node: inspect.Type) -> list[inspect.StructType]:
    """Return the tables that a value of a type may be, or hold."""
    found = []
    for one in alternatives(node):
        if isinstance(one, inspect.StructType):
            found.append(one)
        elif isinstance(one, inspect.ListType):
            found += _structs(one.item_type)
    return found


def _keys(struct: inspect.StructType) -> Iterator[Key]:
    needed = getattr(struct.cls, "RULES", {}).get("required", ())
    for each in struct.fields:
        _, notes = peeled(each.type)
        said = each.type.extra_json_schema or {} if isinstance(each.type, inspect.Metadata) else {}
        unit = notes.get("unit", "")
        yield Key(
            each.encode_name,
            words_of(each.type),
            unit,
            each.required or each.encode_name in needed,
            _default(each),
            said.get("description", ""),
            next(iter(said.get("examples", [])), None),
            notes.get("template") != "comment",
        )


def _default(each: inspect.Field) -> Any:
    """Return the default as a file would say it; None where it says nothing."""
    value = each.default
    if value in (msgspec.NODEFAULT, msgspec.UNSET):
        value = None if each.default_factory is msgspec.NODEFAULT else each.default_factory()
    return None if isinstance(value, msgspec.Struct) or value in ({}, []) else msgspec.to_builtins(value)


def _about(struct: inspect.StructType) -> str:
    return (struct.cls.__doc__ or "").strip().splitlines()[0]
