"""Registry: name → something of one kind, imported only when asked for; and the one check of options.

What is built in is a table of names and targets ``"module:attribute"``. Others add to it through an entry-point group,
or name the target itself wherever a name is asked for.
"""

from __future__ import annotations

import dataclasses
import importlib
import math
import sys
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any, Generic, TypeVar

from instances.errors import InputError, suggestion

T = TypeVar("T")

LARGEST = sys.float_info.max
KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}
"""Type of an option → what its value must be, in words."""


@dataclass(frozen=True)
class Registry(Generic[T]):
    """Things of one kind by name.

    kind : what they are, in sentences ("solver").
    built_in : name → (``"module:attribute"``, one line on what it is).
    group : entry-point group of third parties, or "" where the kind is closed.
    listing : the command that lists them, or "".
    """

    kind: str
    built_in: Mapping[str, tuple[str, str]]
    group: str = ""
    listing: str = ""

    def targets(self) -> dict[str, tuple[str, str]]:
        """Return every registered one, built in or third party: name → (target, one line)."""
        found = dict(self.built_in)
        for entry in entry_points(group=self.group) if self.group else ():
            found.setdefault(entry.name, (entry.value, f"third party ({entry.value})"))
        return found

    def load(self, name: str) -> T:
        """Import and return the one registered as `name`, or named as ``module:attribute``.

        Raises InputError for an unknown name (with the near miss), ImportError where its package is not installed.
        """
        targets = self.targets()
        if name not in targets and not (self.group and ":" in name):
            known = f"{self.listing} lists them" if self.listing else f"known: {', '.join(targets)}"
            raise InputError(f"unknown {self.kind} '{name}'{suggestion(name, targets)} ({known})")
        module, _, attribute = (targets[name][0] if name in targets else name).partition(":")
        found: T | None = getattr(importlib.import_module(module), attribute, None)
        if found is None:
            raise InputError(f"{self.kind} {name}: module {module} has no '{attribute}'")
        return found

    def why_unavailable(self, name: str) -> str | None:
        """Return why `name` cannot be imported here, in a sentence, or None where it can."""
        try:
            self.load(name)
        except ImportError as error:
            return f"not installed: {error}"
        return None


@dataclass(frozen=True)
class MethodRegistry(Registry[type[T]]):
    """Methods: classes whose options are their dataclass fields, each with a default that decides its type.

    at_least : of every number among the options.
    """

    at_least: float = -math.inf

    def defaults(self, name: str) -> dict[str, Any]:
        """Return the options of a method and their defaults."""
        return option_defaults(self.load(name))

    def make(self, name: str, options: Mapping[str, Any] | None = None) -> T:
        """Return the method registered as `name` with `options`; InputError for an unknown one or an unfit value."""
        cls = self.load(name)
        known = option_defaults(cls)
        given = dict(options or {})
        refuse_unknown(f"{self.kind} {name}", "option", given, known)
        for key, value in given.items():
            if fault := unfit(value, known[key], self.at_least):
                raise InputError(f"{self.kind} {name}: option {key} must be {fault}, got {value!r}")
        return cls(**given)

    def changed(self, name: str, options: Mapping[str, Any]) -> dict[str, Any]:
        """Return those of the checked `options` that differ from the default; raises what `make` raises."""
        self.make(name, options)
        defaults = self.defaults(name)
        return {key: value for key, value in options.items() if value != defaults[key]}


def refuse_unknown(owner: str, what: str, given: Collection[str], known: Collection[str]) -> None:
    """Raise InputError, with the near miss, for the first name in `given` that `owner` has no such `what` for."""
    for name in given:
        if name not in known:
            has = f"it has: {', '.join(known)}" if known else "it has none"
            raise InputError(f"{owner} has no {what} '{name}'{suggestion(name, known)} ({has})")


def unfit(value: Any, default: Any, at_least: float = -math.inf) -> str:
    """Return what `value` must be to stand in place of `default`, in words, or "" where it fits."""
    kind = type(default)
    if kind not in KINDS:
        return ""
    fits = type(value) is kind or (kind is float and type(value) is int)
    if fits and (kind not in (int, float) or max(at_least, -LARGEST) <= value <= LARGEST):
        return ""
    return KINDS[kind] + (f" of at least {at_least:g}" if at_least > -math.inf else "")


def option_defaults(cls: type[Any]) -> dict[str, Any]:
    """Return the options of a method and their defaults: its dataclass fields."""
    if not dataclasses.is_dataclass(cls):
        return {}
    made = {
        f.name: f.default_factory() for f in dataclasses.fields(cls) if f.default_factory is not dataclasses.MISSING
    }
    return {f.name: made.get(f.name, f.default) for f in dataclasses.fields(cls)}
