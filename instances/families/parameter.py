"""Parameters of generator families: name, default, unit, and the check of a given value."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from instances.errors import InputError, shown, suggestion
from instances.registry import unfit

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
    formerly: str = ""
    """A name it once had and is still read under."""

    def checked(self, value: Any) -> str | int | float:
        """Return `value`, also as text from a command line, in this parameter's type; else InputError."""
        if isinstance(self.default, str):
            if not isinstance(value, str) or value not in self.choices:
                near = suggestion(value, self.choices) if isinstance(value, str) else ""
                raise InputError(f"{self.name}: {shown(value)} is not one of {', '.join(self.choices)}{near}")
            return value
        kind = type(self.default)
        number = _read(value, kind)
        if wanted := unfit(number, self.default, self.at_least):
            unit = f" [{self.unit}]" if self.unit else ""
            raise InputError(f"{self.name}: must be {wanted}{unit}, got {shown(value)}")
        return kind(number)


GROUND_SPEED = Parameter(
    "ground_speed", 20.0, "m/s", "speed of the UAVs over ground", at_least=1e-9, formerly="airspeed"
)
"""Of every family whose costs are energies at a constant ground speed that can be chosen."""


def _read(value: Any, kind: type[int] | type[float]) -> Any:
    """Return a number written as text, and a whole number that comes as a float, in `kind`; else `value`."""
    if isinstance(value, str) or (isinstance(value, float) and value.is_integer()):
        with contextlib.suppress(ValueError):
            return kind(value)
    return value.item() if isinstance(value, np.generic) else value
