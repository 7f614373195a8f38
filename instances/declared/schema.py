"""JSON Schema of a declared file (draft 2020-12), as msgspec makes it, with the rules that hold between keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def schema_of(kinds: Mapping[str, type], title: str, by: str = "") -> dict[str, Any]:
    """Return the JSON Schema of a declaration, or of several told apart by what the key `by` says, else the first.

    A declaration's attribute ``RULES`` adds what holds between its keys.
    """
    made, parts = msgspec.json.schema_components(list(kinds.values()), ref_template="#/$defs/{name}")
    whole = [{**getattr(kind, "RULES", {}), **each} for kind, each in zip(kinds.values(), made, strict=True)]
    schema = whole[0]
    for variant, other in list(zip(kinds, whole, strict=True))[1:]:
        said = {"properties": {by: {"const": variant}}, "required": [by]}
        schema = {"if": said, "then": other, "else": schema}
    return {"$schema": DRAFT, "title": title, **schema, "$defs": parts}
