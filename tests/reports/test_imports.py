"""No import circle in reports, lazy imports included, and figures know no page."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import reports

ROOT = Path(reports.__file__).parent


def imported(path):
    """The modules of reports that the file at `path` imports anywhere."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            modules = {name for name in inner if name in MODULES}
            names |= modules if len(modules) == len(inner) else modules | {node.module}
    return {name for name in names if name in MODULES}


def name_of(path):
    return ".".join(("reports", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")


MODULES = {name_of(path): path for path in ROOT.rglob("*.py")}


def test_there_is_no_circle():
    graph = {name: imported(path) for name, path in MODULES.items()}
    assert graph["reports.pages.study"] > {"reports.pages.page", "reports.columns"}
    TopologicalSorter(graph).prepare()  # raises CycleError


def test_figures_know_no_page():
    figures = {name: imported(path) for name, path in MODULES.items() if name.startswith("reports.figures")}
    assert len(figures) > 10
    assert not {page for pages in figures.values() for page in pages if page.startswith("reports.pages")}
