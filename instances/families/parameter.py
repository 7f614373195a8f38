"""Parameters of generator families: name, default, unit, and the check of a given value."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from instances.errors import InputError, suggestion

Values = dict[str, Any]
"""Parameter name → value, complete and checked."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a family: its default decides its type (text, whole number or number)."""

    name: str
    default: str | int | float
    unit: str
    meaning: str
    choices: tuple[str, ...] = ()
    at_least: float = -math.inf

    def checked(self, value: Any) -> str | int | float:
        """Return `value`, also as text from a command line, in this parameter's type; else InputError."""
        if isinstance(self.default, str):
            if not isinstance(value, str) or value not in self.choices:
                near = suggestion(value, self.choices) if isinstance(value, str) else ""
                raise InputError(f"{self.name}: {value!r} is not one of {', '.join(self.choices)}{near}")
            return value
        kind: type[int] | type[float] = int if isinstance(self.default, int) else float
        try:
            number = kind(value) if isinstance(value, str) or not isinstance(value, bool) else math.nan
            usable = math.isfinite(number) and number >= self.at_least and (isinstance(value, str) or number == value)
        except (TypeError, ValueError, OverflowError):
            usable = False
        if not usable:
            what = "a whole number" if kind is int else "a number"
            bound = f" of at least {self.at_least:g}" if self.at_least > -math.inf else ""
            unit = f" [{self.unit}]" if self.unit else ""
            raise InputError(f"{self.name}: must be {what}{bound}{unit}, got {value!r}")
        return number
