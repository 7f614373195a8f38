"""Types of the numbers that are typed on the command line, each with the range that can be used.

A value outside it is refused here, before a command begins, with a sentence that names the flag and the value.
"""

from __future__ import annotations

import math
from typing import Any, NoReturn

import click

from formulations.limits import LARGEST_SEED, LONGEST, MOST_THREADS
from instances.errors import InputError, shown
from instances.registry import LARGEST, LARGEST_WHOLE
from workbench.completing import columns


class Whole(click.ParamType):  # type: ignore[type-arg] # not generic in all versions of click
    """A whole number from `least` to `most`."""

    name = "integer"

    def __init__(self, least: int, most: int) -> None:
        self.least, self.most = least, most

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number; InputError where it is none or outside the range."""
        try:
            number = int(value)
        except ValueError:
            number = self.least - 1
        if not self.least <= number <= self.most:
            refuse(param, f"a whole number from {self.least} to {self.most}", value)
        return number


class Positive(click.ParamType):  # type: ignore[type-arg]
    """A number above 0 and at most `most`; far from where its square is 0 or infinite."""

    name = "float"
    least = 1 / LARGEST

    def __init__(self, most: float = LARGEST, unit: str = "") -> None:
        self.most, self.unit = most, unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number; InputError where it is none or outside the range."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not self.least <= number <= self.most:
            unit = f" [{self.unit}]" if self.unit else ""
            refuse(param, f"a positive number of at most {self.most:g}{unit}", value)
        return number


def refuse(param: click.Parameter | None, wanted: str, value: Any) -> NoReturn:
    """Raise the InputError that says what `param` must be."""
    flag = "/".join(param.opts) if param is not None else "value"
    raise InputError(f"{flag}: must be {wanted}, got {shown(value)}")


def _listed(context: click.Context, parameter: click.Parameter, value: str | None) -> list[str]:
    from workbench.settings import names

    return [] if value is None else names(value, "--columns")


SEED = Whole(0, LARGEST_SEED)
COUNT = Whole(1, 1_000_000)
"""How many of something."""
MOST_JOBS = 10_000
JOBS = Whole(1, MOST_JOBS)
"""Runs at once."""
THREADS = Whole(1, MOST_THREADS)
ITERATIONS = Whole(0, LARGEST_WHOLE)
SECONDS = Positive(LONGEST, "s")
POSITIVE = Positive()

SIGNAL_SD = click.option(
    "--signal-sd", type=POSITIVE, default=30.0, show_default=True, help="σ_f, in the unit of the signal."
)
LENGTH_SCALE = click.option("--length-scale", default="4000", show_default=True, metavar="L|LX,LY", help="[m]")
NOISE_SD = click.option("--noise-sd", type=POSITIVE, default=1.0, show_default=True, help="σ_n of a reading at a task.")
TESTS = click.option(
    "--tests", default="20x20", show_default=True, help="Cell centres inside, or a CSV: x, y[, weight]."
)
METHOD_OPTION = click.option(
    "--option", "options", multiple=True, metavar="KEY=VALUE", help="An option of the method; repeatable."
)
JSON = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
COLUMNS = click.option(
    "--columns",
    metavar="NAME,...",
    callback=_listed,
    shell_complete=columns,
    help="Columns of the printed table, or all; without it those that fit.",
)
