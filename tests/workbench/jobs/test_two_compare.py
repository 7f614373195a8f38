"""Two `compare` at once, as processes: slow, as each of them and each run starts one; see also test_shared_store.py."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

STUDY = """
time_limit = 20
seeds = 4
files = ["given/r4-2-0.json"]

[[solvers]]
name = "spoiling:Marks"
options = { delay = 1.0 }
"""


def compare(folder: Path, *more: str) -> subprocess.Popen[str]:
    args = ["compare", "study.toml", "--out", "runs", "--jobs", "1", *more]
    return subprocess.Popen(
        [sys.executable, "-P", "-c", "from workbench.cli import main; main()", *args],
        cwd=folder,
        env={**os.environ, "MARKS": str(folder / "marks")},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow  # three processes one after the other; the same in one process is tested above
def test_two_compare_at_once_after_one_was_killed(tmp_path, instance_folder, stored_json):
    """Each run is marked once: by the one that was killed, or by one of the two that find its claim."""
    (tmp_path / "study.toml").write_text(STUDY)
    killed = compare(tmp_path, "--no-report")
    until = time.monotonic() + 60
    claimed = "*/.*-s1-*.claim"  # the run of seed 0 is stored, that of seed 1 has just begun
    while not list((tmp_path / "runs").glob(claimed)) and time.monotonic() < until:
        time.sleep(0.01)
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert list((tmp_path / "runs").glob(claimed))
    both = [compare(tmp_path), compare(tmp_path)]
    told = [process.communicate(timeout=120)[1] for process in both]
    assert [process.returncode for process in both] == [0, 0], told
    assert Counter((tmp_path / "marks").read_text().split()) == dict.fromkeys("0123", 1)
    assert len(stored_json(tmp_path / "runs")) == 4
    assert all("[3/3]" in text for text in told)
    assert sum(text.count("run by another process") for text in told) == 3
    assert (tmp_path / "runs" / "results.csv").read_text().count("\n") == 5
    assert len(json.loads((tmp_path / "runs" / "study.json").read_text())["runs"]) == 4
    assert not list((tmp_path / "runs").glob("*/.*"))
