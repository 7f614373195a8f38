"""Listing: what `workbench solvers`, `methods` and `families` say of names and their options."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from instances.registry import MethodRegistry, Registry
from workbench.terminal import say


def asked_for(registry: Registry[Any], names: Sequence[str]) -> dict[str, str]:
    """Return name → what it is, of those asked for or else of all; InputError for an unknown name."""
    known = {name: about for name, (_, about) in registry.targets().items()}
    return {name: known.get(name, registry.target(name)) for name in names} if names else known


def described(registry: MethodRegistry[Any], name: str, about: str, *, named: bool) -> dict[str, Any]:
    """Return what there is to say of a method; only one that is `named` is imported where it is code of others."""
    looked_at = named or name in registry.built_in
    reason = registry.why_unavailable(name) if looked_at else None
    if reason or not looked_at:
        return {"about": about, "options": {}, "meanings": {}, "unavailable": reason}
    options = registry.defaults(name)
    return {"about": about, "options": options, "meanings": registry.meanings(name), "unavailable": None}


def print_described(name: str, found: Mapping[str, Any], inset: str = "") -> None:
    """Print a method and its options, each with its default and what it means."""
    say(f"{inset}{name}: {found['about']}")
    if found["unavailable"]:
        say(f"{inset}    not available: {found['unavailable']}")
    for option, default in found["options"].items():
        meaning = found["meanings"][option]
        say(f"{inset}    {option} = {json.dumps(default, default=str)}" + (f": {meaning}" if meaning else ""))
