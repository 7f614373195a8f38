"""Stage 8, report: the page and its figures, made from the stored products.

Products: report.html, figures as SVG, values of charts as CSV.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from instances.toml_text import toml_text
from reports.figures.files import write_figures
from reports.pages.mission import write_mission_page
from reports.products import FOLDERS
from workbench.mission.settings import Mission
from workbench.mission.stamp import read_stamp


def settings(mission: Mission) -> dict[str, Any]:
    """Return what this stage depends on: the page shows the whole mission file."""
    return {"table": mission.table}


def make(mission: Mission, folders: dict[str, Path], out: Path, tell: Callable[[str], None]) -> str:
    """Write the page and the figures."""
    stamps = {name: read_stamp(folders[name]) for name in FOLDERS}
    stages = [(name, f"{stamp.elapsed:.1f} s, products {stamp.digest}") for name, stamp in stamps.items() if stamp]
    said = {"title": f"Mission: {mission.scenario.name}", "settings": toml_text(mission.table), "stages": stages}
    page = out / "report.html"
    figures = write_mission_page({name: folders[name] for name in FOLDERS}, page, said)
    write_figures(figures, out, (".svg",))
    return f"{len(figures)} figures, page of {page.stat().st_size / 1e6:.1f} MB"
