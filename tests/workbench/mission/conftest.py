"""A small mission, made once."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tests.workbench.mission.small import SMALL, ZONE
from workbench.mission.file import read_mission
from workbench.mission.pipeline import run_mission


@pytest.fixture(scope="session")
def mission_file(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("mission")
    (folder / "zones.geojson").write_text(json.dumps(ZONE))
    (folder / "small.toml").write_text(SMALL)
    return folder / "small.toml"


@pytest.fixture(scope="session")
def made(mission_file: Path, tmp_path_factory, worker_id: str) -> Path:
    """The products of the mission, to be read only: of the first worker that has made them."""
    base = tmp_path_factory.getbasetemp()
    of_all = (base if worker_id == "master" else base.parent) / "made"
    if not of_all.exists():
        out = tmp_path_factory.mktemp("making") / "out"
        run_mission(read_mission(mission_file), out)
        try:
            out.rename(of_all)
        except OSError:  # another worker was as quick
            return out
    return of_all


@pytest.fixture
def copied(made: Path, tmp_path: Path) -> Path:
    shutil.copytree(made, tmp_path / "copy")
    return tmp_path / "copy"


@pytest.fixture
def plain_page(monkeypatch) -> None:
    """A page without figures, for tests of which stages are made: they are most of a small mission's seconds."""

    def write(folders: dict[str, Path], path: Path, said: dict) -> list:
        path.write_text("plain")
        return []

    monkeypatch.setattr("workbench.mission.report.write_mission_page", write)
