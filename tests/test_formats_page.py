"""The page of the file formats: its tables are those of the declarations, its examples are valid.

After a change of a declaration: ``python tests/test_formats_page.py`` writes the tables again.
"""

from __future__ import annotations

import json
import re
import textwrap
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from workbench.formats import FORMATS, json_schema, markdown

PAGE = Path(__file__).parents[1] / "docs" / "formats.md"
KEYS = re.compile(r"(<!-- keys: (\w+) -->\n).*?(<!-- end -->)", re.S)
EXAMPLE = re.compile(r"\n\n((?:(?:    .*)?\n)+)\n?<!-- keys: (\w+) -->")


def filled(text: str) -> str:
    """Return the page with the tables of today's declarations."""
    return KEYS.sub(lambda found: f"{found[1]}\n{markdown(found[2])}\n{found[3]}", text)


def test_the_tables_are_those_of_the_declarations() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert {name for _, name, _ in KEYS.findall(text)} == set(FORMATS)
    assert text == filled(text), "run: python tests/test_formats_page.py"


EXAMPLES = {name: textwrap.dedent(block) for block, name in EXAMPLE.findall(PAGE.read_text(encoding="utf-8"))}


@pytest.mark.parametrize("name", FORMATS)
def test_the_examples_are_valid(name: str) -> None:
    read = tomllib.loads if FORMATS[name].toml else json.loads
    document = read(EXAMPLES[name])
    assert list(Draft202012Validator(json_schema(name)).iter_errors(document)) == []


@pytest.mark.parametrize("name", FORMATS)
def test_every_key_says_what_it_is_and_takes(name: str) -> None:
    rows = [line for line in markdown(name).splitlines() if line.startswith("| `")]
    for row in rows:
        key, takes, _, _, meaning, _ = (cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1])
        assert takes, f"{name}: {key} does not say what it takes"
        assert meaning, f"{name}: {key} does not say what it means"


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
