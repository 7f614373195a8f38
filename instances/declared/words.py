"""What a declared type takes, in words: "a positive number [m/s]", "one of 'own', 'any', 'none'"."""

from __future__ import annotations

from typing import Any, NamedTuple

from msgspec import inspect

UNSAID = 1e9
"""A bound as far out as this is said only to who is beyond it."""
NUMERALS = {2: "two", 3: "three"}


class Phrase(NamedTuple):
    """A noun, one and many, and the bounds after it."""

    one: str
    many: str
    after: str = ""

    def said(self, unit: str, many: bool = False) -> str:
        """Return it as words."""
        noun = self.many if many else f"a {self.one}"
        return f"{noun}{self.after}{f' [{unit}]' if unit else ''}"


def peeled(node: inspect.Type) -> tuple[inspect.Type, dict[str, Any]]:
    """Return a type without what is noted on it, and the note."""
    notes: dict[str, Any] = {}
    while isinstance(node, inspect.Metadata):
        notes = {**(node.extra or {}), **{k: v for k, v in notes.items() if v}}
        node = node.type
    return node, notes


def alternatives(node: inspect.Type) -> list[inspect.Type]:
    """Return the types among which a value may choose, one where it cannot."""
    inner, _ = peeled(node)
    if isinstance(inner, inspect.UnionType):
        return [one for each in inner.types for one in alternatives(each)]
    return [inner]


def words_of(node: inspect.Type, unit: str = "", value: object = None) -> str:
    """Return what a value of the type must be. value : one that is not; a bound it breaks is said."""
    inner, notes = peeled(node)
    unit = notes.get("unit") or unit
    if notes.get("words"):
        return str(notes["words"])
    if isinstance(inner, inspect.UnionType):
        parts = (words_of(each, unit, value) for each in inner.types if not isinstance(each, inspect.NoneType))
        return " or ".join(dict.fromkeys(parts))
    if isinstance(inner, (inspect.EnumType, inspect.LiteralType)):
        known = names_of(inner)
        return f"one of {', '.join(map(repr, known))}" if len(known) > 2 else " or ".join(map(repr, known))
    if isinstance(inner, inspect.TupleType):
        first = inner.item_types[0]
        return f"{NUMERALS[len(inner.item_types)]} {_plural(first, unit)}"
    if isinstance(inner, (inspect.ListType, inspect.VarTupleType)):
        if inner.min_length and inner.min_length == inner.max_length:
            return f"{NUMERALS[inner.min_length]} {_plural(inner.item_type, unit)}"
        least = ", at least one" if inner.min_length else ""
        return f"a list of {_plural(inner.item_type, unit)}{least}"
    return _phrase(inner, value).said(unit)


def names_of(inner: inspect.EnumType | inspect.LiteralType) -> list[object]:
    """Return the values of an enumeration, in their order."""
    return list(inner.values) if isinstance(inner, inspect.LiteralType) else [str(each) for each in inner.cls]


def _plural(node: inspect.Type, unit: str) -> str:
    inner, notes = peeled(node)
    if notes.get("words"):
        return f"values, each {notes['words']}"
    if isinstance(inner, inspect.UnionType):
        inner, _ = peeled(next(each for each in inner.types if not isinstance(each, inspect.NoneType)))
    if isinstance(inner, inspect.TupleType):
        return f"{'pairs' if len(inner.item_types) == 2 else 'triples'} of {_plural(inner.item_types[0], unit)}"
    if isinstance(inner, (inspect.ListType, inspect.VarTupleType)):
        return f"lists of {_plural(inner.item_type, unit)}"
    if isinstance(inner, (inspect.EnumType, inspect.LiteralType)):
        return f"values, each {words_of(inner)}"
    return _phrase(inner, None).said(unit, many=True)


def _phrase(inner: inspect.Type, value: object) -> Phrase:
    if isinstance(inner, inspect.IntType):
        return Phrase("whole number", "whole numbers", _range(inner.ge, inner.le, value))
    if isinstance(inner, inspect.FloatType):
        if inner.gt == 0:
            return Phrase("positive number", "positive numbers", _range(None, inner.le, value))
        if inner.ge is None or inner.ge <= 0:
            return Phrase("number", "numbers", _range(inner.ge, inner.le, value))
        below = isinstance(value, (int, float)) and 0 < value < inner.ge
        return Phrase("positive number", "positive numbers", _range(inner.ge if below else None, inner.le, value))
    if isinstance(inner, inspect.StrType):
        return Phrase("text", "texts")
    if isinstance(inner, inspect.BoolType):
        return Phrase("truth value, true or false", "truth values")
    if isinstance(inner, inspect.DictType) and not isinstance(inner.value_type, inspect.AnyType):
        return Phrase("table", "tables", f" of {_plural(inner.value_type, '')}")
    if isinstance(inner, (inspect.DictType, inspect.StructType)):
        return Phrase("table", "tables")
    return Phrase("value", "values")


def _range(least: float | None, most: float | None, value: object) -> str:
    """Return the bounds in words: those far out only where `value` is beyond them."""
    number = value if isinstance(value, (int, float)) and not isinstance(value, bool) else 0
    if least is not None and least <= -UNSAID <= number:
        least = None
    if most is not None and number <= UNSAID <= most:
        most = None
    if least is None and most is None:
        return ""
    if most is None:
        return f" of at least {least:.10g}"
    return f" of at most {most:.10g}" if least is None else f" from {least:.10g} to {most:.10g}"
