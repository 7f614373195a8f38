"""JSON Schema of a declared file (draft 2020-12), as msgspec makes it, with the rules that hold between keys."""

from __future__ import annotations

from typing import Any

import msgspec

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def schema_of(kind: Any, title: str) -> dict[str, Any]:
    """Return the JSON Schema of a declaration; its attribute ``RULES`` adds what holds between keys."""
    made = msgspec.json.schema(kind)
    return {"$schema": DRAFT, "title": title, **getattr(kind, "RULES", {}), **made}
