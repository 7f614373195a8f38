"""Reading a parsed file as what it is declared to be: msgspec validates, what it refuses is one sentence.

The sentence names the key as it stands in the file, the value, what is allowed, and the near miss:

    [wind] velocity must be two numbers [m/s], got [1]
    [[uav]] 2: unknown key 'spede'; did you mean 'speed'? (known: depot, count, speed, endurance)

Tables of a list are counted from 1, as people do; entries of other lists from 0, as everything else here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple, TypeVar

import msgspec
from msgspec import inspect

from instances.declared.prepared import prepared
from instances.declared.words import alternatives, names_of, peeled, words_of
from instances.errors import InputError, shown, suggestion

T = TypeVar("T")
Token = str | int

_PLACE = re.compile(r" - at (?:`key` in )?`\$(.*)`$")
_STEP = re.compile(r"\.([^.\[]+)|\[(\d+)\]")
_LIKE: dict[type, tuple[type[inspect.Type], ...]] = {
    list: (inspect.ListType, inspect.VarTupleType, inspect.TupleType),
    str: (inspect.EnumType, inspect.LiteralType),
}
"""Kind of value → types that look into it, among several."""
_LONGEST_LIST = 12
"""Keys that a sentence lists."""


class Node(NamedTuple):
    """A value on the way to what is wrong: its type, and the unit said on it or above it."""

    type: inspect.Type
    value: Any
    unit: str = ""


def read_declared(kind: type[T], value: Any, *, at: Sequence[Token] = (), toml: bool = True) -> T:
    """Return `value` as `kind`, a declaration; InputError names the key, the value, and what is allowed.

    at : where in the file `value` stands. toml : whether keys are named as TOML writes them.
    """
    try:
        return msgspec.convert(value, prepared(kind))
    except msgspec.ValidationError as error:
        raise InputError(_sentence(kind, value, error, at, toml)) from None


def given(table: msgspec.Struct) -> dict[str, Any]:
    """Return the fields of a table that say something, tables in it as mappings."""
    found = {name: getattr(table, name) for name in table.__struct_fields__}
    return {
        name: given(each) if isinstance(each, msgspec.Struct) else each
        for name, each in found.items()
        if each is not None
    }


def _sentence(kind: type, value: Any, error: msgspec.ValidationError, at: Sequence[Token], toml: bool) -> str:
    told = str(error)
    found = _PLACE.search(told)
    path: list[Token] = [name or int(number) for name, number in _STEP.findall(found[1] if found else "")]
    path, node = _walked(Node(_declared(kind), value), path)
    whole: Any = value
    for token in reversed(at):
        whole = {token: whole} if isinstance(token, str) else [whole]
    name = _spelt([*at, *path], whole, toml, _heading(node.type)) if at or path else ""
    if isinstance(error.__cause__, ValueError):
        return f"{name}: {error.__cause__}" if name else str(error.__cause__)
    inner = _alternative(node)
    if isinstance(inner, inspect.StructType) and isinstance(node.value, Mapping):
        return _wrong_keys(node.type, inner, node.value, name)
    if not name:
        return f"must hold a {'TOML table' if toml else 'JSON object'}, got {type(node.value).__name__}"
    near = ""
    if isinstance(inner, (inspect.EnumType, inspect.LiteralType)) and isinstance(node.value, str):
        near = suggestion(node.value, map(str, names_of(inner)))
    return f"{name} must be {words_of(node.type, node.unit, node.value)}, got {shown(node.value)}{near}"


@cache
def _declared(kind: type) -> inspect.Type:
    """Return what `kind` declares; msgspec reads all its annotations anew each time, 35 ms for a mission."""
    return inspect.type_info(kind)


def _walked(node: Node, path: list[Token]) -> tuple[list[Token], Node]:
    """Return how far `path` leads, and to what: the entries of a pair are not told apart."""
    for depth, token in enumerate(path):
        inner = _alternative(node)
        if isinstance(inner, inspect.StructType) and isinstance(node.value, Mapping) and token in node.value:
            if token == inner.tag_field:
                return path[: depth + 1], Node(_tags(node.type), node.value[token])
            step = next(each.type for each in inner.fields if each.encode_name == token)
        elif isinstance(inner, (inspect.ListType, inspect.VarTupleType)) and isinstance(token, int):
            step = inner.item_type
        else:
            return path[:depth], node
        node = Node(step, node.value[token], peeled(step)[1].get("unit") or node.unit)
    return path, node


def _alternative(node: Node) -> inspect.Type | None:
    """Return the type that `value` would be of, among several; None where it is like none."""
    parts = alternatives(node.type)
    if len(parts) == 1:
        return parts[0]
    structs = [one for one in parts if isinstance(one, inspect.StructType)]
    if isinstance(node.value, Mapping) and structs:
        said = [one for one in structs if one.tag_field and node.value.get(one.tag_field) == one.tag]
        return [*said, *structs][0]
    return next((one for one in parts if isinstance(one, _LIKE.get(type(node.value), ()))), None)


def _tags(node: inspect.Type) -> inspect.LiteralType:
    """Return the kinds of a table that says its own, as an enumeration."""
    return inspect.LiteralType(tuple(str(one.tag) for one in alternatives(node) if isinstance(one, inspect.StructType)))


def _wrong_keys(union: inspect.Type, inner: inspect.StructType, table: Mapping[str, Any], name: str) -> str:
    """Return which key is missing, or is none of the table's."""
    known = [each.encode_name for each in inner.fields]
    lead = f"{name}: " if name else ""
    tag = inner.tag_field
    if tag and tag not in table:
        return f"{lead}the key '{tag}' is missing: {words_of(_tags(union))}"
    for key in table:
        if key not in known and key != tag:
            listed = f" (known: {', '.join(known)})" if name and 0 < len(known) <= _LONGEST_LIST else ""
            of = f" of {tag} = {table[tag]!r}" if tag else ""
            return f"{lead}unknown key {shown(key)}{of}{suggestion(key, known)}{listed}"
    for each in inner.fields:
        if each.required and each.encode_name not in table:
            return f"{lead}the key '{each.encode_name}' is missing: {words_of(each.type)}"
    return f"{lead}cannot be read, got {shown(dict(table))}"


def _spelt(path: Sequence[Token], whole: Any, toml: bool, heading: str) -> str:
    """Return a path as people write it: ``[wind] velocity``, ``[[uav]] 2 speed``, ``cost[1][2]``.

    heading : what must stand around the last of it.
    """
    first, *rest = path
    value = whole[first] if isinstance(whole, Mapping) and first in whole else None
    if toml and rest and isinstance(rest[0], int) and isinstance(value, list) and isinstance(value[rest[0]], Mapping):
        number, *rest = rest
        head = f"[[{first}]] {int(number) + 1} "
    elif toml and (isinstance(value, Mapping) or (heading and not rest)):
        head = f"{('[{}]' if rest or not heading else heading).format(first)} "
    else:
        head = str(first)
    inside = "".join(f"[{token}]" if isinstance(token, int) else f".{token}" for token in rest)
    return head + inside.removeprefix(".") if head.endswith(" ") and inside else head.rstrip() + inside


def _heading(node: inspect.Type) -> str:
    """Return how TOML heads what is of a type: as a table, as tables, or not at all."""
    for one in alternatives(node):
        if isinstance(one, (inspect.DictType, inspect.StructType)):
            return "[{}]"
        if isinstance(one, inspect.ListType) and isinstance(alternatives(one.item_type)[0], inspect.StructType):
            return "[[{}]]"
    return ""
