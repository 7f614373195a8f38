"""Numbers as words of a page or table: few digits, a unit where the heading has none, a dash for nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

NOTHING = "–"
PER_CENT = "\u00a0%"
"""A sign that stays with its number."""


def missing(value: Any) -> bool:
    """Return whether `value` is None, NaN or pandas' NA."""
    return value is None or str(value) == "<NA>" or bool(value != value)


def share(value: Any) -> str:
    """Return a share of 1 as whole per cent, "100 %" and "0 %" only where exact."""
    if missing(value):
        return NOTHING
    rounded = round(100 * value)
    if rounded in (0, 100) and value not in (0, 1):
        return f"< 1{PER_CENT}" if rounded == 0 else f"> 99{PER_CENT}"
    return f"{rounded}{PER_CENT}"


def gap(value: Any) -> str:
    """Return a gap in per cent, two decimals below 10 %."""
    if missing(value):
        return NOTHING
    if math.isinf(value):
        return "∞"
    percent = 100 * float(value)
    if abs(percent) < 5e-5:
        return f"0{PER_CENT}"
    if abs(percent) < 0.005:
        return f"< 0.01{PER_CENT}" if percent > 0 else f"> −0.01{PER_CENT}"
    digits = 2 if abs(percent) < 10 else 1
    return f"{percent:.{digits}f}{PER_CENT}".replace("-", "−")


def seconds(value: Any) -> str:
    """Return a time [s], without its unit, in three digits or so."""
    if missing(value):
        return NOTHING
    if math.isinf(value):
        return "∞"
    if value >= 100:
        return f"{value:,.0f}"
    if 0 < value < 0.0005:
        return "< 0.001"
    return f"{value:.1f}" if value >= 10 else f"{value:.2f}" if value >= 0.1 else f"{value:.3f}"


def signed_seconds(value: Any) -> str:
    """Return a difference of times [s], without its unit."""
    if missing(value) or value >= 0:
        return seconds(value)
    size = seconds(-value)
    return size.replace("< ", "> −") if size.startswith("<") else f"−{size}"


def interval(write: Callable[[Any], str], low: Any, high: Any) -> str:
    """Return both ends of an interval, each as `write` gives it; one where both read the same."""
    if missing(low) or missing(high):
        return NOTHING
    ends = dict.fromkeys((write(low), write(high)))
    return " … ".join(ends)


def cost(value: Any) -> str:
    """Return a cost [s], without its unit, in six digits."""
    return NOTHING if missing(value) else "∞" if math.isinf(value) else f"{value:,.6g}"


def memory(value: Any) -> str:
    """Return bytes as MB or GB."""
    if missing(value):
        return NOTHING
    return f"{value / 1e9:.2f} GB" if value >= 1e9 else f"{value / 1e6:.0f} MB"


def count(value: Any) -> str:
    """Return a whole number."""
    return NOTHING if missing(value) else f"{int(value):,}"


def proved(value: Any) -> str:
    """Return "proved" or "open"."""
    return "proved" if value else "open"


def fixed(digits: int, scale: float = 1.0, sign: str = "") -> Callable[[Any], str]:
    """Return what writes `scale` times a number with so many decimals and `sign` behind."""
    return lambda value: f"{scale * value:.{digits}f}{sign}".replace("-", "−")


def counted(number: int, noun: str) -> str:
    """Return "1 seed" or "2 seeds"."""
    return f"{number:,} {noun}" + ("" if number == 1 else "s")


def ratio(value: Any) -> str:
    """Return a dimensionless figure with three decimals."""
    return NOTHING if missing(value) else f"{value:.3f}"


def p_value(value: Any) -> str:
    """Return a probability, never as 0."""
    return NOTHING if missing(value) else "< 0.001" if value < 0.001 else f"{value:.3f}"


def apart(a: float, b: float, digits: int = 2) -> tuple[str, str]:
    """Return two numbers with so many decimals, or as many more as it takes to tell them apart where they differ."""
    for more in range(digits, 13):
        texts = fixed(more)(a), fixed(more)(b)
        if texts[0] != texts[1] or a == b:
            return texts
    return f"{a!r}", f"{b!r}"


def signed(values: Sequence[float], least: float, digits: int = 2) -> list[str]:
    """Return numbers with their signs, with so many decimals or as many more as give `least` two figures."""
    places = max(digits, min(12, 1 - math.floor(math.log10(least)))) if least > 0 else digits
    texts = [f"{value:+.{places}f}".replace("-", "−") for value in values]
    return [text.replace("−", "+") if not text.strip("−0.") else text for text in texts]  # no −0.00
