"""A study is run once, whatever interrupts it: what is stored is done."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time

import pytest

MEASURED = "elapsed"
"""In results.csv the columns from this one on are times, memory, machine: they differ between executions."""

STUDY = """
name = "tiny"
seeds = 2
time_limit = 5
files = ["given/*.json"]

[[solvers]]
name = "misbehaving:Honest"
options = { delay = [0.1, 0.3] }

[[solvers]]
name = "misbehaving:Crashes"
seeds = [7]
"""


@pytest.fixture
def study(tmp_path, instance_folder):
    path = tmp_path / "tiny.toml"
    path.write_text(STUDY)
    return path


def unmeasured(path):
    """Return results.csv without its measured columns."""
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    return [row[: rows[0].index(MEASURED)] for row in rows]


def test_compare_runs_stores_and_reports(workbench, study, tmp_path, stored_json):
    done = workbench("compare", study, "--out", "runs", "--jobs", 2)
    assert done.returncode == 0, done.stderr
    runs = stored_json(tmp_path / "runs")
    assert len(runs) == 3 * (2 * 2 + 1)
    assert {run["status"] for name, run in runs.items() if "Honest" in name} == {"FEASIBLE"}
    assert {run["status"] for name, run in runs.items() if "Crashes" in name} == {"ERROR"}
    assert len(unmeasured(tmp_path / "runs" / "results.csv")) == 1 + len(runs)
    assert (tmp_path / "runs" / "report.html").read_text().startswith("<!")
    assert "Solver" in done.stdout
    assert "15/15" in done.stderr
    (environment,) = (tmp_path / "runs" / "environments").glob("*.json")
    assert {run["environment"] for run in runs.values()} == {environment.stem}
    assert set(json.loads((tmp_path / "runs" / "study.json").read_text())["runs"]) == set(runs)


def test_what_is_stored_is_not_run_again_unless_asked(workbench, study, tmp_path, stored_json):
    workbench("compare", study, "--out", "runs")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").glob("r*/*.json")}
    again = workbench("compare", study, "--out", "runs")
    assert "15 of 15 runs are stored already" in again.stderr
    assert {path: path.stat().st_mtime_ns for path in before} == before
    retried = workbench("compare", study, "--out", "runs", "--retry", "error,killed")
    assert retried.returncode == 0
    changed = {path.name for path in before if path.stat().st_mtime_ns != before[path]}
    assert changed == {path.name for path in before if "Crashes" in path.name}


def killed_half_way(args, folder, how: signal.Signals) -> int:
    """Start `compare`, send it a signal once some runs are stored but not all, and return its exit code."""
    program = "from workbench.cli import main; main()"
    process = subprocess.Popen([sys.executable, "-c", program, *args], env=dict(os.environ), stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60
    while len(list(folder.glob("r*/misbehaving*.json"))) < 5 and time.monotonic() < until:
        time.sleep(0.02)
    process.send_signal(how)
    return process.wait(30)


@pytest.mark.parametrize(("how", "code"), [(signal.SIGKILL, -signal.SIGKILL), (signal.SIGINT, 130)])
def test_interrupted_and_started_again_gives_the_same_csv(workbench, study, tmp_path, how, code, stored_json):
    args = ["compare", str(study), "--jobs", "2", "--out"]
    broken, whole = tmp_path / "broken", tmp_path / "whole"
    assert killed_half_way([*args, str(broken)], broken, how) == code
    kept = stored_json(broken)  # every stored run is whole
    assert 5 <= len(kept) < 15
    assert workbench(*args, broken).returncode == 0
    assert workbench(*args, whole).returncode == 0
    assert unmeasured(broken / "results.csv") == unmeasured(whole / "results.csv")
    finished = stored_json(broken)
    assert {name: finished[name] for name in kept} == kept


def test_a_damaged_file_is_named_and_left_alone(workbench, study, tmp_path, stored_json):
    workbench("compare", study, "--out", "runs")
    paths = sorted((tmp_path / "runs").glob("r4-2-0*/*Honest*.json"))
    damaged, foreign = paths[:2]
    damaged.write_text(damaged.read_text()[:100])
    foreign.write_text('{"hello": "world"}')
    again = workbench("compare", study, "--out", "runs", "--retry", "error")
    assert again.returncode == 1
    assert damaged.name in again.stderr
    assert foreign.name in again.stderr
    assert len(damaged.read_text()) == 100
    assert foreign.read_text() == '{"hello": "world"}'
    assert len(unmeasured(tmp_path / "runs" / "results.csv")) == 1 + 13


def test_shards_partition_the_study(workbench, study, tmp_path, stored_json):
    for part in (1, 2, 3):
        assert workbench("compare", study, "--out", f"part{part}", "--shard", f"{part}/3").returncode == 0
    parts = [set(stored_json(tmp_path / f"part{part}")) for part in (1, 2, 3)]
    assert [len(part) for part in parts] == [5, 5, 5]
    assert len(set.union(*parts)) == 15


def test_dry_run_writes_nothing(workbench, study, tmp_path):
    done = workbench("compare", study, "--out", "runs", "--dry-run", "--jobs", 2)
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert len(lines) == 16
    assert lines[-1].startswith("15 runs to do (0 of 15 stored), at most 52 s")
    assert not (tmp_path / "runs").exists()


def test_instances_with_solvers_make_a_study(workbench, instance_folder, tmp_path, stored_json):
    args = ["compare", instance_folder, "--solvers", "misbehaving:Honest", "--time-limit", 3, "--seeds", 2]
    assert workbench(*args, "--out", "runs").returncode == 0
    runs = stored_json(tmp_path / "runs")
    assert sorted((run["instance"]["name"], run["seed"], run["time_limit"]) for run in runs.values()) == [
        (f"r4-2-{k}", seed, 3.0) for k in range(3) for seed in range(2)
    ]


def test_too_many_threads_are_warned_of(workbench, instance_file):
    args = ["compare", instance_file, "--solvers", "misbehaving:Honest", "--threads", 64, "--dry-run"]
    assert "64 threads each" in workbench(*args).stderr
