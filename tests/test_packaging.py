"""What the repository says of itself in several files agrees, and type checkers of its users are served."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_pre_commit_runs_the_checks_of_ci():
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    entries = re.findall(r"^\s+entry: (.+)$", hooks, re.MULTILINE)
    ci = (ROOT / ".ci/run").read_text(encoding="utf-8")
    assert entries == re.findall(r"^\.venv/bin/((?:ruff|mypy).*)$", ci, re.MULTILINE)
    assert len(entries) == 3


def test_pre_commit_fetches_nothing():
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    assert re.findall(r"repo: (\S+)", hooks) == ["local"]
    assert hooks.count("language: system") == hooks.count("- id: ")


@pytest.mark.parametrize("package", PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"])
def test_every_package_says_that_it_is_typed(package):
    assert (ROOT / package / "py.typed").is_file()
    assert package in PROJECT["tool"]["mypy"]["packages"]


@pytest.mark.parametrize("key", ["version", "license"])
def test_the_citation_agrees_with_the_project(key):
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(rf"^{key}: (.+)$", citation, re.MULTILINE) == [PROJECT["project"][key]]
