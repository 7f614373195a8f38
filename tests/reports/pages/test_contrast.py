"""Contrast of the page's colours, from its style sheet: WCAG 2.2, 1.4.3 and 1.4.11, in both themes and in print."""

import re
from importlib import resources

import pytest

CSS = resources.files("reports.pages").joinpath("templates", "page.css").read_text(encoding="utf-8")
NAMED = dict(re.findall(r"--([\w-]+): light-dark\((#\w+, #\w+)\)", CSS))
PRINTED = dict(re.findall(r"--([\w-]+): (#\w+);", CSS[CSS.index("@media print") :]))
TEXT = [
    ("ink", "paper"), ("soft", "paper"), ("link", "paper"), ("good", "paper"), ("red", "paper"), ("ink", "wash"),
    ("soft", "wash"), ("link", "wash"), ("red", "wash"), ("ink", "best"), ("link", "best"), ("ink", "red-wash"),
    ("soft", "red-wash"), ("red", "red-wash"),
]  # fmt: skip
"""Colours of text and what it stands on."""
LINES = [("faint", "paper"), ("faint", "wash"), ("link", "paper"), ("red", "paper")]
"""Colours of lines and borders that say something, and what they are drawn on."""


def luminance(colour):
    """Return the relative luminance of "#rgb" or "#rrggbb"."""
    digits = colour[1:] if len(colour) == 7 else "".join(2 * digit for digit in colour[1:])
    parts = [int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)]
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one, other):
    """Return the contrast of two colours, 1 to 21."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def colours(theme):
    """Return name → colour in light, dark or print."""
    if theme == "print":
        return PRINTED
    return {name: pair.split(", ")[theme == "dark"] for name, pair in NAMED.items()}


def test_contrast_of_black_on_white_is_21():
    assert contrast("#000", "#ffffff") == pytest.approx(21)
    assert contrast("#777777", "#fff") == pytest.approx(4.48, abs=0.01)  # just not enough, as everyone knows


@pytest.mark.parametrize("theme", ["light", "dark", "print"])
def test_text_and_lines_stand_out(theme):
    of = colours(theme)
    assert set(of) == set(NAMED)
    assert [pair for pair in TEXT if contrast(*map(of.get, pair)) < 4.5] == []
    assert [pair for pair in LINES if contrast(*map(of.get, pair)) < 3] == []


def test_text_has_no_colour_but_these():
    said = {name for value in re.findall(r"[{;\s]color:\s*([^;}]+)", CSS) for name in re.findall(r"--([\w-]+)", value)}
    assert said <= {ink for ink, _ in TEXT}
