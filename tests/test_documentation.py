"""Every block of the documentation and the README is run as it stands there; what makes the site says nothing amiss."""

from __future__ import annotations

import dataclasses
import inspect
import re
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import workbench as wb
from formulations.moving_cost.registry import METHODS as COSTS
from formulations.routing.registry import SOLVERS
from formulations.selection.registry import METHODS as SELECTION
from formulations.surveying.registry import PLANNERS
from formulations.task_location.registry import METHODS as PLACEMENT
from tests import gallery
from workbench import facade, informing

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.rglob("*.md"), ROOT / "README.md"])
LINK = re.compile(r"\]\((?!https?:|#)([^)#]+)")
PROOF = gallery.BLOCK.search((DOCS / "python.md").read_text(encoding="utf-8"))


def blocks_of(page: Path) -> list[tuple[str, str]]:
    """Return language and text of each block; those that install are what `.ci/run` runs in fresh environments."""
    found = gallery.BLOCK.findall(page.read_text(encoding="utf-8"))
    return [(kind, text) for kind, text in found if "pip install" not in text]


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


SLOW = ("clocks.md", "comparing.md", "papers.md", "index.md")
"""Pages whose blocks take more than five seconds each."""
RUN = [
    pytest.param(page, id=name_of(page), marks=[pytest.mark.slow] if page.name in SLOW else [])
    for page in PAGES
    if page != gallery.PAGE and blocks_of(page)
]


@pytest.mark.parametrize("page", RUN)
def test_every_block_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for kind, text in blocks_of(page):
        assert kind in ("python", "sh"), f"{page.name}: a block of {kind} is run by nobody"
        gallery.run(kind, text)


@pytest.mark.slow
def test_every_block_of_the_gallery_makes_the_figures_below_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    figures = []
    for kind, text, names in gallery.blocks():
        assert names, text
        assert len([line for line in text.splitlines() if line.strip()]) <= 10, text
        gallery.run(kind, text)
        for name in names:
            found = gallery.made(name)
            assert found is not None, f"{name} is not made by the block above it"
            kept = (gallery.PICTURES / name).read_text(encoding="utf-8")
            assert _size(found.read_text(encoding="utf-8")) == _size(kept), f"{name}: python -m tests.gallery"
        figures += names
    assert len(figures) == len(set(figures)) == 12
    assert {path.name for path in gallery.PICTURES.iterdir()} == set(figures)


def _size(svg: str) -> tuple[str, ...]:
    """Return the view box of a picture: another layout is another picture."""
    found = re.search(r'viewBox="([^"]+)"', svg)
    assert found is not None
    return tuple(found.group(1).split())


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("mkdocs")
    pytest.importorskip("mkdocstrings")
    made = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(made)]
    done = subprocess.run(build, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return made


def test_the_site_is_built_without_a_warning_and_asks_nobody_for_anything(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    assert len(pages) >= len(PAGES) - 1
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert not re.findall(r"<(?:script|img|iframe|source)[^>]+src=\"?(?:https?:)?//", text), page
        outside = re.findall(r"<link[^>]+href=\"?(?:https?:)?//[^>]*>", text)
        assert not [link for link in outside if "canonical" not in link], page


def test_formulas_are_mathml(site: Path) -> None:
    page = (site / "methods" / "routing-exact" / "index.html").read_text(encoding="utf-8")
    assert page.count("<math") > 20
    assert "arithmatex" not in page


def test_a_link_that_leads_nowhere_is_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    hooks = runpy.run_path(str(DOCS / "hooks.py"))
    page = SimpleNamespace(file=SimpleNamespace(src_uri="methods/x.md"))
    text = hooks["on_page_markdown"]("[a](../../CONTRIBUTING.md#x) [b](../methods.md)", page=page)
    assert text == "[a](https://github.com/mmmdmtsp/workbench/blob/main/CONTRIBUTING.md#x) [b](../methods.md)"
    assert not caplog.records
    hooks["on_page_markdown"]("[a](../../CONTRIBUTE.md)", page=page)
    assert "links to CONTRIBUTE.md, which does not exist" in caplog.text


def test_links_of_the_readme_lead_somewhere() -> None:
    links = LINK.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    assert links
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_every_page_is_in_the_site() -> None:
    listed = re.findall(r": ([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.M)
    assert sorted(listed) == sorted(str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md"))


def test_the_proof_is_the_same_in_the_readme_and_has_ten_lines() -> None:
    assert PROOF is not None
    assert PROOF.group() in (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(PROOF.group(2).splitlines()) <= 10


# what is not ours is taken as it is: reading all stubs takes mypy half a minute
OURS = """[mypy]
strict = True
follow_imports = skip
[mypy-workbench.*,formulations.*,instances.*]
follow_imports = silent
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings", [OURS, pytest.param("[mypy]\nstrict = True\n", marks=pytest.mark.slow)], ids=["ours", "everything"]
)
def test_mypy_passes_strictly_on_the_proof(settings: str, tmp_path: Path) -> None:
    assert PROOF is not None
    (tmp_path / "proof.py").write_text(PROOF.group(2) + "reveal_type(result)\n")
    (tmp_path / "mypy.ini").write_text(settings)
    call = [sys.executable, "-m", "mypy", "--config-file", "mypy.ini", "proof.py"]
    done = subprocess.run(
        call, cwd=tmp_path, env={"PYTHONPATH": str(ROOT), "MYPYPATH": str(ROOT)}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'Revealed type is "workbench.result.Result"' in done.stdout


@pytest.mark.parametrize("name", [name for name in wb.__all__ if name.islower()])
def test_the_docstring_of_a_function_says_what_it_takes_returns_and_raises(name: str) -> None:
    function = getattr(informing if name in informing.__all__ else facade, name)
    words = inspect.getdoc(function) or ""
    taken = words.split("Parameters\n----------\n")[1].split("\n\nReturns\n")[0]
    said = {each.strip(" *") for line in taken.splitlines() if not line.startswith(" ") for each in line.split(",")}
    assert said - {""} == set(inspect.signature(function).parameters)
    assert re.search(r"\n\nReturns\n-------\n\S+\n    \S", words)
    assert re.search(r"\n\nRaises\n------\n\S+\n    \S", words)


def _methods() -> list[tuple[str, Any, str]]:
    homes = [(SOLVERS, "routing-*"), (PLACEMENT, "task-location"), (COSTS, "moving-cost"), (SELECTION, "selection")]
    homes += [(PLANNERS, "surveys")]
    return [(name, registry, pages) for registry, pages in homes for name in registry.built_in]


@pytest.mark.parametrize(("name", "registry", "pages"), _methods())
def test_every_method_and_each_of_its_options_is_described(name: str, registry: Any, pages: str) -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in sorted((DOCS / "methods").glob(f"{pages}.md")))
    sections = [part.split("\n", 1) for part in re.split(r"^##+ ", text, flags=re.M)[1:]]
    own = [body for heading, body in sections if f"`{name}`" in heading]
    assert own, f"no heading for {name}"
    options = {each.name for each in dataclasses.fields(registry.load(name))}
    assert options <= set(re.findall(r"`([\w-]+)`", own[0]))
