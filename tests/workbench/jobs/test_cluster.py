"""A study on a dask.distributed cluster: a worker may die, and nothing is lost or run twice in the results."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

distributed = pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")

STUDY = """
seeds = 3
time_limit = 5
files = ["given/*.json"]

[[solvers]]
name = "misbehaving:Honest"
options = { delay = 0.4 }
"""


@pytest.fixture
def cluster():
    """A scheduler and two workers, each a process of its own; yields the scheduler's address and the workers' pids."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True) as local:
        yield local.scheduler_address, [worker.pid for worker in local.workers.values()]


@pytest.mark.slow
def test_a_worker_killed_half_way_loses_nothing(tmp_path, instance_folder, cluster, stored_json):
    address, (victim, _) = cluster
    (tmp_path / "study.toml").write_text(STUDY)
    program = "from workbench.cli import main; main()"
    args = ["compare", "study.toml", "--out", "runs", "--no-report", "--scheduler", address]
    process = subprocess.Popen(
        [sys.executable, "-c", program, *args], cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    until = time.monotonic() + 60
    while len(stored_json(tmp_path / "runs")) < 3 and time.monotonic() < until:
        time.sleep(0.05)
    os.kill(victim, signal.SIGKILL)
    _, told = process.communicate(timeout=90)
    assert process.returncode == 0, told
    lines = [line for line in told.splitlines() if line.startswith("[")]
    assert len(lines) == 9  # told once each
    assert "[9/9]" in lines[-1]
    runs = stored_json(tmp_path / "runs")
    assert len(runs) == 9
    assert {run["status"] for run in runs.values()} == {"FEASIBLE"}
    assert sorted((run["instance"]["name"], run["seed"]) for run in runs.values()) == [
        (f"r4-2-{k}", seed) for k in range(3) for seed in range(3)
    ]


def test_a_scheduler_that_is_not_there_leaves_no_store(cli, tmp_path, instance_folder, monkeypatch):
    cluster = pytest.importorskip("workbench.jobs.cluster")
    monkeypatch.setattr(cluster, "CONNECT", 0.5)
    (tmp_path / "study.toml").write_text(STUDY)
    code, _, told = cli("compare", "study.toml", "--out", "runs", "--scheduler", "tcp://127.0.0.1:1")
    assert code == 2
    assert told.startswith("workbench: --scheduler: tcp://127.0.0.1:1 cannot be reached")
    assert not (tmp_path / "runs").exists()
