from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from instances import Instance
from instances.files import write_instance
from workbench.cli import main

HERE = Path(__file__).parent


def random_instance(n_tasks: int, n_depots: int, seed: int) -> Instance:
    xy = np.random.default_rng(seed).uniform(0, 1000, (n_tasks + n_depots, 2))
    cost = np.linalg.norm(xy[:, None] - xy[None], axis=-1)
    return Instance(f"r{n_tasks}-{n_depots}-{seed}", cost, n_tasks, n_depots, xy)


@pytest.fixture(autouse=True)
def misbehaving_solvers(monkeypatch):
    """Let child processes import the solvers of misbehaving.py by the name ``misbehaving:Class``."""
    monkeypatch.setenv("PYTHONPATH", str(HERE), prepend=os.pathsep)
    monkeypatch.syspath_prepend(str(HERE))


@pytest.fixture
def instance() -> Instance:
    return random_instance(4, 2, 0)


@pytest.fixture
def instance_file(tmp_path, instance) -> Path:
    path = tmp_path / "small.json"
    write_instance(instance, path)
    return path


@pytest.fixture
def instance_folder(tmp_path) -> Path:
    folder = tmp_path / "given"
    folder.mkdir()
    for seed in range(3):
        drawn = random_instance(4, 2, seed)
        write_instance(drawn, folder / f"{drawn.name}.json")
    return folder


@pytest.fixture
def cli(tmp_path, monkeypatch, capsys, without_figures):
    """Run the command line in this process, in an empty folder; returns exit code, stdout and stderr.

    Pages are written without their figures, which are most of the seconds a command takes.
    """
    monkeypatch.chdir(tmp_path)

    def call(*args: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as ended:
            main([str(arg) for arg in args])
        told = capsys.readouterr()
        return int(ended.value.code or 0), told.out, told.err

    return call


@pytest.fixture
def stored_json():
    """Return the runs stored in a folder: path relative to it → content."""

    def read(folder: Path) -> dict[str, dict]:
        paths = [p for p in folder.glob("*/*.json") if p.name != "instance.json" and p.parent.name != "environments"]
        return {str(p.relative_to(folder)): json.loads(p.read_text()) for p in sorted(paths)}

    return read
