"""Registry: name → something of one kind, imported only when asked for; and the one check of options.

What is built in is a table of names and targets ``"module:attribute"``. Others add to it through an entry-point group,
or name the target itself wherever a name is asked for. A target that is not built in is code of others: looking at its
name imports nothing, and what its import raises is told in a sentence.
"""

from __future__ import annotations

import dataclasses
import importlib
import math
import re
import sys
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cache
from inspect import cleandoc
from typing import Any, Generic, TypeVar

from instances.errors import InputError, shown, suggestion

T = TypeVar("T")

LARGEST = 1e100
"""The largest number anybody may ask for: its square, and what it is multiplied by, stay finite."""
LARGEST_WHOLE = 2**63 - 1
"""The largest whole number that compiled code takes."""
KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}
"""Type of an option → what its value must be, in words."""
PLAIN = "a finite number, a text, true or false, or a list of these"
"""What every option is, whatever its default."""


@dataclass(frozen=True)
class Registry(Generic[T]):
    """Things of one kind by name.

    kind : what they are, in sentences ("solver").
    built_in : name → (``"module:attribute"``, one line on what it is).
    group : entry-point group of third parties, or "" where the kind is closed.
    listing : the command that lists them, or "".
    having : attributes without which something is none of this kind.
    """

    kind: str
    built_in: Mapping[str, tuple[str, str]]
    group: str = ""
    listing: str = ""
    having: tuple[str, ...] = ()

    def targets(self) -> dict[str, tuple[str, str]]:
        """Return every registered one, built in or third party: name → (target, one line); nothing is imported."""
        others = {name: (value, f"third party ({value})") for name, value in _third_party(self.group)[0].items()}
        return {**self.built_in, **{name: other for name, other in others.items() if name not in self.built_in}}

    def target(self, name: str) -> str:
        """Return the ``module:attribute`` of the one registered as `name`, or named so; nothing is imported.

        Raises InputError for an unknown name (with the near miss) and for a target that cannot be one.
        """
        if name in self.built_in:
            return self.built_in[name][0]
        others, damaged = ({name: name}, 0) if self.group and ":" in name else _third_party(self.group)
        if name not in others:
            names = [*self.built_in, *others]
            known = f"{self.listing} lists them" if self.listing else f"known: {', '.join(names)}"
            more = f"; the entry points of {damaged} installed packages cannot be read" if damaged else ""
            raise InputError(f"unknown {self.kind} {shown(name)}{suggestion(name, names)} ({known}){more}")
        module, _, attribute = others[name].partition(":")
        if not all(part.isidentifier() for part in (*module.split("."), attribute)):
            raise InputError(
                f"{self.kind} {shown(name)}: must be a name or module:attribute, got {shown(others[name])}"
            )
        return others[name]

    def load(self, name: str) -> T:
        """Import and return the one registered as `name`, or named as ``module:attribute``.

        Raises what `target` raises, ImportError where the package of a built-in one is not installed, and InputError
        where code of others cannot be imported or is nothing of this kind.
        """
        target = self.target(name)
        module, _, attribute = target.partition(":")
        if name in self.built_in:
            built_in: T = getattr(importlib.import_module(module), attribute)
            return built_in
        try:
            found: T = getattr(importlib.import_module(module), attribute)
        except (Exception, SystemExit) as error:  # the boundary to foreign code, which may raise anything
            raise InputError(f"{self.kind} {name} cannot be imported ({type(error).__name__}: {error})") from error
        if missing := [each for each in self.having if not hasattr(found, each)]:
            raise InputError(f"{self.kind} {name}: {target} is no {self.kind} (it has no '{missing[0]}')")
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
    sources : name of a method that is built in → what to cite for it, keys of reports/data/references.bib.
    """

    at_least: float = -math.inf
    sources: Mapping[str, tuple[str, ...]] = dataclasses.field(default_factory=dict)

    def defaults(self, name: str) -> dict[str, Any]:
        """Return the options of a method and their defaults."""
        return option_defaults(self.load(name))

    def meanings(self, name: str) -> dict[str, str]:
        """Return what each option of a method means, one line, "" where its class does not say."""
        cls = self.load(name)
        said = option_meanings(cls)
        return {option: said.get(option, "") for option in option_defaults(cls)}

    def make(self, name: str, options: Mapping[str, Any] | None = None) -> T:
        """Return the method registered as `name` with `options`; InputError for an unknown one or an unfit value."""
        cls = self.load(name)
        if not isinstance(cls, type):
            raise InputError(f"{self.kind} {name}: must be a class, but is a {type(cls).__name__}")
        known = option_defaults(cls)
        given = dict(options or {})
        refuse_unknown(f"{self.kind} {name}", "option", given, known)
        for key, value in given.items():
            if fault := unfit(value, known[key], self.at_least):
                raise InputError(f"{self.kind} {name}: option {key} must be {fault}, got {shown(value)}")
        return cls(**given)

    def asked(self, name: str, options: Mapping[str, Any]) -> dict[str, Any]:
        """Return the options that say what is asked for: of a built-in method those that differ from the default.

        Raises what `make` raises, for a method that is not built in only what can be told without importing it: its
        options are returned as they are given.
        """
        self.target(name)
        for key, value in options.items():
            if not is_plain(value):
                raise InputError(f"{self.kind} {name}: option {shown(key)} must be {PLAIN}, got {shown(value)}")
        if name not in self.built_in:
            return dict(options)
        self.make(name, options)
        defaults = self.defaults(name)
        return {key: value for key, value in options.items() if value != defaults[key]}


def _third_party(group: str) -> tuple[dict[str, str], int]:
    """Return what installed packages register, name → target, and how many of them cannot be read; "" is no group."""
    return _registered(group, tuple(sys.path))


@cache
def _registered(group: str, path: tuple[str, ...]) -> tuple[dict[str, str], int]:
    """Look through the packages on `path`, which takes a tenth of a second: once for each."""
    from importlib.metadata import distributions  # here: it takes its time, and what is built in needs none

    found: dict[str, str] = {}
    damaged = 0
    for package in distributions(path=list(path)) if group else ():
        try:
            entries = [(entry.name, entry.value) for entry in package.entry_points if entry.group == group]
        except (OSError, TypeError, ValueError):  # another package's file: what it would add cannot be known
            damaged += 1
            continue
        for name, value in entries:
            found.setdefault(name, value.partition("[")[0].strip())
    return found, damaged


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
    if fits and (kind not in (int, float) or (value >= at_least and in_range(value))):
        return ""
    if fits and kind in (int, float) and value > at_least:
        return f"{KINDS[kind]} of at most {LARGEST_WHOLE if kind is int else LARGEST:g}"
    return KINDS[kind] + (f" of at least {at_least:g}" if at_least > -math.inf else "")


def in_range(value: float) -> bool:
    """Return whether a number is finite and can be computed with: a whole one as compiled code does."""
    return abs(value) <= (LARGEST_WHOLE if isinstance(value, int) else LARGEST)


def is_plain(value: Any) -> bool:
    """Return whether `value` is PLAIN."""
    parts = value if isinstance(value, list) else [value]
    return all(type(part) in KINDS and (isinstance(part, str) or in_range(part)) for part in parts)


def option_defaults(cls: type[Any]) -> dict[str, Any]:
    """Return the options of a method and their defaults: its dataclass fields."""
    if not dataclasses.is_dataclass(cls):
        return {}
    made = {
        f.name: f.default_factory() for f in dataclasses.fields(cls) if f.default_factory is not dataclasses.MISSING
    }
    return {f.name: made.get(f.name, f.default) for f in dataclasses.fields(cls)}


_MEANING = re.compile(r"^(\w+) : (.*(?:\n +\S.*)*)", re.MULTILINE)
"""A line ``option : words`` of a docstring, and the lines set in below it."""


def option_meanings(cls: type[Any]) -> dict[str, str]:
    """Return what options mean, as the docstrings of a method and of what it inherits from say: ``option : words``."""
    found: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        said = _MEANING.findall(cleandoc(base.__doc__ or ""))
        found |= {name: " ".join(words.split()).rstrip(".") for name, words in said}
    return found
